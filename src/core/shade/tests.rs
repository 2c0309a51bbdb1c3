//! Surfaces, scattering, queue and shadow rays, each against a scalar twin or what is known.

extern crate std;

use super::hit::SurfacePoints;
use super::queue::{Packet, Paths, Queue};
use super::shadow::{ShadowRays, Shadows};
use super::specular;
use crate::batch::Rgb8;
use crate::scene::{Material, NO_TEXTURE, Scene, SceneData, Surface, Texture, Triangle};
use crate::sobol::hash;
use crate::trace::{Hits8, MISS, Rays8};
use crate::vec3::Vec3x8;
use std::vec;
use std::vec::Vec;
use wide::{f32x8, u32x8};

mod chi_square;

/// Lanes of a function of their number.
fn lanes(f: impl Fn(usize) -> f32) -> f32x8 {
    f32x8::from(core::array::from_fn::<f32, 8, _>(f))
}

/// In [0, 1).
fn unit(i: u32) -> f32 {
    (hash(i) >> 8) as f32 / 16_777_216.0
}

const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// What eight rays in these directions see of the triangle, at barycentric weights that differ by lane.
fn seen(material: Material, surface: Surface, texels: &[[f32; 3]; 2], direction: Vec3x8) -> SurfacePoints {
    let texture = Texture { width: 2, height: 1, first: 0 };
    let data = SceneData {
        triangles: &[Triangle { corners: CORNERS }],
        surfaces: &[surface],
        materials: &[material],
        textures: &[texture],
        texels,
        ..SceneData::default()
    };
    let scene = Scene::new(data).unwrap();
    let rays = Rays8 { origin: -direction, direction, t_max: f32x8::splat(9.0) };
    let (u, v) = (lanes(|i| 0.1 * i as f32), lanes(|i| 0.3 - 0.03 * i as f32));
    let hits = Hits8 { t: f32x8::ONE, u, v, triangle: u32x8::ZERO };
    SurfacePoints::at(&scene, &rays, &hits)
}

/// A material as seen straight from above.
fn surface(material: Material) -> SurfacePoints {
    seen(material, Surface::default(), &[[1.0; 3]; 2], Vec3x8::splat([0.0, 0.0, -1.0]))
}

#[test]
fn positions_normals_and_sides_are_those_of_a_scalar_twin() {
    let normals = [[0.6, 0.0, 0.8], [0.0, 0.6, 0.8], [0.0, 0.0, 1.0]];
    let smooth = Surface { normals, ..Surface::default() };
    for side in [1.0, -1.0] {
        let points = seen(Material::default(), smooth, &[[1.0; 3]; 2], Vec3x8::splat([0.0, 0.0, -side]));
        for lane in 0..8 {
            let (u, v) = (0.1 * lane as f32, 0.3 - 0.03 * lane as f32);
            let weights = [1.0 - u - v, u, v];
            let mix = |rows: [[f32; 3]; 3], k: usize| (0..3).map(|i| weights[i] * rows[i][k]).sum::<f32>();
            let (x, y, z) = (mix(normals, 0), mix(normals, 1), mix(normals, 2));
            let length = libm::sqrtf(x * x + y * y + z * z);
            let at = |vector: Vec3x8| [vector.x, vector.y, vector.z].map(|c| c.to_array()[lane]);
            for k in 0..3 {
                let normal = side * [x, y, z][k] / length;
                assert!((at(points.normal)[k] - normal).abs() < 1e-6);
                assert!((at(points.position)[k] - mix(CORNERS, k)).abs() < 1e-6);
                assert_eq!(at(points.facing)[k], [0.0, 0.0, side][k]);
            }
            assert_eq!(points.cosine.to_array()[lane], side);
        }
    }
}

/// Two texels side by side, seen at u from 0 to 1: constant near the ends of the row, wrapped around, linear in between.
#[test]
fn textures_are_interpolated_and_repeated() {
    let uv = [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]];
    let material = Material { diffuse: [1.0; 3], texture: 0, ..Material::default() };
    let points = seen(
        material,
        Surface { uv, ..Surface::default() },
        &[[0.0; 3], [1.0; 3]],
        Vec3x8::splat([0.0, 0.0, -1.0]),
    );
    for (lane, found) in points.diffuse.x.to_array().into_iter().enumerate() {
        let u = 0.4 * lane as f32;
        let place = 2.0 * (u - libm::floorf(u)) - 0.5;
        let want = if place < 0.0 { -place } else { 1.0 - (place - 1.0).abs() };
        assert!((found - want).abs() < 1e-5, "u {u}: {found}, not {want}");
    }
    assert_eq!(surface(Material { texture: NO_TEXTURE, ..material }).diffuse.x.to_array(), [1.0; 8]);
}

