//! Sky, lens and shutter from files and the command line to pictures: what is read, what is refused, what is seen.

mod program;
mod scene_files;

use pmcip::frame::render::render;
use pmcip::frame::settings::{Integrator, Method, Settings};
use pmcip::picture::frame_io::{Picture, read_exr, write_exr};
use pmcip::scene::{Animation, LoadedScene, Moved, SkyMap, load};
use program::{failure, success};
use scene_files::{folder, load_files};
use std::path::Path;
use tempfile::TempDir;

const BALL: &str = "[[spheres]]\ncenter = [0, 0, 0]\nradius = 1\nsubdivisions = 3\nmaterial = \"m\"\n[materials.m]\n\
    diffuse = [0.5, 0.5, 0.5]\n";
const VIEW: &str = "[film]\nwidth = 24\nheight = 24\n[camera]\nfrom = [0, 0, 6]\nat = [0, 0, 0]\nfov = 40\n";

/// The ball before a camera, and a sky.
fn ball(sky: &str) -> String {
    format!("{VIEW}[sky]\n{sky}\n{BALL}")
}

/// A sky of 8×4 texels as EXR: 0 but for one of the row below the upper one, in the middle of the left half (+x).
fn write_sky(folder: &Path, name: &str, change: impl Fn(&mut Vec<[f32; 3]>)) {
    let mut rgb = vec![[0.0; 3]; 32];
    rgb[8 + 1] = [4.0, 2.0, 1.0];
    rgb[8 + 2] = [4.0, 2.0, 1.0];
    change(&mut rgb);
    write_exr(&folder.join(name), &Picture { width: 8, height: 4, rgb, ..Picture::default() }).unwrap();
}

/// The same as Radiance HDR, without compression.
fn write_hdr(folder: &Path, name: &str) {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
    // 4, 2 and 1 are 128, 64 and 32 times 2⁻⁵; the exponent is kept with an excess of 128 + 8.
    let texel = |i: usize| if i == 9 || i == 10 { [128, 64, 32, 131] } else { [0; 4] };
    bytes.extend((0..32).flat_map(texel));
    std::fs::write(folder.join(name), bytes).unwrap();
}

fn sky_folder() -> TempDir {
    let folder = folder(&[("s.toml", &ball("file = \"sky.exr\""))]);
    write_sky(folder.path(), "sky.exr", |_| ());
    write_hdr(folder.path(), "sky.hdr");
    folder
}

fn mean(scene: &LoadedScene, spp: u32, seed: u32) -> [f64; 3] {
    let mut settings = Settings::new(scene, Method::Uniform, Some(spp), Some((24, 24)));
    settings.sampler.seed = seed;
    let frame = render(scene, &settings, None, &|_| ()).unwrap();
    [0, 1, 2].map(|c| frame.rgb.iter().map(|rgb| f64::from(rgb[c])).sum::<f64>() / 576.0)
}

#[test]
fn pictures_of_the_sky_are_read() {
    let folder = sky_folder();
    let (exr, warnings) = SkyMap::load(&folder.path().join("sky.exr")).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!((exr.width, exr.height, exr.texels[9]), (8, 4, [4.0, 2.0, 1.0]));
    let (hdr, warnings) = SkyMap::load(&folder.path().join("sky.hdr")).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(hdr.texels, exr.texels);
    let scaled = load_files(&[("s.toml", &ball("color = [1, 2, 3]\nscale = 0.5\nvisible = false"))]);
    let sky = scaled.sky.unwrap();
    assert_eq!((sky.texels.as_slice(), sky.visible), (&[[0.5, 1.0, 1.5]][..], false));
}

#[test]
fn odd_pictures_are_mended_and_named() {
    let folder = sky_folder();
    write_sky(folder.path(), "odd.exr", |rgb| {
        (rgb[0][0], rgb[1][1], rgb[2][2]) = (f32::NAN, -1.0, f32::INFINITY)
    });
    let (sky, warnings) = SkyMap::load(&folder.path().join("odd.exr")).unwrap();
    assert_eq!(sky.texels[..3], [[0.0; 3], [0.0; 3], [0.0, 0.0, 65504.0]]);
    assert!(warnings[0].contains("3 texels are negative, infinite or not a number"), "{warnings:?}");
    let square = Picture { width: 4, height: 4, rgb: vec![[1.0; 3]; 16], ..Picture::default() };
    write_exr(&folder.path().join("square.exr"), &square).unwrap();
    let (_, warnings) = SkyMap::load(&folder.path().join("square.exr")).unwrap();
    assert!(warnings[0].contains("this one is 4x4"), "{warnings:?}");
}

