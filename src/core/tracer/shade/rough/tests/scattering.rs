//! What a rough surface must do whatever its lobe is: reciprocity, energy, the horizon, lanes apart.

use super::super::*;
use crate::tracer::scene::Material;

mod chi_square;
mod quadrature;

use quadrature::hemisphere;

type Vector = [f64; 3];

const ROUGHNESS: [f32; 4] = [0.05, 0.2, 0.5, 1.0];
/// Angles between the outgoing direction and the normal, in degrees.
const ANGLES: [f64; 4] = [0.0, 45.0, 80.0, 88.0];

/// Grey parts.
fn material(diffuse: f32, specular: f32, roughness: f32) -> Material {
    Material { diffuse: [diffuse; 3], specular: [specular; 3], roughness, ..Material::default() }
}

fn direction(degrees: f64, turn: f64) -> Vec3x8 {
    let (sin, cos) = (libm::sin(degrees.to_radians()), libm::cos(degrees.to_radians()));
    Vec3x8::splat([(sin * libm::cos(turn)) as f32, (sin * libm::sin(turn)) as f32, cos as f32])
}

fn rough(material: &Material, outgoing: Vec3x8) -> Rough {
    Rough::new(&SurfacePoints::flat(material, 1.0), outgoing)
}

fn first(v: f32x8) -> f64 {
    f64::from(v.to_array()[0])
}

fn vector(v: Vec3x8) -> Vector {
    [v.x, v.y, v.z].map(first)
}

/// Directions all over the hemisphere, and one close to the mirror direction of `angle`.
fn incoming(angle: f64) -> impl Iterator<Item = Vec3x8> {
    let spread = (0..60).map(|i| direction(1.4 * f64::from(i) + 1.0, 2.4 * f64::from(i)));
    spread.chain([direction(angle + 0.5, 0.7 + core::f64::consts::PI)])
}

/// f(o, i) = f(i, o): with the half vector the same to the bit, what differs is a few roundings of the cosines.
#[test]
fn light_may_go_either_way() {
    const BOUND: f64 = 32.0 / (1 << 24) as f64;
    for (alpha, diffuse, specular) in [(0.05, 0.0, 0.04), (0.2, 0.5, 0.3), (0.5, 0.2, 1.0), (1.0, 0.9, 0.1)] {
        let material = material(diffuse, specular, alpha);
        for angle in ANGLES {
            let outgoing = direction(angle, 0.7);
            for incoming in incoming(angle) {
                let there = first(rough(&material, outgoing).evaluate(incoming).0.x) / first(incoming.z);
                let back = first(rough(&material, incoming).evaluate(outgoing).0.x) / first(outgoing.z);
                assert!((there / back - 1.0).abs() < BOUND, "{alpha}, {angle}°: {there} and {back}");
            }
        }
    }
}

fn albedo(material: &Material, angle: f64) -> f64 {
    let surface = rough(material, direction(angle, 0.7));
    hemisphere(|incoming| surface.evaluate(incoming).0.x)
}

/// A diffuse surface reflects its share; a white lobe loses what is masked and gains nothing.
#[test]
fn no_part_reflects_more_than_it_receives() {
    // The quadrature's error, far above that of rounding.
    const BOUND: f64 = 1e-4;
    for angle in ANGLES {
        let diffuse = albedo(&material(0.7, 0.0, 1.0), angle);
        assert!((diffuse - f64::from(0.7f32)).abs() < BOUND, "{angle}°: {diffuse}");
        for alpha in ROUGHNESS {
            let (white, dark) =
                (albedo(&material(0.0, 1.0, alpha), angle), albedo(&material(0.0, 0.04, alpha), angle));
            assert!(white <= 1.0 + BOUND && dark < white, "{alpha}, {angle}°: {white}, {dark}");
        }
    }
    // Nearly a mirror: what comes straight on is reflected as Fresnel says.
    let mirror = albedo(&material(0.0, 0.3, 0.05), 0.0);
    assert!((mirror - 0.3).abs() < 0.002, "{mirror}");
}

#[test]
fn nothing_passes_below_the_horizon() {
    for (diffuse, specular) in [(0.7, 0.0), (0.0, 0.3), (0.4, 0.3)] {
        let material = material(diffuse, specular, 0.5);
        for (out, into) in
            [(30.0, 91.0), (89.0, 120.0), (91.0, 30.0), (150.0, 89.0), (120.0, 100.0), (0.0, 180.0)]
        {
            let (value, density) = rough(&material, direction(out, 0.7)).evaluate(direction(into, 2.0));
            assert_eq!((vector(value), first(density)), ([0.0; 3], 0.0), "{out}°, {into}°");
        }
        let (value, density) = rough(&material, direction(89.0, 0.7)).evaluate(direction(89.0, 2.0));
        assert!(first(value.x) > 0.0 && first(density) > 0.0, "just above it there is something");
    }
}

/// A packet of points with and without a lobe is what each would be alone, to the bit.
#[test]
fn lanes_do_not_mix() {
    let kinds = [material(0.7, 0.0, 0.4), material(0.0, 0.3, 0.2), material(0.4, 0.3, 0.7)];
    let of = |lane: usize| &kinds[lane % 3];
    let outgoing = direction(60.0, 0.7);
    let mut surface = SurfacePoints::flat(of(0), 1.0);
    let row = |f: fn(&Material) -> f32| f32x8::from(core::array::from_fn::<f32, 8, _>(|lane| f(of(lane))));
    let grey = |v: f32x8| Vec3x8::new(v, v, v);
    surface.diffuse = grey(row(|m| m.diffuse[0]));
    surface.specular = grey(row(|m| m.specular[0]));
    surface.roughness = row(|m| m.roughness);
    let mixed = Rough::new(&surface, outgoing);
    let (u, v, part) = (f32x8::splat(0.3), f32x8::splat(0.2), f32x8::splat(0.5));
    let at = |v: Vec3x8, lane: usize| [v.x, v.y, v.z].map(|row| row.to_array()[lane]);
    for lane in 0..8 {
        let alone = rough(of(lane), outgoing);
        let sample = alone.sample(u, v, || part);
        assert_eq!(at(mixed.sample(u, v, || part), lane), at(sample, 0), "lane {lane}");
        assert_eq!(at(mixed.lane(lane).sample(u, v, || part), 5), at(sample, 0), "lane {lane}");
        let (value, density) = alone.evaluate(sample);
        for (packet, lane) in [(mixed.evaluate(sample), lane), (mixed.lane(lane).evaluate(sample), 5)] {
            assert_eq!(
                (at(packet.0, lane), packet.1.to_array()[lane]),
                (at(value, 0), first(density) as f32)
            );
        }
    }
}
