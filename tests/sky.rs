//! Light from outside: furnaces whose radiance is known, a sun over a floor, lamps and sky together, all integrators alike.
//!
//! Standard errors come from eight seeds; tolerances are 4 of them (as in `furnace.rs`) and 1e-5 for rounding. In all there
//! are fewer than 60 comparisons: 0.4 % that any correct one fails.

mod common;

use common::{Owned, Random, inward_box, mean_and_error, packets, render_with};
use pmcip::frame::photons::{Order, Photons};
use pmcip_core::sampler::batch::Integrand;
use pmcip_core::sampler::{Schedule, Settings};
use pmcip_core::tracer::camera::Camera;
use pmcip_core::tracer::scene::sky::{build, required};
use pmcip_core::tracer::scene::{Material, Scattering, Scene, SceneData, Sky, Sun, Triangle};
use pmcip_core::tracer::shade::direct::{DirectLighting, Samples};
use pmcip_core::tracer::shade::gather::Gather;
use pmcip_core::tracer::shade::path::PathTracer;

const SIDE: u32 = 16;
const AXES: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A sky that owns its arrays.
struct Map {
    size: (u32, u32),
    texels: Vec<[f32; 3]>,
    rows: Vec<u32>,
    cells: Vec<u32>,
    sun: Option<Sun>,
    power: f32,
    visible: bool,
}

impl Map {
    fn new(size: (u32, u32), texels: Vec<[f32; 3]>, sun: Option<Sun>) -> Map {
        let (rows, cells) = required(size.0, size.1);
        let (mut rows, mut cells) = (vec![0; rows], vec![0; cells]);
        let power = build(size, &texels, sun.as_ref(), &mut rows, &mut cells);
        Map { size, texels, rows, cells, sun, power, visible: true }
    }

    fn even(radiance: f32) -> Map {
        Map::new((1, 1), vec![[radiance; 3]], None)
    }

    /// Radiances that differ by a factor of a thousand.
    fn uneven() -> Map {
        let mut random = Random::new(5);
        let texels = (0..32 * 16).map(|_| [0; 3].map(|_| 10f32.powf(3.0 * random.unit() - 2.0)));
        Map::new((32, 16), texels.collect(), None)
    }

    fn sky(&self) -> Sky<'_> {
        Sky {
            width: self.size.0,
            height: self.size.1,
            texels: &self.texels,
            rows: &self.rows,
            cells: &self.cells,
            axes: AXES,
            sun: self.sun,
            power: self.power,
            visible: self.visible,
        }
    }
}

/// The scene under a sky.
fn under<'a>(owned: &'a Owned, map: &'a Map) -> Scene<'a> {
    Scene::new(SceneData { sky: Some(map.sky()), ..*owned.scene().data() }).unwrap()
}

/// A cube of one material, front outwards.
fn block(half: f32, material: Material) -> Owned {
    let swap = |t: Triangle| Triangle { corners: [t.corners[0], t.corners[2], t.corners[1]] };
    let parts: Vec<_> = inward_box([-half; 3], [half; 3]).into_iter().map(|t| (swap(t), 0)).collect();
    Owned::new(&parts, vec![material])
}

/// A floor of one material, 2 by 2, that faces up.
fn floor(material: Material) -> Owned {
    let at = |x: f32, z: f32| [x, 0.0, z];
    let [a, b, c, d] = [at(-1.0, -1.0), at(-1.0, 1.0), at(1.0, 1.0), at(1.0, -1.0)];
    Owned::new(&[(Triangle { corners: [a, b, c] }, 0), (Triangle { corners: [a, c, d] }, 0)], vec![material])
}

#[derive(Clone, Copy, Debug)]
enum How {
    Path,
    Direct,
    Gather,
}

const ALL: [How; 3] = [How::Path, How::Direct, How::Gather];

fn camera() -> Camera {
    Camera::new([0.3, 0.9, 1.4], [0.0; 3], [0.0, 1.0, 0.0], 30.0, SIDE, SIDE).unwrap()
}

/// Red mean radiance of a picture by one seed.
fn mean(integrand: &mut impl Integrand, seed: u32) -> f64 {
    let settings = Settings { seed, ..Settings::uniform(SIDE, SIDE) };
    let rgb = render_with(integrand, settings, Schedule::new(u64::from(SIDE * SIDE), 64, 64, 1));
    rgb.iter().step_by(3).map(|v| f64::from(*v)).sum::<f64>() / f64::from(SIDE * SIDE)
}