/// A size that no memory holds is refused before any is asked for.
#[test]
fn skies_without_bounds_are_refused() {
    let folder = sky_folder();
    let mut bytes = std::fs::read(folder.path().join("sky.exr")).unwrap();
    for name in [&b"dataWindow\0"[..], &b"displayWindow\0"[..]] {
        let at = bytes.windows(name.len()).position(|part| part == name).unwrap();
        // Name, type, length of the value, then its lower and upper corner.
        let corner = at + name.len() + b"box2i\0".len() + 4 + 8;
        bytes[corner..corner + 8].copy_from_slice(&[0xff, 0xff, 0xff, 0x0f, 0xff, 0xff, 0xff, 0x0f]);
    }
    std::fs::write(folder.path().join("huge.exr"), bytes).unwrap();
    let error = SkyMap::load(&folder.path().join("huge.exr")).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("huge.exr: ") && !error.contains('\n'), "{error}");
}

#[track_caller]
fn refused(toml: &str, words: &str) {
    let folder = folder(&[("s.toml", toml), ("text.hdr", "no picture")]);
    let message = load(&folder.path().join("s.toml")).map(|_| ()).unwrap_err().to_string();
    assert!(message.contains(words) && !message.contains('\n'), "{message}");
}

#[test]
fn skies_that_are_none_are_refused_by_line() {
    let one = "s.toml:8: sky: expected one of file, color and sun";
    refused(&ball(""), one);
    refused(&ball("file = \"a.exr\"\ncolor = [1, 1, 1]"), one);
    refused(&ball("sun = [0, 0, 0]"), "s.toml:8: sky: sun has no direction");
    refused(&ball("color = [1, 1, 1]\nhaze = 2"), "s.toml:8: sky: haze and ground need sun");
    refused(&ball("color = [1, -1, 1]"), "s.toml:9");
    refused(&ball("colour = [1, 1, 1]"), "s.toml:9");
    refused(&ball("file = \"gone.exr\""), "gone.exr: ");
    refused(&ball("file = \"sky.png\""), "sky.png: a sky is an .exr or .hdr file");
    refused(&ball("file = \"text.hdr\""), "text.hdr: Format error decoding Hdr");
    refused(&VIEW.replace("fov = 40", "fov = 40\nfocus = 0"), "s.toml:8");
    refused(&VIEW.replace("fov = 40", "fov = 40\naperture = -1"), "s.toml:8");
}

/// Light from +x falls on the right half of the ball; turned by a quarter about y it comes from −z, behind the ball.
#[test]
fn the_sky_turns_as_meshes_do() {
    let folder = sky_folder();
    let lit = |rotate: &str| {
        let text = ball(&format!("file = \"sky.exr\"\nvisible = false\n{rotate}"));
        std::fs::write(folder.path().join("s.toml"), text).unwrap();
        let scene = load(&folder.path().join("s.toml")).unwrap();
        let settings = Settings::new(&scene, Method::Uniform, Some(64), Some((24, 24)));
        let frame = render(&scene, &settings, None, &|_| ()).unwrap();
        let half = |right: usize| {
            let row = |y: usize| (0..12).map(move |x| y * 24 + 12 * right + x);
            (0..24).flat_map(row).map(|i| f64::from(frame.rgb[i][0])).sum::<f64>()
        };
        (half(0), half(1))
    };
    let (left, right) = lit("");
    assert!(right > 5.0 * left, "{left} {right}");
    let (left, right) = lit("rotate = [0, 180, 0]");
    assert!(left > 5.0 * right, "{left} {right}");
    let (behind, also) = lit("rotate = [0, 90, 0]");
    assert!(behind + also < 0.3 * (left + right), "{behind} {also}");
}

