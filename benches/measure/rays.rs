//! Rays a second of one thread: primary, shadow and diffuse-bounce rays, ours beside obvhs's own traversal.
//!
//! `cargo run --release -p measure -- rays SCENE [ROUNDS [FROM AT FOV WIDTH HEIGHT]]` prints a Markdown table of Mrays/s, the
//! median of the rounds (default 7), in which the traversals take turns, and what the hierarchy is like. FROM and AT are points
//! as X,Y,Z, FOV the vertical angle in degrees: another camera than the scene's, for files that have none. The rays are those
//! a renderer makes: two million
//! primary rays through blocks of 4×2 pixels, from each hit a shadow ray to the first light's rectangle and a
//! cosine-distributed bounce. Generator and order are written down, so that a small program for another tracer
//! can make the same rays.

use glam::Vec3A;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::{Ray, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::{BvhBuildParams, bvh2::Bvh2, triangle::Triangle};
use pmcip::scene::{self, LoadedScene};
use pmcip_core::maths::vec3::Vec3x8;
use pmcip_core::tracer::scene::Scene;
use pmcip_core::tracer::trace::{MISS, Rays8, Tracer};
use std::path::Path;
use std::time::{Duration, Instant};
use wide::f32x8;

/// Primary rays, about.
const PRIMARY: usize = 2_000_000;

/// How far off a surface rays start, in scene units.
const OFFSET: f32 = 1e-4;

struct One {
    origin: Vec3A,
    direction: Vec3A,
    t_max: f32,
}

/// The permuted congruential generator PCG32 with a fixed stream.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let word = (((self.0 >> 18) ^ self.0) >> 27) as u32;
        (word.rotate_right((self.0 >> 59) as u32) >> 8) as f32 / 16_777_216.0
    }
}

/// The rays of the three kinds.
struct Workload {
    primary: Vec<Rays8>,
    shadow: Vec<Rays8>,
    bounce: Vec<Rays8>,
}

/// Prints the table.
pub fn run(arguments: &[String]) {
    let mut arguments = arguments.iter();
    let path = arguments.next().expect("a scene");
    let rounds = arguments.next().map_or(7, |n| n.parse().expect("a number of rounds"));
    let mut loaded = scene::load(Path::new(&path)).expect("the scene loads");
    if let Some(from) = arguments.next() {
        look(&mut loaded, from, arguments.map(String::as_str).collect());
    }
    let mut tracer = Tracer::new(Scene::new(loaded.data()).expect("the scene is valid"));
    let work = workload(&loaded, &mut tracer);
    let other = Other::new(&loaded);
    println!("{path}: {}\n", shape(&loaded));
    println!("| rays | hit | pmcip | obvhs, two wide | obvhs, eight wide |\n| --- | --- | --- | --- | --- |");
    let closest = |t: &mut Tracer<'_>, r: &Rays8| {
        t.closest(r).triangle.simd_ne(wide::u32x8::splat(MISS)).to_bitmask().count_ones()
    };
    let occluded = |t: &mut Tracer<'_>, r: &Rays8| t.occluded(r).count_ones();
    row("primary", &work.primary, rounds, &mut |r| closest(&mut tracer, r), &other, false);
    row("shadow", &work.shadow, rounds, &mut |r| occluded(&mut tracer, r), &other, true);
    row("bounce", &work.bounce, rounds, &mut |r| closest(&mut tracer, r), &other, false);
}

/// Another camera than the scene's.
fn look(loaded: &mut LoadedScene, from: &str, rest: Vec<&str>) {
    let point = |text: &str| {
        let numbers: Vec<f32> = text.split(',').map(|n| n.parse().expect("a number")).collect();
        <[f32; 3]>::try_from(numbers).expect("three numbers")
    };
    let [at, fov, width, height] = rest.try_into().expect("FROM AT FOV WIDTH HEIGHT");
    (loaded.view.from, loaded.view.at) = (point(from), point(at));
    loaded.view.fov = fov.parse().expect("an angle");
    (loaded.width, loaded.height) = (width.parse().expect("a width"), height.parse().expect("a height"));
}

