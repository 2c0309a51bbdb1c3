//! Packets against a plain search in double precision, and against cracks.

mod common;

use common::{Owned, Random, inward_box};
use pmcip_core::maths::vec3::Vec3x8;
use pmcip_core::tracer::scene::{Material, Triangle};
use pmcip_core::tracer::trace::{MISS, Rays8, Tracer};
use wide::f32x8;

type Ray = ([f32; 3], [f32; 3], f32);

fn packet(rays: &[Ray; 8]) -> Rays8 {
    let lanes = |of: &dyn Fn(&Ray) -> f32| f32x8::from(rays.each_ref().map(of));
    let vector = |of: fn(&Ray) -> [f32; 3]| {
        Vec3x8::new(lanes(&|r| of(r)[0]), lanes(&|r| of(r)[1]), lanes(&|r| of(r)[2]))
    };
    Rays8 { origin: vector(|r| r.0), direction: vector(|r| r.1), t_max: lanes(&|r| r.2), ..Rays8::default() }
}

/// Distance and smallest barycentric weight of the intersection, by Cramer's rule in double precision.
fn intersect(ray: &Ray, triangle: &Triangle) -> Option<(f64, f64)> {
    let [a, b, c] = triangle.corners.map(|p| p.map(f64::from));
    let sub = |x: [f64; 3], y: [f64; 3]| [x[0] - y[0], x[1] - y[1], x[2] - y[2]];
    let cross = |x: [f64; 3], y: [f64; 3]| {
        [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]
    };
    let dot = |x: [f64; 3], y: [f64; 3]| x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
    let (o, d) = (ray.0.map(f64::from), ray.1.map(f64::from));
    let (ab, ac, ao) = (sub(b, a), sub(c, a), sub(o, a));
    let normal = cross(ab, ac);
    let det = -dot(d, normal);
    let perpendicular = cross(ao, d);
    let (u, v, t) = (dot(ac, perpendicular) / det, -dot(ab, perpendicular) / det, dot(ao, normal) / det);
    let least = u.min(v).min(1.0 - u - v);
    (t.is_finite() && t >= 0.0 && t <= f64::from(ray.2)).then_some((t, least))
}

/// Small triangles all over the cube.
fn soup(random: &mut Random, n: usize) -> Vec<(Triangle, u32)> {
    let mut triangle = || {
        let at = random.cube();
        let corners = [0; 3].map(|_| {
            let offset = random.cube();
            [0, 1, 2].map(|k| at[k] + 0.2 * offset[k])
        });
        (Triangle { corners }, 0)
    };
    (0..n).map(|_| triangle()).collect()
}

