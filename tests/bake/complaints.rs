//! What users of lightmappers complain about, a small scene each: light that leaks between islands, black texels at borders,
//! seams where pieces meet, stripes on curved surfaces. (Dilation over baked texels: `src/shell/bake/dilate.rs`.)
//!
//! Everything is black but for what lights it, so that the truth is an integral over lamp or sky.

use super::{lightmap, scene};
use glam::{DVec3, Vec3};
use pmcip::bake::atlas::{Atlas, Fineness, GUTTER};
use pmcip::bake::light::Lightmap;
use pmcip::frame::settings::Method;
use pmcip::scene::{LoadedScene, load_lit};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::tracer::shade::irradiance::Unwrapped;
use std::collections::HashMap;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;
use wide::f32x8;

const BOTH: [(Method, Estimator); 2] =
    [(Method::Uniform, Estimator::Pooled), (Method::Pmc, Estimator::Guided)];

/// A parallelogram that shines across its edges, right-handed.
struct Lamp {
    centre: DVec3,
    halves: [DVec3; 2],
    radiance: f64,
}

impl Lamp {
    /// Irradiance at a point of a surface with this normal, nothing being in between: 32×32 parts.
    fn irradiance(&self, point: DVec3, normal: DVec3) -> f64 {
        let [u, v] = self.halves;
        let (area, at) = (4.0 * u.cross(v), |i: u32| (f64::from(i) + 0.5) / 16.0 - 1.0);
        let part = |a: f64, b: f64| {
            let to = self.centre + a * u + b * v - point;
            to.dot(normal).max(0.0) * (-to.dot(area)).max(0.0) / to.length_squared().powi(2)
        };
        let parts = (0..32).flat_map(|i| (0..32).map(move |k| (at(i), at(k))));
        self.radiance * parts.map(|(a, b)| part(a, b)).sum::<f64>() / 1024.0
    }
}

/// The point that a texel shows at its middle.
fn shown(atlas: &Atlas<'_>, texel: usize) -> DVec3 {
    let at = |i: u32| f32x8::splat(i as f32 + 0.5);
    let sites = atlas.sites(at(texel as u32 % atlas.size), at(texel as u32 / atlas.size));
    let p = sites.position;
    [p.x, p.y, p.z].map(|x| f64::from(x.to_array()[0])).into()
}

/// The chart of a triangle, if it has one: that of the texel where its middle is.
fn chart(atlas: &Atlas<'_>, triangle: usize) -> u16 {
    atlas.corners[triangle].map_or(0, |flat| {
        let [x, y] = [0, 1].map(|k| flat.iter().map(|corner| corner[k]).sum::<f32>() / 3.0);
        atlas.labels[y as usize * atlas.size as usize + x as usize]
    })
}

/// The chart of the triangles that have all corners where `holds` says.
fn chart_where(scene: &LoadedScene, atlas: &Atlas<'_>, holds: impl Fn(Vec3) -> bool) -> u16 {
    let fits = |corners: &[[f32; 3]; 3]| corners.iter().all(|corner| holds((*corner).into()));
    chart(atlas, scene.triangles.iter().position(|triangle| fits(&triangle.corners)).unwrap())
}

/// Texels at most `rings` away from one.
fn around(size: u32, texel: usize, rings: usize) -> impl Iterator<Item = usize> {
    let (size, x, y) = (size as usize, texel % size as usize, texel / size as usize);
    let near = move |at: usize| at.saturating_sub(rings)..(at + rings + 1).min(size);
    near(y).flat_map(move |y| near(x).map(move |x| y * size + x))
}