/// What the hierarchy is like: its size, and the surface-area heuristic's expectation for a ray that meets the scene's box.
fn shape(loaded: &LoadedScene) -> String {
    let LoadedScene { nodes, triangles, .. } = loaded;
    let area = |(low, high): ([f32; 3], [f32; 3])| {
        let [x, y, z] = [0, 1, 2].map(|axis| f64::from(high[axis] - low[axis]));
        x * y + y * z + z * x
    };
    let (mut met, mut of_leaves, mut of_triangles, mut leaves) = (1.0, 0.0, 0.0, 0);
    let all = area(nodes[0].hull());
    for (node, child) in nodes.iter().flat_map(|node| (0..8).map(move |child| (node, child))) {
        if node.is_used(child) {
            let corner = |rows: &[[f32; 8]; 3]| rows.map(|row| row[child]);
            let share = area((corner(&node.lower), corner(&node.upper))) / all;
            match node.count[child] {
                0 => met += share,
                count => {
                    leaves += 1;
                    (of_leaves, of_triangles) = (of_leaves + share, of_triangles + share * f64::from(count));
                }
            }
        }
    }
    let bytes = size_of_val(&nodes[..]) + size_of_val(&loaded.leaves[..]);
    format!(
        "{} triangles, {} nodes, {leaves} leaves, {:.0} bytes a triangle; a ray is expected to meet {met:.1} nodes, {of_leaves:.1} leaves and {of_triangles:.1} triangles",
        triangles.len(),
        nodes.len(),
        bytes as f64 / triangles.len() as f64,
    )
}

fn row(
    name: &str,
    rays: &[Rays8],
    rounds: usize,
    ours: &mut dyn FnMut(&Rays8) -> u32,
    other: &Other,
    any: bool,
) {
    let single: Vec<Ray> = rays.iter().flat_map(split).collect();
    let mut times = [const { Vec::new() }; 3];
    let mut hits = 0;
    for _ in 0..rounds {
        let (time, count) = timed(|| rays.iter().map(&mut *ours).sum());
        times[0].push(time);
        hits = count;
        times[1].push(timed(|| single.iter().filter(|r| other.binary(r, any)).count() as u32).0);
        times[2].push(timed(|| single.iter().filter(|r| other.wide(r, any)).count() as u32).0);
    }
    let rate = |mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        single.len() as f64 / times[times.len() / 2] * 1e-6
    };
    let [ours, binary, wide] = times.map(rate);
    let hit = f64::from(hits) / single.len() as f64;
    println!("| {name} | {hit:.4} | {ours:.2} | {binary:.2} | {wide:.2} |");
}

fn timed(work: impl FnOnce() -> u32) -> (f64, u32) {
    let start = Instant::now();
    let count = std::hint::black_box(work());
    (start.elapsed().as_secs_f64(), count)
}

fn split(rays: &Rays8) -> [Ray; 8] {
    let [x, y, z] = [rays.origin.x, rays.origin.y, rays.origin.z].map(f32x8::to_array);
    let [dx, dy, dz] = [rays.direction.x, rays.direction.y, rays.direction.z].map(f32x8::to_array);
    let t = rays.t_max.to_array();
    std::array::from_fn(|i| {
        Ray::new(Vec3A::new(x[i], y[i], z[i]), Vec3A::new(dx[i], dy[i], dz[i]), 0.0, t[i])
    })
}

/// obvhs's hierarchies over the same triangles.
struct Other {
    binary: Bvh2,
    wide: CwBvh,
    /// In the order of each hierarchy's leaves.
    binary_triangles: Vec<RtTriangle>,
    wide_triangles: Vec<RtTriangle>,
}

impl Other {
    fn new(loaded: &LoadedScene) -> Other {
        let triangle = |t: &pmcip_core::tracer::scene::Triangle| {
            let [v0, v1, v2] = t.corners.map(Vec3A::from_array);
            Triangle { v0, v1, v2 }
        };
        let triangles: Vec<Triangle> = loaded.triangles.iter().map(triangle).collect();
        let mut time = Duration::default();
        let binary = build_bvh2_from_tris(&triangles, BvhBuildParams::medium_build(), &mut time);
        let wide = build_cwbvh_from_tris(&triangles, BvhBuildParams::medium_build(), &mut time);
        let ordered = |order: &[u32]| order.iter().map(|i| (&triangles[*i as usize]).into()).collect();
        Other {
            binary_triangles: ordered(&binary.primitive_indices),
            wide_triangles: ordered(&wide.primitive_indices),
            binary,
            wide,
        }
    }

    fn binary(&self, ray: &Ray, any: bool) -> bool {
        let mut hit = RayHit::none();
        let test = |ray: &Ray, i: usize| self.binary_triangles[i].intersect(ray);
        if any {
            return !self.binary.ray_traverse_miss(*ray, test);
        }
        self.binary.ray_traverse(*ray, &mut hit, test)
    }

