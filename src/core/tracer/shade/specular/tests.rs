use super::*;
use crate::tracer::scene::{Material, Scattering};

/// Numbers of about 1 that have gone through a dozen operations are off by this much at most.
const ROUNDING: f64 = 16.0 / (1 << 24) as f64;

const INDICES: [f32; 4] = [1.1, 1.33, 1.5, 2.4];

fn glass(ior: f32, cosine: f32) -> SurfacePoints {
    let tint =
        Material { specular: [1.0; 3], scattering: Scattering::Dielectric, ior, ..Material::default() };
    SurfacePoints::flat(&tint, cosine)
}

/// The direction in which light falls on the plane z = 0 from above, `turn` around the z axis.
fn falling(degrees: f64, turn: f64) -> Vec3x8 {
    let angle = degrees.to_radians();
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    Vec3x8::splat([(sin * libm::cos(turn)) as f32, (sin * libm::sin(turn)) as f32, -cos as f32])
}

fn scatter(ior: f32, side: f32, degrees: f64, choice: f32) -> Scattered {
    dielectric(&glass(ior, side), falling(degrees, 0.7), f32x8::splat(choice))
}

fn first(v: f32x8) -> f64 {
    f64::from(v.to_array()[0])
}

/// Fresnel's equations as he wrote them, by angles. `eta` = index on the side of the ray over that beyond.
fn fresnel_by_angles(eta: f64, degrees: f64) -> f64 {
    let i = degrees.to_radians();
    let t = libm::asin(eta * libm::sin(i));
    let squared = |f: fn(f64) -> f64| (f(i - t) / f(i + t)) * (f(i - t) / f(i + t));
    0.5 * (squared(libm::sin) + squared(libm::tan))
}

fn fresnel_of(eta: f64, degrees: f64) -> f64 {
    let i = degrees.to_radians();
    let cos_out = libm::sqrt(1.0 - eta * eta * libm::sin(i) * libm::sin(i));
    let splat = |v: f64| f32x8::splat(v as f32);
    first(fresnel(splat(libm::cos(i)), splat(cos_out), splat(eta)))
}

/// Handbook values: 4 % of glass and 2 % of water seen straight on, 17 % of diamond; at Brewster's angle half of
/// ((n² − 1)/(n² + 1))².
#[test]
fn reflectance_has_its_known_values() {
    for (n, expected) in [(1.5, 0.04), (4.0 / 3.0, 1.0 / 49.0), (2.42, (1.42 / 3.42) * (1.42 / 3.42))] {
        for eta in [n, 1.0 / n] {
            assert!((fresnel_of(eta, 0.0) - expected).abs() < 1e-6, "{eta}: {}", fresnel_of(eta, 0.0));
        }
    }
    let brewster = libm::atan(1.5).to_degrees();
    assert!((fresnel_of(1.0 / 1.5, brewster) - 0.5 * (5.0f64 / 13.0).powi(2)).abs() < 1e-6);
    assert!((fresnel_of(1.0 / 1.5, 89.9999) - 1.0).abs() < 1e-4, "all is reflected at grazing angles");
}

#[test]
fn reflectance_follows_fresnel_at_all_angles() {
    for index in INDICES {
        for eta in [f64::from(index), 1.0 / f64::from(index)] {
            for degrees in 1..90 {
                let degrees = f64::from(degrees);
                // Close to the critical angle the cosine beyond amplifies rounding.
                if eta * libm::sin(degrees.to_radians()) < 0.99 {
                    let off = (fresnel_of(eta, degrees) - fresnel_by_angles(eta, degrees)).abs();
                    assert!(off < ROUNDING, "{eta}, {degrees}°: off by {off}");
                }
            }
        }
    }
}

/// The choice between reflecting and refracting is made at Fresnel's reflectance.
#[test]
fn as_much_is_reflected_as_fresnel_says() {
    for (ior, side, degrees) in [(1.5, 1.0, 30.0), (1.5, 1.0, 75.0), (1.5, -1.0, 35.0), (2.4, -1.0, 20.0)] {
        let eta = if side > 0.0 { 1.0 / f64::from(ior) } else { f64::from(ior) };
        let expected = fresnel_by_angles(eta, degrees);
        let up = |choice: f64| first(scatter(ior, side, degrees, choice as f32).direction.z) > 0.0;
        assert!(up(expected - 2.0 * ROUNDING) && !up(expected + 2.0 * ROUNDING), "{ior}, {degrees}°");
    }
}