/// Two floors side by side in a plane, a wall between them, each below a lamp of its own, of which one is a thousand times as
/// bright. In the atlas they are neighbours, and nothing but their light tells them apart.
#[test]
fn no_light_leaks_from_a_bright_island_into_a_dark_one() {
    let folder = tempfile::tempdir().unwrap();
    let mut obj = String::from("mtllib s.mtl\n");
    for (x, y, half) in [(0.0, 0.0, 1.0), (4.0, 0.0, 1.0), (0.0, 1.0, 0.2), (4.0, 1.0, 0.2)] {
        for (u, v) in [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
            obj += &format!("v {} {y} {}\n", x + u * half, v * half);
        }
    }
    obj += "v 2 -.1 -1\nv 2 1.2 -1\nv 2 1.2 1\nv 2 -.1 1\nusemtl floor\nf 1 2 3 4\nf 5 6 7 8\nf 17 18 19 20\n\
            usemtl bright\nf 12 11 10 9\nusemtl dark\nf 16 15 14 13\n";
    let mtl = "newmtl floor\nKd 0 0 0\nnewmtl bright\nKd 0 0 0\nKe 20 20 20\nnewmtl dark\nKd 0 0 0\nKe .02 .02 .02\n";
    let scene = scene(folder.path(), &obj, mtl);
    let atlas = Atlas::new(&scene, Fineness::Size(128)).unwrap();
    let floor = |middle: f32| chart_where(&scene, &atlas, |at| at.y == 0.0 && (at.x - middle).abs() < 1.5);
    let (bright, dark) = (floor(0.0), floor(4.0));
    let texels = || 0..atlas.labels.len();
    let near = |i| around(atlas.size, i, 2 * GUTTER as usize + 2).any(|k| atlas.labels[k] == bright);
    assert!(bright != dark && texels().any(|i| atlas.labels[i] == dark && near(i)));
    let lamp =
        Lamp { centre: DVec3::new(4.0, 1.0, 0.0), halves: [DVec3::X * 0.2, DVec3::Z * 0.2], radiance: 0.02 };
    let truths: HashMap<usize, f64> = texels()
        .filter(|i| atlas.labels[*i] == dark)
        .map(|i| (i, lamp.irradiance(shown(&atlas, i), DVec3::Y)))
        .collect();
    let most = truths.values().fold(0.0, |most: f64, truth| most.max(*truth));
    let baked = lightmap(&scene, &atlas, Method::Pmc, Estimator::Guided, (16, 1));
    let value = |i: usize| f64::from(baked.irradiance[i][0]);
    let off = |value: &dyn Fn(usize) -> f64| {
        let mean = truths.keys().map(|i| value(*i)).sum::<f64>() / truths.values().sum::<f64>() - 1.0;
        (mean, truths.iter().map(|(i, truth)| (value(*i) - truth).abs() / most).fold(0.0, f64::max))
    };
    // A thousandth of the bright one would double it. Few samples go there: single texels have noise, their mean has little.
    let (mean, worst) = off(&value);
    assert!(mean.abs() < 0.01 && worst < 0.5, "mean {mean}, worst {worst}");
    // A filter that knows no islands does not pass.
    let reach = 2 * GUTTER as usize + 2;
    let blurred = |i: usize| {
        let near: Vec<f64> =
            around(atlas.size, i, reach).filter(|k| atlas.labels[*k] != 0).map(value).collect();
        near.iter().sum::<f64>() / near.len() as f64
    };
    let (mean, worst) = off(&blurred);
    assert!(mean > 0.1 && worst > 5.0, "blurred: mean {mean}, worst {worst}");
    // What a bilinear filter finds beside it, too.
    for i in texels().filter(|i| around(atlas.size, *i, 1).any(|k| atlas.labels[k] == dark)) {
        assert!(value(i) < 1.5 * most, "{i}: {}", value(i));
    }
}

/// A floor between black walls, turned so that edges run across texels and no coordinate is exact: texels at the border show
/// points of the very edge, where walls begin.
#[test]
fn no_texel_at_a_border_is_too_dark() {
    let folder = tempfile::tempdir().unwrap();
    let (sin, cos) = 0.5f64.sin_cos();
    let turned = |x: f64, y: f64, z: f64| DVec3::new(x * cos + z * sin, y, z * cos - x * sin);
    let mut obj = String::from("mtllib s.mtl\n");
    for (y, half) in [(0.1, 1.0), (0.7, 1.0), (2.1, 0.5)] {
        for (x, z) in [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
            let p = turned(x * half, y, z * half);
            obj += &format!("v {} {} {}\n", p.x, p.y, p.z);
        }
    }
    obj += "usemtl floor\nf 1 2 3 4\nf 2 1 5 6\nf 3 2 6 7\nf 4 3 7 8\nf 1 4 8 5\nusemtl lamp\nf 12 11 10 9\n";
    let scene = scene(folder.path(), &obj, super::FLOOR_MTL);
    let lamp = Lamp {
        centre: turned(0.0, 2.1, 0.0),
        halves: [turned(0.5, 0.0, 0.0), turned(0.0, 0.0, 0.5)],
        radiance: 20.0,
    };
    let atlas = Atlas::new(&scene, Fineness::Density(16.0)).unwrap();
    let floor = chart_where(&scene, &atlas, |corner| corner.y < 0.2);
    let truths: HashMap<usize, f64> = (0..atlas.labels.len())
        .filter(|i| atlas.labels[*i] == floor)
        .map(|i| (i, lamp.irradiance(shown(&atlas, i), DVec3::Y)))
        .collect();
    assert!(truths.len() > 1000);
    for (method, estimator) in BOTH {
        let baked = lightmap(&scene, &atlas, method, estimator, (64, 1));
        for (i, truth) in &truths {
            let ratio = f64::from(baked.irradiance[*i][0]) / truth;
            assert!(ratio > 0.95, "{estimator:?}, texel {i}: {ratio} of the truth");
            // Texels beside the island have what its border has.
            for k in around(atlas.size, *i, 1).filter(|k| atlas.labels[*k] == 0) {
                let least =
                    around(atlas.size, k, 1).filter_map(|j| truths.get(&j)).fold(*truth, |a, b| a.min(*b));
                let ratio = f64::from(baked.irradiance[k][0]) / least;
                assert!(ratio > 0.95, "{estimator:?}, texel {k} beside {i}: {ratio} of the truth");
            }
        }
    }
}