/// Reflectance and refracted direction of a dielectric, in double precision.
fn fresnel(cos_in: f64, eta: f64) -> (f64, Option<f64>) {
    let sin2_out = eta * eta * (1.0 - cos_in * cos_in);
    if sin2_out >= 1.0 {
        return (1.0, None);
    }
    let cos_out = libm::sqrt(1.0 - sin2_out);
    let parallel = (cos_in - eta * cos_out) / (cos_in + eta * cos_out);
    let across = (eta * cos_in - cos_out) / (eta * cos_in + cos_out);
    (0.5 * (parallel * parallel + across * across), Some(cos_out))
}

/// Fresnel's equations decide between reflection and refraction by Snell's law, from both sides, total reflection
/// included; what is squeezed on the way in is stretched on the way out.
#[test]
fn dielectrics_obey_fresnel_and_snell() {
    // Glass seen straight on reflects 4 %: ((1.5 − 1)/(1.5 + 1))².
    assert!((fresnel(1.0, 1.0 / 1.5).0 - 0.04).abs() < 1e-12);
    let glass = Material { ior: 1.5, specular: [1.0; 3], ..Material::default() };
    for (k, inside) in (0..200).flat_map(|k| [(k, false), (k, true)]) {
        let cosine = (f64::from(k) + 0.5) / 200.0;
        let sine = libm::sqrt(1.0 - cosine * cosine);
        let down = if inside { 1.0 } else { -1.0 };
        let direction = Vec3x8::splat([sine as f32, 0.0, (down * cosine) as f32]);
        let points = seen(glass, Surface::default(), &[[1.0; 3]; 2], direction);
        let eta = if inside { 1.5 } else { 1.0 / 1.5 };
        let (reflectance, out) = fresnel(cosine, eta);
        let choice = [(reflectance - 1e-4).max(0.0), (reflectance + 1e-4).min(0.999_999_9)];
        let choice = lanes(|lane| choice[lane % 2] as f32);
        let scattered = specular::dielectric(&points, direction, choice);
        let at = |v: f32x8, lane: usize| f64::from(v.to_array()[lane]);
        assert!((at(scattered.direction.z, 0) + down * cosine).abs() < 1e-6, "reflected at {cosine}");
        assert_eq!(at(scattered.compression, 0), 1.0);
        let Some(out) = out else {
            assert!((at(scattered.direction.z, 1) + down * cosine).abs() < 1e-6, "total at {cosine}");
            continue;
        };
        assert!((at(scattered.direction.z, 1) - down * out).abs() < 1e-4, "refracted at {cosine}");
        assert!((at(scattered.direction.x, 1) - eta * sine).abs() < 1e-5, "Snell at {cosine}");
        assert!((at(scattered.compression, 1) - eta * eta).abs() < 1e-6);
        assert!((at(scattered.weight.x, 1) - eta * eta).abs() < 1e-6);
    }
}

/// Paths that can be told apart in every field.
fn paths(first: u32) -> Paths {
    let number = |k: u32| lanes(|lane| unit(97 * (first + lane as u32) + k) - 0.5);
    let vector = |k: u32| Vec3x8::new(number(k), number(k + 1), number(k + 2));
    let word =
        |k: u32| u32x8::from(core::array::from_fn::<u32, 8, _>(|lane| hash(31 * (first + lane as u32) + k)));
    let slot = u32x8::splat(first) + u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
    Paths {
        origin: vector(0),
        direction: vector(3),
        throughput: vector(6),
        density: number(9),
        compression: number(10),
        normal: word(1),
        index: word(2),
        key: word(3),
        slot,
        lanes: 8,
    }
}

/// All fields of one lane, as bits.
fn fields(p: &Paths, lane: usize) -> [u32; 15] {
    let (o, d, t) = (p.origin, p.direction, p.throughput);
    let numbers = [o.x, o.y, o.z, d.x, d.y, d.z, t.x, t.y, t.z, p.density, p.compression];
    let words = [p.normal, p.index, p.key, p.slot].map(|v| v.to_array()[lane]);
    let mut all = [0; 15];
    all[..11].copy_from_slice(&numbers.map(|v| v.to_array()[lane].to_bits()));
    all[11..].copy_from_slice(&words);
    all
}

