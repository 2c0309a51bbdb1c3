mod common;
use common::*;
use pmcip::photons::{Order, Photons};
use pmcip::scene;
use pmcip_core::camera::Camera;
use pmcip_core::sampler::{Schedule, Settings};
use pmcip_core::scene::Scene;
use pmcip_core::shade::gather::Gather;
use std::time::Instant;

#[test]
fn probe() {
    let side = 64;
    for name in ["cornell", "caustic"] {
        let path = format!("{}/scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let loaded = scene::load(path.as_ref()).unwrap();
        let scene = Scene::new(loaded.data()).unwrap();
        let v = loaded.view;
        let camera = Camera::new(v.from, v.at, v.up, v.fov, side, side).unwrap();
        let settings = Settings::uniform(side, side);
        let mean = |rgb: &[f32]| {
            let n = rgb.len() as f64 / 3.0;
            [0, 1, 2].map(|c| rgb.iter().skip(c).step_by(3).map(|x| f64::from(*x)).sum::<f64>() / n)
        };
        let depth: u32 = std::env::var("DEPTH").map_or(8, |d| d.parse().unwrap());
        let (a, b) = (64, 1024);
        let t = Instant::now();
        let (reference, _) =
            render(scene, camera, depth, settings, Schedule::new((side * side).into(), b, 8, b / 8));
        let r = mean(&reference);
        println!("{name} path {r:?} {:?} for {b}", t.elapsed());
        for photons in [50_000, 200_000, 800_000] {
            for seed in 0..2 {
                let order = Order { photons, max_depth: depth, seed, frame: 0 };
                let maps = Photons::shoot(scene, &order, None).unwrap();
                let mut packets = packets();
                let mut gather = Gather::new(scene, camera, depth, maps.maps().unwrap(), &mut packets);
                let t = Instant::now();
                let picture = sample(&mut gather, settings, Schedule::new((side * side).into(), a, 8, a / 8));
                let g = mean(&picture);
                println!(
                    "{photons} {} {} {:.2} s: {:?} {:?} for {a}",
                    maps.shot().global,
                    maps.shot().caustic,
                    maps.shot().seconds,
                    [0, 1, 2].map(|c| format!("{:+.2} %", (g[c] / r[c] - 1.0) * 100.0)),
                    t.elapsed()
                );
            }
        }
    }
}
