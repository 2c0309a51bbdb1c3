//! Frames by the guided estimator: any number of threads, the energy of fair samples, features through glass.

use pmcip::frame::render::render;
use pmcip::frame::settings::{Method, Settings};
use pmcip::scene;
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::guide::Feature;
use pmcip_core::tracer::camera::Camera;
use pmcip_core::tracer::scene::Scene;
use pmcip_core::tracer::shade::features::Features;

fn frame(estimator: Estimator, threads: usize) -> Vec<[f32; 3]> {
    let scene = scene::load("scenes/cornell.toml".as_ref()).unwrap();
    let mut settings = Settings::new(&scene, Method::Pmc, Some(8), Some((70, 50)));
    settings.set_estimator(estimator);
    render(&scene, &settings, Some(threads), &|_| ()).unwrap().rgb
}

#[test]
fn guided_frames_have_the_same_bits_on_any_threads_and_the_energy_of_fair_samples() {
    let guided = frame(Estimator::Guided, 1);
    assert_eq!(guided, frame(Estimator::Guided, 3));
    let energy = |picture: &[[f32; 3]]| picture.as_flattened().iter().map(|v| f64::from(*v)).sum::<f64>();
    let fair = energy(&frame(Estimator::Difference, 2));
    assert!((energy(&guided) / fair - 1.0).abs() < 1e-5);
    assert_ne!(guided, frame(Estimator::Balanced, 2));
}

#[test]
fn features_are_those_of_the_first_rough_surface() {
    let scene = scene::load("scenes/cornell.toml".as_ref()).unwrap();
    let view = scene.view;
    let camera = Camera::new(view.from, view.at, view.up, view.fov, 60, 60).unwrap();
    let mut eye = Features::new(Scene::new(scene.data()).unwrap(), camera, 8);
    let (mut row, mut again) = ([Feature::default(); 60], [Feature::default(); 60]);
    let mut coverage = [9.0; 59];
    eye.row(30, &mut row, &mut coverage);
    eye.row(30, &mut again, &mut []);
    assert_eq!(row, again);
    for seen in &row {
        let length = seen.normal.iter().map(|v| v * v).sum::<f32>().sqrt();
        assert!(length < 1.0 + 1e-5 && seen.depth >= 0.0);
        assert!(seen.albedo.iter().all(|a| (0.0..=1.0).contains(a)));
    }
    for (seen, coverage) in row.iter().zip(coverage) {
        assert!((0.0..=1.0).contains(&coverage) && (8.0 * coverage).fract() == 0.0);
        assert_eq!(coverage > 0.0, seen.depth > 0.0);
    }
    let flat = row.iter().filter(|seen| seen.depth > 0.0 && seen.normal.iter().any(|v| v.abs() > 0.999));
    assert!(flat.count() > 30, "walls look along the axes");
}