/// What is pushed comes back once, whole, in packets of one octant that are full but for the last of each octant.
#[test]
fn queues_lose_nothing_and_keep_lanes_full() {
    let mut memory = vec![Packet::default(); 40];
    let mut queue = Queue::new(&mut memory);
    assert_eq!(queue.capacity(), 32);
    (0..32).for_each(|k| queue.start(&paths(8 * k)));
    let mut wanted = Vec::new();
    for i in 0..queue.len() {
        let (packet, alive) = (queue.packet(i), hash(i as u32) & 0xff);
        wanted.extend((0..8).filter(|lane| alive >> lane & 1 == 1).map(|lane| fields(&packet, lane)));
        queue.push(&packet, alive);
    }
    queue.turn();
    let mut found = Vec::new();
    let mut open = [0; 8];
    for packet in (0..queue.len()).map(|i| queue.packet(i)) {
        let octant = |lane: usize| {
            let d = [packet.direction.x, packet.direction.y, packet.direction.z];
            (0..3).map(|k| usize::from(d[k].to_array()[lane] < 0.0) << k).sum::<usize>()
        };
        let used = packet.lanes as usize;
        assert!((1..used).all(|lane| octant(lane) == octant(0)), "octants mixed");
        open[octant(0)] += usize::from(used < 8);
        assert_eq!(packet.rays().active(), (1 << used) - 1);
        found.extend((0..used).map(|lane| fields(&packet, lane)));
    }
    assert!(open.iter().all(|open| *open <= 1), "more than one open packet an octant");
    wanted.sort_unstable();
    found.sort_unstable();
    assert!(wanted == found, "{} paths in, {} out", wanted.len(), found.len());
    queue.clear();
    queue.turn();
    assert_eq!(queue.len(), 0);
}

/// Every value that is wanted and free reaches its sample once; the others do not.
#[test]
fn shadow_rays_deliver_to_their_samples() {
    let mut shadows = Shadows::default();
    let mut radiance = [Rgb8::default(); 8];
    let mut expected = [0.0f32; 64];
    let mut deliver = |shadows: &mut Shadows, expected: &mut [f32; 64], waiting: &mut Vec<(usize, f32)>| {
        let rays = shadows.rays();
        assert_eq!(rays.active(), (1 << waiting.len()) - 1, "lanes without a ray are idle");
        let free = shadows.take() & 0b1011_0110;
        shadows.deliver(free, &mut radiance);
        for (lane, (slot, value)) in waiting.drain(..).enumerate() {
            expected[slot] += if free >> lane & 1 == 1 { value } else { 0.0 };
        }
    };
    let mut waiting = Vec::new();
    for k in 0..40u32 {
        let value = lanes(|lane| 1.0 + (8 * k + lane as u32) as f32);
        let slot = u32x8::from(core::array::from_fn::<u32, 8, _>(|lane| hash(8 * k + lane as u32) % 64));
        let (zero, t_max) = (Vec3x8::default(), f32x8::ONE);
        let value3 = Vec3x8::new(value, value, value);
        let rays = ShadowRays { origin: zero, direction: zero, t_max, value: value3, slot };
        let mut wanted = hash(k) & 0xff;
        while wanted != 0 {
            let left = shadows.fill(&rays, wanted);
            let taken = wanted & !left;
            for lane in (0..8).filter(|lane| taken >> lane & 1 == 1) {
                waiting.push((slot.to_array()[lane] as usize, value.to_array()[lane]));
            }
            wanted = left;
            if shadows.lanes() == 8 {
                deliver(&mut shadows, &mut expected, &mut waiting);
            }
        }
    }
    deliver(&mut shadows, &mut expected, &mut waiting);
    for (slot, expected) in expected.into_iter().enumerate() {
        assert_eq!(radiance[slot / 8].g.to_array()[slot % 8], expected, "sample {slot}");
    }
}

#[test]
fn lanes_that_miss_are_no_hits() {
    let data = SceneData {
        triangles: &[Triangle { corners: CORNERS }],
        surfaces: &[Surface::default()],
        materials: &[Material::default()],
        ..SceneData::default()
    };
    let scene = Scene::new(data).unwrap();
    let direction = Vec3x8::splat([0.0, 0.0, -1.0]);
    let rays = Rays8 { origin: -direction, direction, t_max: f32x8::splat(9.0) };
    let triangle = u32x8::new([0, MISS, 0, MISS, MISS, MISS, 0, 0]);
    let third = f32x8::splat(1.0 / 3.0);
    let points = SurfacePoints::at(&scene, &rays, &Hits8 { t: f32x8::ONE, u: third, v: third, triangle });
    assert_eq!(points.hit.to_bitmask(), 0b1100_0101);
}