/// Irradiance on both sides of every edge where two charts meet with the same normals, at nine places of it, with the place.
fn seams(scene: &LoadedScene, atlas: &Atlas<'_>, baked: &Lightmap) -> Vec<(Vec3, [f32; 2])> {
    // By its ends in space: the labels of the charts that have it, and where.
    let mut sides = HashMap::<[[u32; 3]; 2], Vec<(u16, [[f32; 2]; 2])>>::new();
    for (i, triangle) in scene.triangles.iter().enumerate() {
        let Some(flat) = atlas.corners[i] else { continue };
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let mut ends = [a, b].map(|k| (triangle.corners[k].map(|x| (x + 0.0).to_bits()), flat[k]));
            ends.sort_by_key(|end| end.0);
            sides.entry(ends.map(|end| end.0)).or_default().push((chart(atlas, i), ends.map(|end| end.1)));
        }
    }
    let mut found = Vec::new();
    for (ends, sides) in sides {
        let [(first, from), (second, to)] = sides[..] else { continue };
        for t in (1..10).map(|i| i as f32 / 10.0).filter(|_| first != second) {
            let on = |[a, b]: [[f32; 2]; 2]| baked.at([0, 1].map(|k| a[k] + (b[k] - a[k]) * t))[0];
            let [a, b] = ends.map(|end| Vec3::from(end.map(f32::from_bits)));
            found.push((a.lerp(b, t), [on(from), on(to)]));
        }
    }
    found
}

/// A floor of four tiles that know nothing of each other.
#[test]
fn tiles_meet_without_a_seam() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("tile.obj"), "v 0 0 1\nv 1 0 1\nv 1 0 0\nv 0 0 0\nf 1 2 3 4\n").unwrap();
    let mut toml = String::from("[materials.black]\ndiffuse = [0, 0, 0]\n");
    for (x, z) in [(-1, -1), (0, -1), (-1, 0), (0, 0)] {
        toml +=
            &format!("[[meshes]]\nfile = \"tile.obj\"\nmaterial = \"black\"\ntranslate = [{x}, 0, {z}]\n");
    }
    toml += "[[lights]]\ncenter = [0, 2, 0]\nedge_u = [0.5, 0, 0]\nedge_v = [0, 0, 0.5]\nradiance = [20, 20, 20]\n";
    let scene = written(folder.path(), &toml);
    let atlas = Atlas::new(&scene, Fineness::Density(32.0)).unwrap();
    for (method, estimator) in BOTH {
        let baked = lightmap(&scene, &atlas, method, estimator, (64, 1));
        let found = seams(&scene, &atlas, &baked);
        assert_eq!(found.len(), 4 * 9);
        agree(&found, 0.01);
    }
}

/// Both sides of all seams are within this part of each other.
fn agree(seams: &[(Vec3, [f32; 2])], part: f32) {
    for (place, [a, b]) in seams {
        assert!((a - b).abs() < part * a.max(*b), "{place}: {a} and {b}");
    }
}

fn written(folder: &Path, toml: &str) -> LoadedScene {
    fs::write(folder.join("s.toml"), toml).unwrap();
    load_lit(&folder.join("s.toml")).unwrap()
}

/// Facets around the pillar of the next two tests.
const FACETS: usize = 32;