    fn wide(&self, ray: &Ray, any: bool) -> bool {
        let mut hit = RayHit::none();
        let test = |ray: &Ray, i: usize| self.wide_triangles[i].intersect(ray);
        if any {
            return !self.wide.ray_traverse_miss(*ray, test);
        }
        self.wide.ray_traverse(*ray, &mut hit, test)
    }
}

/// Makes the rays.
fn workload(loaded: &LoadedScene, tracer: &mut Tracer<'_>) -> Workload {
    let mut random = Random(12345);
    let primary = primary(loaded, &mut random);
    let (mut shadow, mut bounce) = (Vec::new(), Vec::new());
    for packet in primary.chunks_exact(8) {
        let hits = tracer.closest(&pack(packet));
        let (t, triangle) = (hits.t.to_array(), hits.triangle.to_array());
        for (lane, ray) in packet.iter().enumerate().filter(|(lane, _)| triangle[*lane] != MISS) {
            let [a, b, c] = loaded.triangles[triangle[lane] as usize].corners.map(Vec3A::from_array);
            let normal = (b - a).cross(c - a).normalize();
            let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
            let origin = ray.origin + ray.direction * t[lane] + normal * OFFSET;
            let to_light = light_point(loaded, random.next(), random.next()) - origin;
            let length = to_light.length();
            shadow.push(One { origin, direction: to_light / length, t_max: 0.9999 * length });
            let z = 2.0 * random.next() - 1.0;
            let (sin, cos) = (std::f32::consts::TAU * random.next()).sin_cos();
            let r = (1.0 - z * z).max(0.0).sqrt();
            let direction = (normal + Vec3A::new(r * cos, r * sin, z)).normalize();
            bounce.push(One { origin, direction, t_max: f32::INFINITY });
        }
    }
    let packets = |rays: &[One]| rays.chunks_exact(8).map(pack).collect();
    Workload { primary: packets(&primary), shadow: packets(&shadow), bounce: packets(&bounce) }
}

/// A point of the rectangle that the first light's triangle is half of.
fn light_point(loaded: &LoadedScene, u: f32, v: f32) -> Vec3A {
    let light = loaded.lights.first().expect("a light").triangle as usize;
    let [a, b, c] = loaded.triangles[light].corners.map(Vec3A::from_array);
    let angle = |(k, p, q): &(Vec3A, Vec3A, Vec3A)| (*p - *k).angle_between(*q - *k);
    let corners = [(a, b, c), (b, c, a), (c, a, b)];
    let (k, p, q) = corners.into_iter().max_by(|a, b| angle(a).total_cmp(&angle(b))).expect("three corners");
    k + (p - k) * u + (q - k) * v
}

/// Rays through random points of the pixels, in blocks of 4×2 pixels, picture after picture.
fn primary(loaded: &LoadedScene, random: &mut Random) -> Vec<One> {
    let (width, height, view) = (loaded.width as usize, loaded.height as usize, loaded.view);
    let from = Vec3A::from_array(view.from);
    let forward = (Vec3A::from_array(view.at) - from).normalize();
    let right = forward.cross(Vec3A::from_array(view.up)).normalize();
    let up = right.cross(forward);
    let tangent = (view.fov.to_radians() / 2.0).tan();
    let aspect = width as f32 / height as f32;
    let mut rays = Vec::new();
    for _ in 0..(PRIMARY / (width * height)).max(1) {
        for (y, x) in (0..height).step_by(2).flat_map(|y| (0..width).step_by(4).map(move |x| (y, x))) {
            for lane in 0..8 {
                let px = (x + lane % 4) as f32 + random.next();
                let py = (y + lane / 4) as f32 + random.next();
                let sx = (2.0 * px / width as f32 - 1.0) * tangent * aspect;
                let sy = (1.0 - 2.0 * py / height as f32) * tangent;
                let direction = (forward + right * sx + up * sy).normalize();
                rays.push(One { origin: from, direction, t_max: f32::INFINITY });
            }
        }
    }
    rays
}

fn pack(rays: &[One]) -> Rays8 {
    let row = |of: &dyn Fn(&One) -> f32| f32x8::from(std::array::from_fn::<f32, 8, _>(|i| of(&rays[i])));
    let vector = |of: fn(&One) -> Vec3A| Vec3x8::new(row(&|r| of(r).x), row(&|r| of(r).y), row(&|r| of(r).z));
    Rays8 {
        origin: vector(|r| r.origin),
        direction: vector(|r| r.direction),
        t_max: row(&|r| r.t_max),
        ..Rays8::default()
    }
}
