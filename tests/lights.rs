//! Many lights: the light tree is as unbiased as picking by power, and less noisy.
//!
//! A room with a floor and lamps that hang at random. The picture is 16×16, of 8 samples a pixel at depth 3 (direct
//! light and one bounce), by seeds 0 … 31. Energies are compared within 4 standard errors of the difference (6e-5
//! two-sided; 3 comparisons).

mod common;

use common::{Owned, Random, inward_box, mean_and_error, render};
use pmcip_core::sampler::{Schedule, Settings};
use pmcip_core::tracer::camera::Camera;
use pmcip_core::tracer::scene::{Material, Triangle};

const SIDE: u32 = 16;
const SPP: u32 = 8;
const SEEDS: u32 = 32;

/// `count` lamps of one triangle each, of 0.1 in size, of radiances from 1 to 100 over `count`. The camera sees none.
fn room(count: usize) -> Owned {
    let mut random = Random::new(3);
    let mut parts: Vec<(Triangle, u32)> =
        inward_box([0.0; 3], [6.0, 2.0, 6.0]).into_iter().map(|t| (t, 0)).collect();
    let mut materials = vec![Material { specular: [0.04; 3], roughness: 0.3, ..Material::default() }];
    for i in 0..count {
        let place = [0.5 + 5.0 * random.unit(), 1.3 + 0.5 * random.unit(), 0.5 + 5.0 * random.unit()];
        let corner = |v: [f32; 3]| [0, 1, 2].map(|c| place[c] + 0.1 * v[c]);
        let corners = [0; 3].map(|_| corner(random.cube()));
        let radiance = 10f32.powf(2.0 * random.unit()) / count as f32;
        parts.push((Triangle { corners }, 1 + i as u32));
        materials.push(Material { diffuse: [0.0; 3], emission: [radiance; 3], ..Material::default() });
    }
    Owned::new(&parts, materials)
}

/// Luminances of the pixels, for each seed.
fn pictures(owned: &Owned) -> Vec<Vec<f64>> {
    let camera = Camera::new([0.2, 1.1, 0.2], [2.0, 0.0, 2.0], [0.0, 1.0, 0.0], 45.0, SIDE, SIDE).unwrap();
    let picture = |seed| {
        let settings = Settings { seed, ..Settings::uniform(SIDE, SIDE) };
        let schedule = Schedule::new(u64::from(SIDE * SIDE), SPP, SPP, 1);
        let (rgb, _) = render(owned.scene(), camera, 3, settings, schedule);
        rgb.iter().step_by(3).map(|v| f64::from(*v)).collect()
    };
    (0..SEEDS).map(picture).collect()
}

/// Mean energy of a picture with its standard error, and the mean variance of a pixel.
fn summary(pictures: &[Vec<f64>]) -> ((f64, f64), f64) {
    let pixels = pictures[0].len();
    let energies: Vec<f64> = pictures.iter().map(|p| p.iter().sum::<f64>() / pixels as f64).collect();
    let variance = (0..pixels).map(|i| {
        let values: Vec<f64> = pictures.iter().map(|p| p[i]).collect();
        mean_and_error(&values).1.powi(2) * values.len() as f64
    });
    (mean_and_error(&energies), variance.sum::<f64>() / pixels as f64)
}

/// The same room with lights picked by power alone.
fn without_tree(mut owned: Owned) -> Owned {
    owned.light_nodes.clear();
    owned
}

#[test]
fn the_tree_is_unbiased_and_less_noisy() {
    // Least ratio of the variances, well below what is measured.
    for (count, least) in [(3, 1.0), (10, 1.3), (1000, 3.0)] {
        let (tree, noise) = summary(&pictures(&room(count)));
        let (power, more_noise) = summary(&pictures(&without_tree(room(count))));
        let error = tree.1.hypot(power.1);
        let ratio = more_noise / noise;
        println!("{count} lights: {tree:?} and {power:?}, variance ratio {ratio}");
        assert!((tree.0 - power.0).abs() <= 4.0 * error, "{count} lights: {tree:?} and {power:?}");
        assert!(error < 0.02 * power.0, "{count} lights: {error} is too large to tell");
        assert!(ratio > least, "{count} lights: power alone has {ratio} times the variance of the tree");
    }
}

/// One lamp of two triangles is picked as ever: there is no tree, and nothing to pay for.
#[test]
fn a_lamp_or_two_need_no_tree() {
    assert!(room(2).light_nodes.is_empty());
    assert!(!room(3).light_nodes.is_empty());
}
