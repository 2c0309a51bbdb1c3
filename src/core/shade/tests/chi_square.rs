//! Do directions come as often as the density says?
//!
//! χ² of 2^17 sampled directions over 40 × 32 bins around the mirrored view, against the density integrated over each bin
//! by 24 × 24 midpoints; directions below the horizon have no density and are one bin more, bins of fewer than five are
//! one. α = 0.01 over all tests together: by Šidák 1 − 0.99^(1/n) each. Seeds are fixed. Control: roughness 10 % off.

use super::super::rough::Rough;
use super::std::vec;
use super::std::vec::Vec;
use super::{hash, lanes, surface, unit};
use crate::scene::Material;
use crate::vec3::Vec3x8;
use core::f64::consts::{PI, TAU};
use wide::f32x8;

const RINGS: usize = 40;
const SECTORS: usize = 32;
const MIDPOINTS: usize = 24;
const SAMPLES: u32 = 1 << 17;

/// A view, and an orthonormal frame around its mirror direction.
struct View {
    outgoing: [f64; 3],
    axes: [[f64; 3]; 3],
}

impl View {
    fn new(cosine: f64) -> View {
        let sine = libm::sqrt(1.0 - cosine * cosine);
        let axes = [[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]];
        View { outgoing: [sine, 0.0, cosine], axes }
    }

    fn bsdf(&self, material: Material) -> Rough {
        Rough::new(&surface(material), Vec3x8::splat(self.outgoing.map(|x| x as f32)))
    }

    /// The direction `angle` off the mirrored view, turned by `turn`.
    fn direction(&self, angle: f64, turn: f64) -> [f64; 3] {
        let local =
            [libm::sin(angle) * libm::cos(turn), libm::sin(angle) * libm::sin(turn), libm::cos(angle)];
        [0, 1, 2].map(|k| (0..3).map(|i| local[i] * self.axes[i][k]).sum())
    }

    /// The bin of a direction.
    fn bin(&self, direction: [f64; 3]) -> usize {
        let [x, y, z] = self.axes.map(|axis| (0..3).map(|k| axis[k] * direction[k]).sum::<f64>());
        // Narrow rings near the mirrored view, where a narrow lobe is.
        let angle = libm::atan2(libm::sqrt(x * x + y * y), z);
        let ring = (libm::sqrt(angle / PI) * RINGS as f64) as usize;
        let sector = ((libm::atan2(y, x) / TAU + 0.5) * SECTORS as f64) as usize;
        ring.min(RINGS - 1) * SECTORS + sector.min(SECTORS - 1)
    }

    /// Probability of every bin, and of no direction above the horizon.
    fn expected(&self, bsdf: &Rough) -> Vec<f64> {
        let mut bins = vec![0.0; RINGS * SECTORS + 1];
        let (rings, sectors) = (RINGS * MIDPOINTS, SECTORS * MIDPOINTS);
        for ring in 0..rings {
            let edge = |k: usize| PI * (k as f64 / rings as f64) * (k as f64 / rings as f64);
            let (inner, outer) = (edge(ring), edge(ring + 1));
            let (angle, area) = (0.5 * (inner + outer), libm::cos(inner) - libm::cos(outer));
            for first in (0..sectors).step_by(8) {
                let turn = |lane: usize| TAU * (((first + lane) as f64 + 0.5) / sectors as f64 - 0.5);
                let at = |k: usize| lanes(|lane| self.direction(angle, turn(lane))[k] as f32);
                let density = bsdf.evaluate(Vec3x8::new(at(0), at(1), at(2))).1.to_array();
                for (lane, density) in density.into_iter().enumerate() {
                    let bin = ring / MIDPOINTS * SECTORS + (first + lane) / MIDPOINTS;
                    bins[bin] += f64::from(density) * area * TAU / sectors as f64;
                }
            }
        }
        bins[RINGS * SECTORS] = 1.0 - bins.iter().sum::<f64>();
        bins
    }

    /// How often every bin is sampled.
    fn sampled(&self, bsdf: &Rough, seed: u32) -> Vec<f64> {
        let mut bins = vec![0.0; RINGS * SECTORS + 1];
        for first in (0..SAMPLES).step_by(8) {
            let number = |k: u32| lanes(|lane| unit(seed ^ (3 * (first + lane as u32) + k)));
            let found = bsdf.sample(number(0), number(1), || number(2));
            let density: f32x8 = bsdf.evaluate(found).1;
            for lane in 0..8 {
                let direction = [found.x, found.y, found.z].map(|v| f64::from(v.to_array()[lane]));
                let above = density.to_array()[lane] > 0.0;
                bins[if above { self.bin(direction) } else { RINGS * SECTORS }] += 1.0;
            }
        }
        bins
    }
}

/// How many normal deviations χ² is above its expectation (Wilson and Hilferty 1931).
fn deviations(observed: &[f64], probability: &[f64]) -> f64 {
    let (mut chi, mut bins, mut rest) = (0.0, 0.0, [0.0; 2]);
    for (observed, probability) in observed.iter().zip(probability) {
        let expected = probability * f64::from(SAMPLES);
        if expected < 5.0 {
            rest = [rest[0] + observed, rest[1] + expected];
            continue;
        }
        (chi, bins) = (chi + (observed - expected) * (observed - expected) / expected, bins + 1.0);
    }
    if rest[1] >= 5.0 {
        (chi, bins) = (chi + (rest[0] - rest[1]) * (rest[0] - rest[1]) / rest[1], bins + 1.0);
    }
    let freedom = bins - 1.0;
    let spread = 2.0 / (9.0 * freedom);
    (libm::cbrt(chi / freedom) - (1.0 - spread)) / libm::sqrt(spread)
}

fn glossy(diffuse: f32, specular: f32, roughness: f32) -> Material {
    Material { diffuse: [diffuse; 3], specular: [specular; 3], roughness, ..Material::default() }
}

/// 18 tests: 5.6e-4 each, 3.26 deviations.
#[test]
fn directions_come_as_often_as_their_density_says() {
    let lobes = [0.05, 0.2, 0.5, 1.0].map(|roughness| glossy(0.0, 1.0, roughness));
    let materials = lobes.into_iter().chain([glossy(0.5, 0.0, 1.0), glossy(0.4, 0.3, 0.2)]);
    for (number, material) in materials.enumerate() {
        for cosine in [1.0, 0.6, 0.15] {
            let view = View::new(cosine);
            let bsdf = view.bsdf(material);
            let z = deviations(&view.sampled(&bsdf, hash(number as u32)), &view.expected(&bsdf));
            assert!(z < 3.26, "material {number} seen at cosine {cosine}: {z} deviations");
        }
    }
}

#[test]
fn a_wrong_density_is_noticed() {
    for (roughness, cosine) in [(0.05, 0.6), (0.2, 1.0), (0.5, 0.15), (1.0, 0.6)] {
        let view = View::new(cosine);
        let sampled = view.sampled(&view.bsdf(glossy(0.0, 1.0, roughness)), 0x9e37_0000);
        let z = deviations(&sampled, &view.expected(&view.bsdf(glossy(0.0, 1.0, 0.9 * roughness))));
        assert!(z > 3.26, "roughness {roughness}, 10 % off: {z} deviations");
    }
}
