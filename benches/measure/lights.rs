//! Error and time of picking lights evenly, by power and by the light tree, with 1, 10 and 1000 lamps in a room.
//!
//! `cargo run --release -p measure -- lights [path|direct]`. Prints, for each number of lamps and each way, the mean
//! squared error against a reference of many samples, the seconds of a frame, and both relative to the tree at equal
//! samples and at equal time. Lamps hang at random in random directions; their radiances span a factor of a hundred.

use pmcip::frame::render;
use pmcip::frame::settings::{Integrator, Method, Settings};
use pmcip::picture::metrics;
use pmcip::scene::{self, LoadedScene};
use pmcip_core::maths::sobol::hash;
use std::fmt::Write;

const SIZE: (u32, u32) = (96, 72);
const SPP: u32 = 16;
const REFERENCE_SPP: u32 = 1024;
const RUNS: u32 = 5;

/// Prints the table.
pub fn run(arguments: &[String]) {
    let direct = arguments.iter().any(|argument| argument == "direct");
    println!("| lamps | picked by | MSE | seconds | MSE, ÷ tree | at equal time |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for lamps in [1, 10, 1000] {
        let tree = room(lamps);
        let mut power = tree.clone();
        power.light_nodes.clear();
        let mut even = tree.clone();
        flatten(&mut even);
        let reference = frame(&tree, direct, REFERENCE_SPP, u32::MAX);
        let measured = [("tree", &tree), ("power", &power), ("even", &even)].map(|(name, scene)| {
            let runs = (0..RUNS).map(|seed| frame(scene, direct, SPP, seed));
            let (mut error, mut seconds) = (0.0, f64::INFINITY);
            for run in runs {
                let metrics = metrics::measure(&run.0, &reference.0, f64::from(tree.cd_per_unit));
                error += metrics.expect("pictures of equal size").mse / f64::from(RUNS);
                seconds = seconds.min(run.1);
            }
            (name, error, seconds)
        });
        let best = measured[0];
        for (name, error, seconds) in measured {
            let (ratio, equal_time) = (error / best.1, error * seconds / (best.1 * best.2));
            println!("| {lamps} | {name} | {error:.3e} | {seconds:.3} | {ratio:.2} | {equal_time:.2} |");
        }
    }
}

fn frame(scene: &LoadedScene, direct: bool, spp: u32, seed: u32) -> (pmcip::picture::frame_io::Picture, f64) {
    let mut settings = Settings::new(scene, Method::Uniform, Some(spp), Some(SIZE));
    settings.sampler.seed = seed;
    settings.max_depth = 3;
    if direct {
        settings.integrator = Integrator::Direct { light_samples: 8, bsdf_samples: 1 };
    }
    let frame = render::render(scene, &settings, None, &|_| ()).expect("the room renders");
    (frame.picture(&settings, scene), frame.seconds)
}

/// Numbers from 0 to 1, the same in every run.
fn random() -> impl FnMut() -> f64 {
    let mut state = 1;
    move || {
        state = hash(state);
        f64::from(state) / f64::from(u32::MAX)
    }
}

/// A closed room of 10 × 3 × 10 with blocks on its floor and `lamps` lamps of equal power in sum.
fn room(lamps: u32) -> LoadedScene {
    let mut random = random();
    let mut obj = String::new();
    let mut corners = 0;
    cuboid(&mut obj, &mut corners, [0.0; 3], [10.0, 3.0, 10.0], true);
    for _ in 0..20 {
        let [x, z, w, h] = [0.0; 4].map(|_| random());
        let (x, z, w) = (0.5 + 8.0 * x, 0.5 + 8.0 * z, 0.3 + 0.7 * w);
        cuboid(&mut obj, &mut corners, [x, 0.0, z], [x + w, 0.2 + h, z + w], false);
    }
    let mut toml = String::from(
        "[camera]\nfrom = [0.3, 1.7, 0.3]\nat = [2.2, 0, 2.2]\nfov = 60\n[[meshes]]\nfile = \"room.obj\"\n",
    );
    for _ in 0..lamps {
        let [x, y, z, angle, tilt, strength] = [0.0; 6].map(|_| random());
        let (sin, cos) = (std::f64::consts::TAU * angle).sin_cos();
        let (x, y, z, half) = (1.0 + 8.0 * x, 1.8 + 1.0 * y, 1.0 + 8.0 * z, 0.05);
        let radiance = 300.0 * 100.0f64.powf(strength) / f64::from(lamps);
        let u = [cos * half, tilt * half, sin * half].map(|c| format!("{c:.4}")).join(",");
        let v = [-sin * half, 0.0, cos * half].map(|c| format!("{c:.4}")).join(",");
        write!(toml, "[[lights]]\ncenter = [{x:.3},{y:.3},{z:.3}]\nedge_u = [{u}]\nedge_v = [{v}]\n")
            .unwrap();
        writeln!(toml, "radiance = [{radiance:.3}, {radiance:.3}, {radiance:.3}]").unwrap();
    }
    let folder = std::env::temp_dir().join(format!("pmcip-lights-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the scene");
    std::fs::write(folder.join("room.obj"), obj).expect("the room is written");
    std::fs::write(folder.join("room.toml"), toml).expect("the lamps are written");
    let scene = scene::load(&folder.join("room.toml")).expect("the room loads");
    std::fs::remove_dir_all(folder).expect("the folder goes");
    scene
}

/// Six quads, fronts outwards or inwards.
fn cuboid(obj: &mut String, corners: &mut u32, low: [f64; 3], high: [f64; 3], inwards: bool) {
    for i in 0..8 {
        let corner = [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] });
        writeln!(obj, "v {} {} {}", corner[0], corner[1], corner[2]).unwrap();
    }
    for mut face in [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]] {
        if !inwards {
            face.reverse();
        }
        writeln!(obj, "f {}", face.map(|i| (*corners + i + 1).to_string()).join(" ")).unwrap();
    }
    *corners += 8;
}

/// Makes the tree pick lights evenly: groups as wide as the world, weighed by how many they hold.
fn flatten(scene: &mut LoadedScene) {
    let mut held = vec![0u32; scene.light_nodes.len()];
    for (i, node) in scene.light_nodes.iter_mut().enumerate().rev() {
        let used = node.power.iter().take_while(|power| **power > 0.0).count();
        for child in 0..used {
            let leaf = node.child[child] & pmcip_core::tracer::scene::LIGHT_LEAF != 0;
            let count = if leaf { 1 } else { held[node.child[child] as usize] };
            held[i] += count;
            node.power[child] = count as f32 / scene.lights.len() as f32;
            (node.radius[child], node.cosine[child]) = (1e4, -1.0);
        }
    }
}