/// The command's sky takes the place of none or of the scene's; coverage is 1 where a sky is seen.
#[test]
fn skies_of_the_command_line() {
    let folder = sky_folder();
    let path = folder.path();
    std::fs::write(path.join("dark.toml"), format!("{VIEW}{BALL}")).unwrap();
    failure(path, "render dark.toml --spp 4", 2, "no light: add [[lights]], a [sky]");
    success(path, "render dark.toml --sky sky.hdr --spp 4 --layers A,albedo,depth -o a.exr");
    let picture = read_exr(&path.join("a.exr")).unwrap();
    assert!(picture.planes["A"].iter().all(|a| *a == 1.0), "a sky that is seen covers everything");
    assert_eq!((picture.planes["depth.Z"][0], &*picture.attributes["sky"]), (1e10, "sky.hdr"));
    std::fs::write(path.join("hidden.toml"), ball("color = [1, 1, 1]\nvisible = false")).unwrap();
    success(path, "render hidden.toml --spp 4 --layers A,albedo -o b.exr");
    let picture = read_exr(&path.join("b.exr")).unwrap();
    let (corner, middle) = (0, 12 * 24 + 12);
    assert_eq!((picture.planes["A"][corner], picture.planes["A"][middle]), (0.0, 1.0));
    assert_eq!((picture.rgb[corner], picture.planes["albedo.R"][corner]), ([0.0; 3], 0.0));
    std::fs::write(path.join("shown.toml"), ball("color = [0.5, 3, 0.25]")).unwrap();
    success(path, "render shown.toml --spp 4 --layers albedo -o c.exr");
    let albedo = read_exr(&path.join("c.exr")).unwrap().planes;
    assert_eq!([&albedo["albedo.R"], &albedo["albedo.G"]].map(|a| a[corner]), [0.5, 1.0]);
    failure(path, "render dark.toml --sky sky.png", 2, "must end in .exr or .hdr");
    failure(path, "render dark.toml --sky gone.exr", 2, "gone.exr: ");
}

/// A ball of radius 1 before black covers π/(6 tan 20°)² · 4 of the picture, sharp or not; out of focus it reaches further.
#[test]
fn a_lens_blurs_what_is_out_of_focus() {
    let sky = "color = [1, 1, 1]\nvisible = false\n[[lights]]\ncenter = [0, 0, -50]\nedge_u = [1, 0, 0]\nedge_v = [0, 1, 0]\n\
        radiance = [0, 0, 0]";
    let scene =
        |lens: &str| load_files(&[("s.toml", &ball(sky).replace("fov = 40", &format!("fov = 40\n{lens}")))]);
    let lit = |lens: &str| {
        let scene = scene(lens);
        let settings = Settings::new(&scene, Method::Uniform, Some(64), Some((24, 24)));
        let frame = render(&scene, &settings, None, &|_| ()).unwrap();
        let total = frame.rgb.iter().map(|rgb| f64::from(rgb[0])).sum::<f64>();
        (frame.rgb.iter().filter(|rgb| rgb[0] > 0.0).count(), total)
    };
    let (sharp, light) = lit("");
    let (focused, focused_light) = lit("aperture = 0.2");
    let (blurred, blurred_light) = lit("aperture = 1.0\nfocus = 2.0");
    assert!(focused < sharp + 30 && blurred > sharp + 100, "{sharp} {focused} {blurred}");
    // The blur moves light about, little of it out of the picture or closer to the silhouette's far side.
    assert!((focused_light / light - 1.0).abs() < 0.01, "{light} {focused_light}");
    assert!((blurred_light / light - 1.0).abs() < 0.05, "{light} {blurred_light}");
}

const PAN: &str = "[frames]\nfirst = 0\nlast = 16\nshutter = SHUTTER\n[film]\nwidth = 24\nheight = 24\n\
    [camera]\nfrom = [-1, 0, 6]\nat = [-1, 0, 0]\nfov = 40\ninterpolation = \"linear\"\n\
    keys = [{ frame = 0, from = [-1, 0, 6], at = [-1, 0, 0] }, { frame = 16, from = [1, 0, 6], at = [1, 0, 0] }]\n\
    [sky]\ncolor = [1, 1, 1]\nvisible = false\n";