/// A pillar of radius 1 and height 2 whose normals are smooth.
fn pillar(folder: &Path, light: &str) -> LoadedScene {
    let mut obj = String::new();
    for i in 0..FACETS {
        let (sin, cos) = (2.0 * PI * i as f64 / FACETS as f64).sin_cos();
        obj += &format!("v {cos} 0 {sin}\nv {cos} 2 {sin}\nvn {cos} 0 {sin}\n");
    }
    for i in 0..FACETS {
        let (n, m) = (i + 1, (i + 1) % FACETS + 1);
        let (a, b, c, d) = (2 * n - 1, 2 * n, 2 * m, 2 * m - 1);
        obj += &format!("f {a}//{n} {b}//{n} {c}//{m} {d}//{m}\n");
    }
    fs::write(folder.join("pillar.obj"), obj).unwrap();
    let black =
        "[materials.black]\ndiffuse = [0, 0, 0]\n[[meshes]]\nfile = \"pillar.obj\"\nmaterial = \"black\"\n";
    written(folder, &format!("{black}{light}"))
}

/// Irradiance over the truth in stripes along the pillar, two a facet, by the cosine of the stripe's middle to the x axis.
fn stripes(atlas: &Atlas<'_>, baked: &Lightmap, truth: impl Fn(DVec3, DVec3) -> f64) -> Vec<(f64, f64)> {
    let mut stripes = vec![(0.0, 0.0); 2 * FACETS];
    for i in (0..atlas.labels.len()).filter(|i| atlas.labels[*i] != 0) {
        let point = shown(atlas, i);
        let normal = DVec3::new(point.x, 0.0, point.z);
        if (normal.length() - 1.0).abs() < 0.1 {
            let turn = normal.z.atan2(normal.x) / (2.0 * PI) + 0.5;
            let (sum, all) = &mut stripes[(turn * 2.0 * FACETS as f64) as usize % (2 * FACETS)];
            *sum += f64::from(baked.irradiance[i][0]);
            *all += truth(point, normal.normalize());
        }
    }
    let cosine = |i: usize| (2.0 * PI * ((i as f64 + 0.5) / (2.0 * FACETS as f64) - 0.5)).cos();
    stripes.iter().enumerate().map(|(i, (sum, all))| (cosine(i), sum / all)).collect()
}

/// An even sky lights everything that is convex evenly: π times its radiance. Where facets meet, the sky that a smooth normal
/// sees and the facet hides is (1 − cos(π / 32)) / 2, a quarter of a percent.
#[test]
fn an_even_sky_makes_no_stripes_on_a_pillar() {
    let folder = tempfile::tempdir().unwrap();
    let scene = pillar(folder.path(), "[sky]\ncolor = [1, 1, 1]\n");
    let atlas = Atlas::new(&scene, Fineness::Density(24.0)).unwrap();
    for (method, estimator) in BOTH {
        let baked = lightmap(&scene, &atlas, method, estimator, (64, 1));
        for (cosine, ratio) in stripes(&atlas, &baked, |_, _| PI) {
            assert!((ratio - 1.0).abs() < 0.005, "{estimator:?}, {cosine}: {ratio}");
        }
        let found = seams(&scene, &atlas, &baked);
        assert!(found.len() >= 4 * 9, "{}", found.len());
        agree(&found, 0.03);
    }
}

/// A lamp of 4×4 at a distance of 5 shades a pillar as its smooth normals say, as long as no facet looks past it.
#[test]
fn a_lamp_makes_no_stripes_on_a_pillar() {
    let folder = tempfile::tempdir().unwrap();
    let light =
        "[[lights]]\ncenter = [5, 1, 0]\nedge_u = [0, 0, 2]\nedge_v = [0, 2, 0]\nradiance = [1, 1, 1]\n";
    let scene = pillar(folder.path(), light);
    let lamp =
        Lamp { centre: DVec3::new(5.0, 1.0, 0.0), halves: [DVec3::Z * 2.0, DVec3::Y * 2.0], radiance: 1.0 };
    let atlas = Atlas::new(&scene, Fineness::Density(24.0)).unwrap();
    for (method, estimator) in BOTH {
        let baked = lightmap(&scene, &atlas, method, estimator, (64, 1));
        for (cosine, ratio) in stripes(&atlas, &baked, |point, normal| lamp.irradiance(point, normal)) {
            let far = cosine < 0.5;
            assert!(far || (ratio - 1.0).abs() < 0.01, "{estimator:?}, {cosine}: {ratio}");
        }
        // From the corner at x = 0.56 on a facet looks past a part of the lamp: there the sides of a seam do differ.
        let lit: Vec<_> = seams(&scene, &atlas, &baked).into_iter().filter(|(at, _)| at.x > 0.6).collect();
        assert!(lit.len() >= 9, "{}", lit.len());
        agree(&lit, 0.02);
    }
}