#[test]
fn refraction_obeys_snell() {
    for ior in INDICES {
        for side in [1.0, -1.0] {
            let eta = if side > 0.0 { 1.0 / f64::from(ior) } else { f64::from(ior) };
            for degrees in [0.0, 10.0, 20.0, 40.0, 60.0, 80.0] {
                let sin_in = libm::sin(f64::to_radians(degrees));
                if eta * sin_in > 0.99 {
                    continue;
                }
                let through = scatter(ior, side, degrees, 0.999_999).direction;
                let (x, y, z) = (first(through.x), first(through.y), first(through.z));
                let (along, across) =
                    (x * libm::cos(0.7) + y * libm::sin(0.7), y * libm::cos(0.7) - x * libm::sin(0.7));
                assert!((along - eta * sin_in).abs() < ROUNDING, "{ior}, {side}, {degrees}°: sine {along}");
                assert!(across.abs() < ROUNDING && z < 0.0, "stays in the plane and passes through");
                assert!((x * x + y * y + z * z - 1.0).abs() < ROUNDING, "a unit vector");
            }
        }
    }
}

#[test]
fn beyond_the_critical_angle_all_is_reflected() {
    for ior in INDICES {
        let critical = libm::asin(1.0 / f64::from(ior)).to_degrees();
        for degrees in [critical + 0.1, 0.5 * (critical + 90.0), 89.9] {
            let inside = scatter(ior, -1.0, degrees, 0.999_999);
            let mirrored = reflect(falling(degrees, 0.7), Vec3x8::splat([0.0, 0.0, 1.0]));
            assert_eq!(inside.direction, mirrored, "{ior}, {degrees}°");
            assert_eq!((first(inside.weight.x), first(inside.compression)), (1.0, 1.0));
        }
        let below = scatter(ior, -1.0, critical - 0.1, 0.999_999);
        assert!(first(below.direction.z) < 0.0, "just below it some passes: {ior}");
    }
}

/// Radiance is squeezed by the squared ratio of the indices, and stretched again on the way out.
#[test]
fn radiance_is_restored_on_the_way_out() {
    for ior in INDICES {
        let n2 = f64::from(ior) * f64::from(ior);
        for degrees in [0.0, 25.0, 50.0] {
            let within = libm::asin(libm::sin(f64::to_radians(degrees)) / f64::from(ior)).to_degrees();
            let (enter, leave) =
                (scatter(ior, 1.0, degrees, 0.999_999), scatter(ior, -1.0, within, 0.999_999));
            let (into, out) = (first(enter.weight.x), first(leave.weight.x));
            assert!((into * n2 - 1.0).abs() < ROUNDING && (out / n2 - 1.0).abs() < ROUNDING, "{ior}");
            assert!((into * out - 1.0).abs() < ROUNDING, "{ior}: {}", into * out);
            let both = first(enter.compression) * first(leave.compression);
            assert!((both - 1.0).abs() < ROUNDING, "{ior}: {both}");
        }
    }
}

/// A reflection squeezes nothing and is tinted like what passes.
#[test]
fn the_tint_weighs_both_choices() {
    let tint = Material {
        specular: [0.9, 0.5, 0.25],
        scattering: Scattering::Dielectric,
        ior: 1.5,
        ..Material::default()
    };
    let surface = SurfacePoints::flat(&tint, 1.0);
    let choices = f32x8::from([0.0, 0.999, 0.0, 0.999, 0.0, 0.999, 0.0, 0.999]);
    let scattered = dielectric(&surface, falling(30.0, 0.0), choices);
    for (lane, compression) in scattered.compression.to_array().into_iter().enumerate() {
        let expected = if lane % 2 == 0 { 1.0 } else { (1.0f32 / 1.5) * (1.0f32 / 1.5) };
        assert_eq!(compression, expected, "lane {lane}");
        let weight = [scattered.weight.x, scattered.weight.y, scattered.weight.z];
        let weight = weight.map(|row| row.to_array()[lane]);
        assert_eq!(weight, [0.9, 0.5, 0.25].map(|c: f32| c * expected), "lane {lane}");
    }
}

#[test]
fn a_mirror_turns_the_normal_component_round() {
    let third = f32x8::splat(1.0 / 3.0);
    let normal = Vec3x8::new(third, third * f32x8::splat(2.0), third * f32x8::splat(2.0));
    let direction = Vec3x8::splat([0.6, 0.0, -0.8]);
    let mirrored = reflect(direction, normal);
    let off = |a: f32x8, b: f32x8| (first(a) - first(b)).abs();
    assert!(off(mirrored.dot(normal), -direction.dot(normal)) < ROUNDING);
    let (before, after) = (direction.cross(normal), mirrored.cross(normal));
    assert!(off(before.x, after.x).max(off(before.y, after.y)).max(off(before.z, after.z)) < ROUNDING);
}
