use super::*;
use crate::tracer::scene::light;
use crate::tracer::scene::{Light, Material, SceneData, Surface, Triangle};

const LAMPS: usize = 10;
/// Number of the lamp whose share is the worst rounded.
const FAINT: usize = 3;
/// Radiances of lamps of equal size. Faint ones stand between bright ones, where the table's numbers are coarse: number
/// 3 has 3.6 steps of 2^-24.
const RADIANCE: [f32; LAMPS] = [2.0, 3e-4, 3.0, 1.87e-6, 1.0, 1.1e-6, 0.5, 2.3e-5, 2.2, 1.4e-6];
/// Every value that the number which picks a lamp can have: 2^24 points have each once.
const PATHS: u32 = 1 << 24;

struct Lamps {
    triangles: [Triangle; LAMPS],
    surfaces: [Surface; LAMPS],
    materials: [Material; LAMPS],
    lights: [Light; LAMPS],
}

impl Lamps {
    /// Lamp number i lies between x = 10 i and 10 i + 1.
    fn new() -> Lamps {
        let numbers: [usize; LAMPS] = core::array::from_fn(|i| i);
        let corners = |x: f32| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]];
        let mut lamps = Lamps {
            triangles: numbers.map(|i| Triangle { corners: corners(10.0 * i as f32) }),
            surfaces: numbers.map(|i| Surface { material: i as u32, ..Surface::default() }),
            materials: RADIANCE.map(|r| Material { emission: [r; 3], ..Material::default() }),
            lights: [Light::default(); LAMPS],
        };
        light::build(&lamps.triangles, &lamps.surfaces, &lamps.materials, &mut lamps.lights);
        lamps
    }

    fn scene(&self) -> Scene<'_> {
        Scene::new(SceneData {
            triangles: &self.triangles,
            surfaces: &self.surfaces,
            materials: &self.materials,
            lights: &self.lights,
            ..SceneData::default()
        })
        .expect("the lamps are a scene")
    }
}

/// Power that leaves each lamp, in one channel, and how many photons bring it.
fn emitted(scene: &Scene<'_>) -> ([f64; LAMPS], [u32; LAMPS]) {
    let (mut power, mut photons) = ([0.0; LAMPS], [0; LAMPS]);
    let key = u32x8::splat(77);
    let all = Bounds::of(scene, |_| true).expect("the lamps have a place");
    let source = Source::new(scene, all, all);
    for first in (0..PATHS).step_by(8) {
        let index = u32x8::splat(first) + u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
        let paths = source.emit(scene, PATHS, index, key);
        for (x, flux) in paths.origin.x.to_array().into_iter().zip(paths.throughput.x.to_array()) {
            let lamp = (x / 10.0) as usize;
            power[lamp] += f64::from(flux);
            photons[lamp] += 1;
        }
    }
    (power, photons)
}

/// Each lamp emits π · area · radiance, up to eight roundings of 2^-24.
#[test]
fn every_lamp_emits_its_power_whatever_the_rounding_of_its_share() {
    let lamps = Lamps::new();
    let (power, photons) = emitted(&lamps.scene());
    let due = RADIANCE.map(|radiance| core::f64::consts::FRAC_PI_2 * f64::from(radiance));
    let bound = 8.0 / f64::from(1 << 24);
    for (lamp, (power, due)) in power.iter().zip(due).enumerate() {
        assert!((power / due - 1.0).abs() < bound, "lamp {lamp}: {power} instead of {due}");
    }
    let (sum, total) = (power.iter().sum::<f64>(), due.iter().sum::<f64>());
    assert!((sum / total - 1.0).abs() < bound, "{sum} instead of {total}");
    // What a photon would carry if the lamp's share were not rounded: then the faint lamp is off.
    let nominal = f64::from(photons[FAINT]) * total / f64::from(PATHS);
    assert!((nominal / due[FAINT] - 1.0).abs() > 0.05, "the control does not fail: {nominal}");
}
