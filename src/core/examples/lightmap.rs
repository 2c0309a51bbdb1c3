//! A lightmap with the core alone: two walls of a room in one atlas, lit by a lamp, with a ball in between.
//!
//! What an engine brings: which texel is which surface's (labels), the point of the surface that a texel shows, and a function
//! for the light that falls there. The core says where samples go, filters inside islands, and gives each the energy of its own
//! samples. Memory is the caller's; here it is on the heap of the example, the core has none.
//!
//! `cargo run --release -p pmcip-core --example lightmap > lightmap.pgm` writes a picture.

use pmcip_core::maths::vec3::Vec3x8;
use pmcip_core::sampler::batch::{Batch8, MAX_RADIANCE, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::guide::{Feature, Filter};
use pmcip_core::sampler::{Error, Memory, Sampler, Schedule, Settings, Workspace};
use std::io::Write;
use wide::f32x8;

/// Texels a side.
const SIZE: u32 = 128;
/// Texels from the border of the atlas to an island, and half of those between islands.
const GUTTER: u32 = 4;
/// Samples a texel in use.
const SPP: u32 = 16;

/// A flat wall, laid out in a rectangle of the atlas.
struct Wall {
    /// First column and row, and one past the last.
    texels: [[u32; 2]; 2],
    /// The point at the first corner, and the edges to its neighbours, in metres.
    corner: [f32; 3],
    edges: [[f32; 3]; 2],
    normal: [f32; 3],
}

/// The floor and the wall behind it.
const WALLS: [Wall; 2] = [
    Wall {
        texels: [[GUTTER, GUTTER], [SIZE / 2 - GUTTER, SIZE - GUTTER]],
        corner: [-1.0, 0.0, -1.0],
        edges: [[2.0, 0.0, 0.0], [0.0, 0.0, 4.0]],
        normal: [0.0, 1.0, 0.0],
    },
    Wall {
        texels: [[SIZE / 2 + GUTTER, GUTTER], [SIZE - GUTTER, SIZE / 2]],
        corner: [-1.0, 0.0, -1.0],
        edges: [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
        normal: [0.0, 0.0, 1.0],
    },
];

/// A square lamp of one metre a side that faces down, and its radiance.
const LAMP: [f32; 3] = [0.0, 2.5, 0.5];
const RADIANCE: f32 = 10.0;
/// A ball that throws a shadow.
const BALL: ([f32; 3], f32) = ([0.0, 0.8, 0.2], 0.4);

/// The wall a texel shows, if it shows one.
fn wall(x: u32, y: u32) -> Option<usize> {
    let inside = |wall: &Wall| {
        [x, y].iter().zip(wall.texels[0].iter().zip(&wall.texels[1])).all(|(at, (a, b))| (a..b).contains(&at))
    };
    WALLS.iter().position(inside)
}

/// The point that a place of a wall's rectangle shows.
fn point(wall: &Wall, place: [f32; 2]) -> [f32; 3] {
    let [least, most] = wall.texels.map(|corner| corner.map(|at| at as f32));
    let part = [0, 1].map(|k| (place[k] - least[k]) / (most[k] - least[k]));
    [0, 1, 2].map(|i| wall.corner[i] + part[0] * wall.edges[0][i] + part[1] * wall.edges[1][i])
}

/// The irradiance at eight places by one point of the lamp each: what an engine would trace.
fn light(batch: &Batch8) -> Rgb8 {
    let (x, y) = (batch.x.to_array(), batch.y.to_array());
    let mut rows = [[0.0; 8]; 6];
    for lane in 0..8 {
        // All places are on walls: the film's labels say so.
        let wall = &WALLS[wall(x[lane] as u32, y[lane] as u32).unwrap_or_default()];
        let at = point(wall, [x[lane], y[lane]]);
        let values = at.iter().chain(&wall.normal);
        rows.iter_mut().zip(values).for_each(|(row, value)| row[lane] = *value);
    }
    let vector = |i: usize| Vec3x8::new(rows[i].into(), rows[i + 1].into(), rows[i + 2].into());
    let (position, normal) = (vector(0), vector(3));
    let (u, v) = batch.point(1);
    let offset = Vec3x8::new(u - f32x8::HALF, f32x8::ZERO, v - f32x8::HALF);
    let toward = Vec3x8::splat(LAMP) + offset - position;
    let square = toward.dot(toward);
    // The lamp faces down, so that its cosine is the way's own height.
    let cosines = toward.dot(normal).fast_max(f32x8::ZERO) * toward.y.fast_max(f32x8::ZERO);
    let (centre, radius) = (Vec3x8::splat(BALL.0) - position, f32x8::splat(BALL.1));
    let along = centre.dot(toward) / square;
    let miss = centre - toward * along.fast_max(f32x8::ZERO).fast_min(f32x8::ONE);
    let free = miss.dot(miss).simd_gt(radius * radius);
    let value = free & (f32x8::splat(RADIANCE) * cosines / (square * square));
    Rgb8 { r: value, g: value, b: value }
}

fn main() -> Result<(), Error> {
    let texels = || (0..SIZE * SIZE).map(|i| (i % SIZE, i / SIZE));
    let labels: Vec<u8> = texels().map(|(x, y)| wall(x, y).map_or(0, |wall| wall as u8 + 1)).collect();

    // What the core needs is lent.
    let required = Sampler::required_with_labels(SIZE, SIZE);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    let memory = Memory { floats: &mut floats, words: &mut words };
    let used = labels.iter().filter(|label| **label != 0).count() as u64;
    let settings = Settings::new(SIZE, SIZE).for_pixels(used, 2, SPP);
    let mut sampler = Sampler::with_labels(settings, memory, &labels)?;

    // Jobs may go to any threads.
    let (mut batches, mut radiance) = ([Batch8::default(); 64], [Rgb8::default(); 64]);
    let mut work = Workspace::new(&mut batches, &mut radiance)?;
    for samples in Schedule::new(used, SPP, 2, 8) {
        sampler.begin(samples)?;
        for mut job in sampler.jobs() {
            job.render(&mut light, &mut work);
        }
        sampler.end()?;
    }

    // The filter compares texels by what the engine knows of them: flat walls have one normal and one height.
    let feature = |(x, y)| {
        let known = |wall: usize| Feature { albedo: [1.0; 3], normal: WALLS[wall].normal, depth: 1.0 };
        wall(x, y).map_or(Feature::default(), known)
    };
    let features: Vec<Feature> = texels().map(feature).collect();
    let mut scratch = vec![0.0; Filter::required_by(&sampler)];
    let mut filter = Filter::new(&sampler, &features, &mut scratch)?;
    for _ in 0..Filter::PASSES {
        filter.bands().for_each(|mut band| band.filter());
        filter.next();
    }
    let mut guide = vec![[0.0; 3]; features.len()];
    filter.write(&mut guide)?;
    let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(SIZE, SIZE)];
    let (mut baked, mut plain) = (guide.clone(), vec![0.0; 3 * guide.len()]);
    sampler.resolve_guided(&guide, &mut scratch, &mut baked)?;
    sampler.resolve(Estimator::Balanced, &mut scratch, &mut plain)?;

    // Filtered or not, each island has the energy of its own samples.
    for (i, name) in ["floor", "wall"].iter().enumerate() {
        let sum = |of: &dyn Fn(usize) -> f32| -> f64 {
            (0..labels.len()).filter(|k| labels[*k] as usize == i + 1).map(|k| f64::from(of(k))).sum()
        };
        let (filtered, samples) = (sum(&|k| baked[k][0]), sum(&|k| plain[3 * k]));
        assert!((filtered / samples - 1.0).abs() < 1e-3 && samples < f64::from(MAX_RADIANCE));
        eprintln!(
            "{name}: mean irradiance {:.4}",
            filtered / labels.iter().filter(|l| **l as usize == i + 1).count() as f64
        );
    }
    let mut out = std::io::stdout().lock();
    let grey =
        baked.iter().map(|rgb| (255.0 * (rgb[0] / 4.0).clamp(0.0, 1.0).sqrt()) as u8).collect::<Vec<u8>>();
    let written = write!(out, "P5\n{SIZE} {SIZE}\n255\n").and_then(|()| out.write_all(&grey));
    written.map_err(|_| Error::Output)
}