#[test]
fn packets_find_what_a_plain_search_finds() {
    let mut random = Random::new(1);
    for n in [1, 3, 40, 3000] {
        let owned = Owned::new(&soup(&mut random, n), vec![Material::default()]);
        let mut tracer = Tracer::new(owned.scene());
        for round in 0..200 {
            let shared = random.direction();
            let rays = [0; 8].map(|_| {
                let direction = match round % 3 {
                    0 => random.direction(),
                    1 => shared,
                    _ => *[[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]
                        .get((random.unit() * 3.0) as usize)
                        .unwrap(),
                };
                let t_max = [f32::INFINITY, 0.7, -1.0][(random.unit() * 2.2) as usize];
                (random.cube(), direction, t_max)
            });
            let hits = tracer.closest(&packet(&rays));
            let occluded = tracer.occluded(&packet(&rays));
            for (lane, ray) in rays.iter().enumerate() {
                check_lane(&owned.triangles, ray, hits.t.to_array()[lane], hits.triangle.to_array()[lane]);
                assert_eq!(occluded >> lane & 1 == 1, hits.triangle.to_array()[lane] != MISS);
            }
        }
    }
}

/// Triangles on straight ways are met where each ray's own time finds them, by packets and by single rays.
#[test]
fn what_moves_is_met_where_it_is_at_the_time_of_the_ray() {
    let mut random = Random::new(3);
    for n in [1, 40, 3000] {
        let (open, closing) = (soup(&mut random, n), soup(&mut random, n));
        // Half of them stay.
        let places = open.iter().zip(&closing).enumerate();
        let closing: Vec<_> = places.map(|(i, (a, b))| if i % 2 == 0 { a.0 } else { b.0 }).collect();
        let owned = Owned::moving(&open, &closing, vec![Material::default()]);
        let mut tracer = Tracer::new(owned.scene());
        for round in 0..50 {
            let shared = random.direction();
            let rays = [0; 8].map(|_| {
                let direction = if round % 2 == 0 { random.direction() } else { shared };
                (random.cube(), direction, [f32::INFINITY, 0.7, -1.0][(random.unit() * 2.2) as usize])
            });
            let time = [0; 8].map(|_| random.unit());
            let packet = Rays8 { time: time.into(), ..packet(&rays) };
            let (hits, occluded) = (tracer.closest(&packet), tracer.occluded(&packet));
            for (lane, ray) in rays.iter().enumerate() {
                let then: Vec<_> =
                    owned.triangles.iter().zip(&owned.closing).map(|t| at(t, time[lane])).collect();
                check_lane(&then, ray, hits.t.to_array()[lane], hits.triangle.to_array()[lane]);
                assert_eq!(occluded >> lane & 1 == 1, hits.triangle.to_array()[lane] != MISS);
            }
        }
    }
}

/// A triangle on its way.
fn at((open, closing): (&Triangle, &Triangle), time: f32) -> Triangle {
    let mix = |k: usize, c: usize| open.corners[k][c] + (closing.corners[k][c] - open.corners[k][c]) * time;
    Triangle { corners: [0, 1, 2].map(|k| [0, 1, 2].map(|c| mix(k, c))) }
}

/// The nearest intersection that is not a matter of rounding must be the one reported.
fn check_lane(triangles: &[Triangle], ray: &Ray, t: f32, triangle: u32) {
    let margin = 1e-5;
    let found = triangles.iter().filter_map(|tr| intersect(ray, tr));
    let sure = found.filter(|&(t, least)| least > margin && t > margin && t < f64::from(ray.2) - margin);
    let nearest = sure.map(|f| f.0).fold(f64::INFINITY, f64::min);
    if triangle == MISS {
        assert_eq!(nearest, f64::INFINITY, "missed {ray:?}");
        return;
    }
    assert!(f64::from(t) <= nearest + 1e-5, "{t} behind {nearest}");
    let (exact, least) = intersect(&(ray.0, ray.1, f32::INFINITY), &triangles[triangle as usize]).unwrap();
    assert!(least > -margin && (exact - f64::from(t)).abs() < 1e-4, "{exact} {t} {least}");
}

#[test]
fn idle_lanes_and_empty_scenes_miss() {
    let owned = Owned::new(&[], vec![]);
    let rays = [([0.0; 3], [0.0, 0.0, 1.0], f32::INFINITY); 8];
    let mut tracer = Tracer::new(owned.scene());
    assert_eq!(tracer.closest(&packet(&rays)).triangle.to_array(), [MISS; 8]);
    assert_eq!(tracer.occluded(&packet(&rays)), 0);
}

/// A closed surface has no cracks: rays from inside at faces, edges and corners all hit, at any size and place.
#[test]
fn closed_boxes_leak_nothing() {
    let mut random = Random::new(2);
    for (lower, upper) in [
        ([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]),
        ([0.1, 0.2, 0.3], [0.4, 1.5, 0.7]),
        ([1000.0, -3.0, 77.7], [1003.3, 20.0, 78.3]),
        ([-5e-3, 0.0, 1e-3], [5e-3, 7e-3, 2e-3]),
        // Between two walls that are close to each other.
        ([-1.0, -1.0, 0.5], [1.0, 1.0, 0.50001]),
    ] {
        let walls: Vec<_> = inward_box(lower, upper).into_iter().map(|t| (t, 0)).collect();
        let owned = Owned::new(&walls, vec![Material::default()]);
        let mut tracer = Tracer::new(owned.scene());
        for _ in 0..50_000 {
            let rays = [0; 8].map(|_| {
                let inside = |random: &mut Random, axis: usize| {
                    lower[axis] + (0.05 + 0.9 * random.unit()) * (upper[axis] - lower[axis])
                };
                let from = [0, 1, 2].map(|axis| inside(&mut random, axis));
                let to = [0, 1, 2].map(|axis| match (random.unit() * 4.0) as u32 {
                    0 => lower[axis],
                    1 => upper[axis],
                    _ => inside(&mut random, axis),
                });
                let toward = [0, 1, 2].map(|k| to[k] - from[k]);
                let length = toward.iter().map(|x| x * x).sum::<f32>().sqrt();
                (from, toward.map(|x| x / length), f32::INFINITY)
            });
            let hits = tracer.closest(&packet(&rays)).triangle.to_array();
            assert!(!hits.contains(&MISS), "{rays:?} left the box");
        }
    }
}

/// A strip of needles, 100,000 times as long as wide, has no cracks between them.
#[test]
fn needles_leak_nothing() {
    const NEEDLES: usize = 400;
    let at = |i: usize, y: f32| [i as f32 * 1e-5, y, 0.0];
    let needle = |i: usize| match i % 2 {
        0 => Triangle { corners: [at(i / 2, 0.0), at(i / 2 + 1, 0.0), at(i / 2, 1.0)] },
        _ => Triangle { corners: [at(i / 2 + 1, 0.0), at(i / 2 + 1, 1.0), at(i / 2, 1.0)] },
    };
    let needles: Vec<_> = (0..NEEDLES).map(|i| (needle(i), 0)).collect();
    let owned = Owned::new(&needles, vec![Material::default()]);
    let mut tracer = Tracer::new(owned.scene());
    let mut random = Random::new(5);
    for _ in 0..20_000 {
        let rays = [0; 8].map(|_| {
            // A third at corners' own columns, where needles meet.
            let across = 1.0 + random.unit() * (NEEDLES / 2 - 2) as f32;
            let across = if random.unit() < 0.3 { across.floor() } else { across };
            let to = [across * 1e-5, 0.01 + 0.98 * random.unit(), 0.0];
            let from = [random.unit() - 0.5, random.unit(), 0.1 + random.unit()];
            let toward = [0, 1, 2].map(|k| to[k] - from[k]);
            let length = toward.iter().map(|x| x * x).sum::<f32>().sqrt();
            (from, toward.map(|x| x / length), f32::INFINITY)
        });
        let hits = tracer.closest(&packet(&rays)).triangle.to_array();
        assert!(!hits.contains(&MISS), "{rays:?} passed the needles");
    }
}

#[test]
fn triangles_without_area_are_not_hit() {
    let flat = Triangle { corners: [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [2.0, 0.0, 1.0]] };
    let point = Triangle { corners: [[0.0, 0.0, 2.0]; 3] };
    let owned = Owned::new(&[(flat, 0), (point, 0)], vec![Material::default()]);
    let rays = [([0.5, 0.0, 0.0], [0.0, 0.0, 1.0], f32::INFINITY), ([0.0; 3], [0.0, 0.0, 1.0], 10.0)];
    let rays = [0, 1, 0, 1, 0, 1, 0, 1].map(|i: usize| rays[i]);
    assert_eq!(Tracer::new(owned.scene()).closest(&packet(&rays)).triangle.to_array(), [MISS; 8]);
}
