use super::*;
use crate::maths::sobol;
use crate::tracer::scene::sky::{build, required};
use wide::u32x8;

const SIZE: (u32, u32) = (16, 8);
const TEXELS: usize = 128;
const ROWS: usize = 9;
/// Batches of eight directions.
const BATCHES: u32 = 1 << 14;

/// A picture with its tables.
struct Owned {
    texels: [[f32; 3]; TEXELS],
    rows: [u32; ROWS],
    cells: [u32; TEXELS],
    sun: Option<Sun>,
    power: f32,
}

impl Owned {
    /// Texels of which some are a thousand times brighter than others.
    fn new(sun: Option<Sun>) -> Owned {
        assert_eq!(required(SIZE.0, SIZE.1), (ROWS, TEXELS));
        let value = |i: usize| libm::powf(10.0, (sobol::hash(i as u32) >> 8) as f32 / 8e6 - 1.0);
        let texels = core::array::from_fn(|i| [value(i), 0.5 * value(i), value(i + TEXELS)]);
        let (mut rows, mut cells) = ([0; ROWS], [0; TEXELS]);
        let power = build(SIZE, &texels, sun.as_ref(), &mut rows, &mut cells);
        Owned { texels, rows, cells, sun, power }
    }

    /// Turned about a slanted axis.
    fn sky(&self) -> Sky<'_> {
        let (c, s) = (0.8, 0.6);
        Sky {
            width: SIZE.0,
            height: SIZE.1,
            texels: &self.texels,
            rows: &self.rows,
            cells: &self.cells,
            axes: [[c, s, 0.0], [-s * c, c * c, s], [s * s, -s * c, c]],
            sun: self.sun,
            power: self.power,
            visible: true,
        }
    }
}

fn sun() -> Option<Sun> {
    Some(Sun { direction: [0.36, 0.48, 0.8], radius: 0.2, radiance: [40.0, 30.0, 20.0] })
}

fn luminance(v: Vec3x8) -> f32x8 {
    crate::maths::colour::luminance8(v.into())
}

/// Directions drawn with their numbers.
fn draws(sky: &Sky<'_>) -> impl Iterator<Item = SkyPoints> {
    (0..BATCHES).map(|batch| {
        let lanes = u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
        let (u, v) = sobol::point(u32x8::splat(8 * batch) + lanes, u32x8::splat(77), 1);
        sample(sky, u, v)
    })
}

fn mean(values: impl Iterator<Item = f32x8>) -> f64 {
    let sum: f64 = values.map(|v| v.to_array().map(f64::from).iter().sum::<f64>()).sum();
    sum / f64::from(8 * BATCHES)
}

/// Estimates of ∫ dω and of ∫ L dω by drawn directions, and the second one known from the cells. Numbers are well spread:
/// 1e-3 is ten times what is seen with other keys.
#[test]
fn densities_and_radiances_integrate_to_what_they_should() {
    for sun in [None, sun()] {
        let owned = Owned::new(sun);
        let sky = owned.sky();
        let sphere = mean(draws(&sky).map(|p| f32x8::ONE / p.density)) / (4.0 * core::f64::consts::PI);
        assert!((sphere - 1.0).abs() < 1e-3, "sphere {sphere}, sun {}", sun.is_some());
        let light = mean(draws(&sky).map(|p| luminance(p.radiance) / p.density)) / f64::from(sky.power);
        // Within a cell the picture was averaged by angle, not by solid angle.
        assert!((light - 1.0).abs() < 4e-3, "light {light}, sun {}", sun.is_some());
    }
}

/// The negative control: a table in which a cell has too large a share is noticed.
#[test]
fn a_wrong_share_is_noticed() {
    let owned = Owned::new(None);
    let mut wrong = owned.cells;
    wrong[40] = (wrong[39] + wrong[40]) / 2;
    let sky = Sky { cells: &wrong, ..owned.sky() };
    // Drawn by one table, weighed by the other.
    let sphere = mean(draws(&owned.sky()).map(|p| f32x8::ONE / density(&sky, p.direction)));
    let part = sphere / (4.0 * core::f64::consts::PI);
    assert!((part - 1.0).abs() > 1e-3, "{part}");
}

/// Directions have the density that is found for them when a path meets them by chance, but for those that rounding puts
/// beyond the edge of their cell.
#[test]
fn densities_are_those_of_the_draw() {
    for sun in [None, sun()] {
        let owned = Owned::new(sun);
        let sky = owned.sky();
        let differs = |p: SkyPoints| {
            let ratio = density(&sky, p.direction) / p.density;
            (ratio - f32x8::ONE).abs().simd_gt(f32x8::splat(1e-4)).to_bitmask().count_ones()
        };
        let differing: u32 = draws(&sky).map(differs).sum();
        assert!(differing < 8 * BATCHES / 5000, "{differing} of {}", 8 * BATCHES);
    }
}

#[test]
fn the_picture_hangs_as_that_of_openexr() {
    let mut owned = Owned::new(None);
    // Colours at the centres of texels: up, in the middle, in the middle of the left half.
    owned.texels = [[0.0; 3]; TEXELS];
    owned.texels[..16].fill([1.0, 0.0, 0.0]);
    [3 * 16, 4 * 16].iter().for_each(|row| owned.texels[row + 7..row + 9].fill([0.0, 1.0, 0.0]));
    [3 * 16, 4 * 16].iter().for_each(|row| owned.texels[row + 3..row + 5].fill([0.0, 0.0, 1.0]));
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let sky = Sky { axes, ..owned.sky() };
    let seen = |d: [f32; 3]| {
        let rgb = radiance(&sky, Vec3x8::splat(d));
        [rgb.x, rgb.y, rgb.z].map(|v| (1e3 * v.to_array()[0]).round() / 1e3)
    };
    assert_eq!(seen([0.0, 1.0, 0.0]), [1.0, 0.0, 0.0]);
    assert_eq!(seen([0.0, 0.0, 1.0]), [0.0, 1.0, 0.0]);
    assert_eq!(seen([1.0, 0.0, 0.0]), [0.0, 0.0, 1.0]);
    assert_eq!(seen([0.0, 0.0, -1.0]), [0.0; 3]);
    assert_eq!(seen([-1.0, 0.0, 0.0]), [0.0; 3]);
    assert_eq!(seen([0.0, -1.0, 0.0]), [0.0; 3]);
}

/// A sun of the true size has the irradiance of its radiance times its solid angle, however its edge is rounded.
#[test]
fn the_sun_has_its_size() {
    let sun = Sun { direction: [0.36, 0.48, 0.8], radius: 0.004_65, radiance: [1e5; 3] };
    assert!((sun.solid_angle() / 6.793e-5 - 1.0).abs() < 1e-3, "{}", sun.solid_angle());
    let mut owned = Owned::new(Some(sun));
    owned.texels = [[0.0; 3]; TEXELS];
    let sky = owned.sky();
    let light = mean(draws(&sky).map(|p| p.radiance.x / p.density));
    let exact = f64::from(1e5 * sun.solid_angle());
    assert!((light / exact - 1.0).abs() < 1e-3, "{light} instead of {exact}");
}