/// The same by eight seeds, and its standard error.
fn seen(scene: Scene<'_>, how: How, depth: u32) -> (f64, f64) {
    let one = |seed: u32| {
        let mut memory = packets();
        match how {
            How::Path => mean(&mut PathTracer::new(scene, camera(), depth, &mut memory), seed),
            How::Direct => {
                let samples = Samples { light: 2, bsdf: 3 };
                mean(&mut DirectLighting::new(scene, camera(), depth, samples, &mut memory), seed)
            }
            How::Gather => {
                let order = Order { photons: 20_000, max_depth: depth, seed, frame: 0 };
                let photons = Photons::shoot(scene, &order, None).unwrap();
                let maps = photons.maps().unwrap();
                mean(&mut Gather::new(scene, camera(), depth, maps, &mut memory), seed)
            }
        }
    };
    mean_and_error(&(0..8).map(one).collect::<Vec<_>>())
}

fn assert_near((mean, error): (f64, f64), expected: f64, what: &str) {
    let tolerance = 4.0 * error + 1e-5 * expected;
    assert!((mean - expected).abs() <= tolerance, "{what}: {mean} ± {error}, expected {expected}");
}

/// A white cube under a white sky cannot be seen: what does not end on it at once has scattered once and left.
#[test]
fn a_white_cube_vanishes_under_a_white_sky() {
    let white = Material { diffuse: [1.0; 3], ..Material::default() };
    let owned = block(0.4, white);
    let map = Map::even(1.0);
    for how in ALL {
        assert_near(seen(under(&owned, &map), how, 4), 1.0, &format!("{how:?}"));
    }
    // The negative control: a reflectance off by half a percent is noticed.
    let grey = block(0.4, Material { diffuse: [0.995; 3], ..white });
    let (mean, error) = seen(under(&grey, &map), How::Path, 4);
    assert!((mean - 1.0).abs() > 4.0 * error + 1e-5, "{mean} ± {error}");
}

/// Mirror and glass take nothing away; a glossy lobe only what single scattering loses.
#[test]
fn other_cubes_under_a_white_sky() {
    let map = Map::even(1.0);
    let mirror = Material { scattering: Scattering::Mirror, specular: [1.0; 3], ..Material::default() };
    let glass = Material { scattering: Scattering::Dielectric, ior: 1.5, ..mirror };
    for how in [How::Path, How::Direct] {
        assert_near(seen(under(&block(0.4, mirror), &map), how, 4), 1.0, "mirror");
        let (mean, error) = seen(under(&block(0.4, glass), &map), how, 200);
        // Total reflection traps a few paths in a cube for good, as it would light.
        assert!(mean <= 1.0 + 4.0 * error + 1e-5 && mean > 0.98, "glass {how:?}: {mean} ± {error}");
    }
    for (roughness, least) in [(1e-4, 0.998), (0.05, 0.99), (0.3, 0.8), (1.0, 0.3)] {
        let metal = Material { diffuse: [0.0; 3], specular: [1.0; 3], roughness, ..Material::default() };
        let (mean, error) = seen(under(&block(0.4, metal), &map), How::Path, 4);
        assert!(mean <= 1.0 + 4.0 * error + 1e-5, "α {roughness} adds light: {mean} ± {error}");
        assert!(mean >= least, "α {roughness} loses light: {mean} ± {error}");
    }
}

/// Half of what a white cube sees is a lamp of radiance 1 and half the sky: it still vanishes, if all that is aimed at or met
/// by chance is counted once.
#[test]
fn lamps_and_sky_share_what_a_surface_sees() {
    let white = Material { diffuse: [1.0; 3], ..Material::default() };
    let black = Material { diffuse: [0.0; 3], emission: [1.0; 3], ..Material::default() };
    let swap = |t: Triangle| Triangle { corners: [t.corners[0], t.corners[2], t.corners[1]] };
    let cube = inward_box([-0.3; 3], [0.3; 3]).into_iter().map(|t| (swap(t), 0));
    // All of a large box but its ceiling and a wall.
    let walls = inward_box([-4.0; 3], [4.0; 3]).into_iter().filter(|t| {
        let sum = |axis: usize| t.corners.iter().map(|c| c[axis]).sum::<f32>();
        sum(1) < 11.9 && sum(0) < 11.9
    });
    let parts: Vec<_> = cube.chain(walls.map(|t| (t, 1))).collect();
    let owned = Owned::new(&parts, vec![white, black]);
    let map = Map::even(1.0);
    let scene = under(&owned, &map);
    assert!(!scene.data().light_nodes.is_empty(), "the lamps have no tree");
    let few = SceneData { light_nodes: &[], ..*scene.data() };
    for how in [How::Path, How::Direct] {
        assert_near(seen(scene, how, 4), 1.0, &format!("tree, {how:?}"));
        assert_near(seen(Scene::new(few).unwrap(), how, 4), 1.0, &format!("table, {how:?}"));
    }
    // Photons are not exact: a percent for the blur of the map's edges, which no first hit looks up here.
    let (mean, _) = seen(scene, How::Gather, 4);
    assert!((mean - 1.0).abs() < 0.01, "gather {mean}");
}