/// A frame of an open shutter is the mean of frames at times in between: here of 32 on the same way,
/// two between any of its frames.
#[test]
fn an_open_shutter_shows_the_mean_of_its_time() {
    let picture = |scene: &LoadedScene, seed: u32, spp: u32| {
        let mut settings = Settings::new(scene, Method::Uniform, Some(spp), Some((24, 24)));
        settings.sampler.seed = seed;
        render(scene, &settings, None, &|_| ()).unwrap().rgb
    };
    // One frame of which the whole way is open: keys 16 times as close.
    let text = PAN.replace("SHUTTER", "1.0").replace("frame = 16", "frame = 1") + BALL;
    let folder = folder(&[("s.toml", &text)]);
    let open = load(&folder.path().join("s.toml")).unwrap();
    assert!(open.closing_view.is_some());
    let blurred = picture(&open, 1, 1024);
    let folder = scene_files::folder(&[("s.toml", &(PAN.replace("SHUTTER", "0.0") + BALL))]);
    let mut still = Animation::load(&folder.path().join("s.toml")).unwrap();
    let mut mean = vec![0.0; 576];
    for half in 0..32 {
        // Animations stand at whole frames.
        let view = {
            still.seek(half / 2).unwrap();
            let now = still.scene().view;
            still.seek(half / 2 + 1).unwrap();
            let next = still.scene().view;
            let part = if half % 2 == 0 { 0.25 } else { 0.75 };
            let mix = |a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|c| a[c] + (b[c] - a[c]) * part);
            pmcip::scene::View { from: mix(now.from, next.from), at: mix(now.at, next.at), ..now }
        };
        let scene = LoadedScene { view, closing_view: None, ..still.scene().clone() };
        picture(&scene, half, 64)
            .iter()
            .zip(&mut mean)
            .for_each(|(rgb, mean)| *mean += f64::from(rgb[0]) / 32.0);
    }
    let off = blurred.iter().zip(&mean).map(|(a, b)| (f64::from(a[0]) - b).abs()).fold(0.0, f64::max);
    let sharp = picture(&LoadedScene { closing_view: None, ..open.clone() }, 1, 1024);
    let control = sharp.iter().zip(&mean).map(|(a, b)| (f64::from(a[0]) - b).abs()).fold(0.0, f64::max);
    // Noise of 1000 samples of values from 0 to ½, and 32 positions instead of all.
    assert!(off < 0.04, "{off}");
    assert!(control > 0.2, "the control does not fail: {control}");
}

/// A ball that grows as it flies, below a lamp that flies, too, and one that stays: enough of them for a tree.
const FLIGHT: &str = "[frames]\nfirst = 0\nlast = LAST\nshutter = SHUTTER\n[film]\nwidth = 24\nheight = 24\n\
    [camera]\nfrom = [0, 1, 6]\nat = [0, 0.3, 0]\nfov = 40\n\
    [[spheres]]\nsubdivisions = 3\ncenter = [-1, 0, 0]\nradius = 0.6\nmaterial = \"m\"\ninterpolation = \"linear\"\n\
    keys = [{ frame = 0, center = [-1, 0, 0], radius = 0.6 }, { frame = LAST, center = [1, 0.5, 0], radius = 0.9 }]\n\
    [[spheres]]\nsubdivisions = 4\ncenter = [0, -51, 0]\nradius = 50\nmaterial = \"m\"\n\
    [[lights]]\ncenter = [-1.5, 3, 0]\nedge_u = [0.5, 0, 0]\nedge_v = [0, 0, 0.5]\nradiance = [9, 9, 9]\n\
    interpolation = \"linear\"\n\
    keys = [{ frame = 0, center = [-1.5, 3, 0] }, { frame = LAST, center = [1.5, 3, 1] }]\n\
    [[lights]]\ncenter = [0, 4, 3]\nedge_u = [0.5, 0, 0]\nedge_v = [0, 0, 0.5]\nradiance = [5, 5, 5]\n\
    [materials.m]\ndiffuse = [0.5, 0.5, 0.5]\nspecular = [0.1, 0.1, 0.1]\nroughness = 0.2\n";