/// Under an uneven sky path and direct light agree, whatever is left to aiming and to chance.
#[test]
fn integrators_agree_under_an_uneven_sky() {
    let glossy = Material { diffuse: [0.5; 3], specular: [0.3; 3], roughness: 0.2, ..Material::default() };
    let owned = block(0.4, glossy);
    let map = Map::uneven();
    let [path, direct, gather] = ALL.map(|how| seen(under(&owned, &map), how, 2));
    let error = |a: (f64, f64), b: (f64, f64)| a.1.hypot(b.1);
    assert!((path.0 - direct.0).abs() < 4.0 * error(path, direct), "{path:?} {direct:?}");
    assert!((path.0 - gather.0).abs() < 4.0 * error(path, gather), "{path:?} {gather:?}");
}

/// A sun of the true size at an angle over a floor of reflectance ½: E cos / 2π.
#[test]
fn the_sun_lights_a_floor() {
    let sun = Sun { direction: [0.6, 0.8, 0.0], radius: 0.004_625, radiance: [5e4; 3] };
    let map = Map::new((1, 1), vec![[0.0; 3]], Some(sun));
    let owned = floor(Material { diffuse: [0.5; 3], ..Material::default() });
    let expected = f64::from(sun.solid_angle()) * 5e4 * 0.8 * 0.5 / std::f64::consts::PI;
    for how in ALL {
        // The camera sees floor and beside it black sky: count the pixels that look down on it.
        let whole = seen(under(&owned, &map), how, 3);
        let white = Map::even(1.0);
        let white = seen(under(&owned, &Map { visible: false, ..white }), How::Path, 2).0 / 0.5;
        assert!((whole.0 / white / expected - 1.0).abs() < 2e-3, "{how:?}: {whole:?} of {white}");
    }
}

/// What is not to be seen is black, and lights all the same; in a mirror it is there.
#[test]
fn a_hidden_sky_lights_and_is_mirrored() {
    let map = Map { visible: false, ..Map::even(1.0) };
    let mirror = Material { scattering: Scattering::Mirror, specular: [1.0; 3], ..Material::default() };
    let shown = seen(under(&block(0.3, mirror), &map), How::Path, 4);
    let white = Material { diffuse: [1.0; 3], ..Material::default() };
    let lit = seen(under(&block(0.3, white), &map), How::Path, 4);
    assert!(shown.0 > 0.2 && shown.0 < 0.9, "{shown:?}");
    assert_near(lit, shown.0, "lit and mirrored");
    let empty =
        Owned::new(&[(Triangle { corners: [[9.0; 3], [9.0, 9.1, 9.0], [9.0, 9.0, 9.1]] }, 0)], vec![white]);
    assert_eq!(seen(under(&empty, &map), How::Path, 4).0, 0.0);
    assert_near(seen(under(&empty, &Map::even(2.0)), How::Path, 4), 2.0, "sky alone");
}

/// Photons bring the power that falls on a ball around the scene, and a sun through glass makes a caustic as bright as that
/// of paths that find the sun by chance.
#[test]
fn a_large_sun_shines_through_glass() {
    let glass =
        Material { scattering: Scattering::Dielectric, ior: 1.5, specular: [1.0; 3], ..Material::default() };
    let grey = Material { diffuse: [0.8; 3], ..Material::default() };
    let swap = |t: Triangle| Triangle { corners: [t.corners[0], t.corners[2], t.corners[1]] };
    let cube = inward_box([-0.2, 0.1, -0.2], [0.2, 0.5, 0.2]).into_iter().map(|t| (swap(t), 0));
    let ground = floor(grey).triangles.into_iter().map(|t| (t, 1));
    let parts: Vec<_> = cube.chain(ground).collect();
    let owned = Owned::new(&parts, vec![glass, grey]);
    let sun = Sun { direction: [0.0, 0.8, 0.6], radius: 0.3, radiance: [10.0; 3] };
    let map = Map::new((1, 1), vec![[0.2; 3]], Some(sun));
    let [path, gather] = [How::Path, How::Gather].map(|how| seen(under(&owned, &map), how, 8));
    // Photon maps blur the caustic's edges and over the edges of the floor: one percent.
    assert!((gather.0 / path.0 - 1.0).abs() < 0.01 + 4.0 * path.1 / path.0, "{path:?} {gather:?}");
}