/// Means and standard errors of a picture's pixels, and of their sum as the last, over eight seeds of `scene`.
fn measured(scenes: &[LoadedScene], integrator: Integrator, spp: u32) -> Vec<(f64, f64)> {
    let picture = |seed: u32| {
        let mut sum = vec![0.0; 577];
        for (number, scene) in (0..).zip(scenes) {
            let mut settings = Settings::new(scene, Method::Uniform, Some(spp), Some((24, 24)));
            settings.sampler.seed = 1000 * seed + number;
            (settings.integrator, settings.max_depth) = (integrator, 3);
            let rgb = render(scene, &settings, None, &|_| ()).unwrap().rgb;
            for (i, [r, ..]) in rgb.into_iter().enumerate() {
                sum[i] += f64::from(r) / scenes.len() as f64;
                sum[576] += f64::from(r) / scenes.len() as f64;
            }
        }
        sum
    };
    let runs: Vec<_> = (1..=8).map(picture).collect();
    let of = |i: usize| {
        let mean = runs.iter().map(|run| run[i]).sum::<f64>() / 8.0;
        let square = runs.iter().map(|run| (run[i] - mean).powi(2)).sum::<f64>();
        (mean, (square / 7.0 / 8.0).sqrt())
    };
    (0..577).map(of).collect()
}

/// Objects and lamps that move while the shutter is open look as the mean of 32 times in between, of the path tracer and of
/// direct lighting, and all light is there.
#[test]
fn what_moves_while_the_shutter_is_open_is_the_mean_of_its_time() {
    let text = |shutter: &str, last: &str| FLIGHT.replace("SHUTTER", shutter).replace("LAST", last);
    let folder = folder(&[("open.toml", &text("1.0", "1")), ("still.toml", &text("0.0", "64"))]);
    let open = [load(&folder.path().join("open.toml")).unwrap()];
    assert!(!open[0].moved.triangles.is_empty() && !open[0].light_nodes.is_empty());
    let mut animation = Animation::load(&folder.path().join("still.toml")).unwrap();
    let stills: Vec<_> = (0..32)
        .map(|half| {
            animation.seek(2 * half + 1).unwrap();
            animation.scene().clone()
        })
        .collect();
    assert!(stills[0].moved.triangles.is_empty());
    for integrator in [Integrator::Path, Integrator::Direct { light_samples: 1, bsdf_samples: 1 }] {
        let (moving, mean) = (measured(&open, integrator, 128), measured(&stills, integrator, 8));
        let off = |a: &[(f64, f64)], i: usize| (a[i].0 - mean[i].0).abs();
        let (total, error) =
            (off(&moving, 576) / mean[576].0, moving[576].1.hypot(mean[576].1) / mean[576].0);
        assert!(total < 4.0 * error && error < 2e-3, "{integrator:?}: {total} ± {error}");
        let still = [LoadedScene { moved: Moved::default(), ..open[0].clone() }];
        let control = measured(&still, integrator, 16);
        let off_control = off(&control, 576) / mean[576].0;
        assert!(off_control > 20.0 * error, "the control does not fail: {off_control} ± {error}");
        // Pixels are up to ½ with standard errors of some thousandths, and what flies passes in 32 steps.
        let worst = |a: &[(f64, f64)]| (0..576).map(|i| off(a, i)).fold(0.0, f64::max);
        assert!(worst(&moving) < 0.02 && worst(&control) > 0.1, "{} {}", worst(&moving), worst(&control));
    }
}

/// The sun has the direction it is given, and cd_per_unit makes of its luminance what the scene calls radiance.
#[test]
fn sun_and_sky_by_direction() {
    let sun = |more: &str| load_files(&[("s.toml", &ball(&format!("sun = [3, 4, 0]\n{more}")))]).sky.unwrap();
    let day = sun("");
    assert_eq!(day.sun.unwrap().direction.map(|v| (v * 1e6).round() / 1e6), [0.6, 0.8, 0.0]);
    let turned = sun("rotate = [0, 90, 0]\nscale = 2").sun.unwrap();
    assert_eq!(turned.direction.map(|v| (v * 1e6).round() / 1e6), [0.0, 0.8, -0.6]);
    assert_eq!(turned.radiance, day.sun.unwrap().radiance.map(|v| 2.0 * v));
    // 128 klx less what the air takes, on a surface that faces the sun.
    let lux = 100.0 * day.sun.unwrap().radiance[1] * day.sun.unwrap().solid_angle();
    assert!((8e4..1.2e5).contains(&lux), "{lux}");
    let scene = load_files(&[("s.toml", &ball("sun = [3, 4, 0]\nvisible = false"))]);
    assert!(mean(&scene, 4, 0)[0] > 10.0);
}
