//! The smallest embedding: an analytic picture, no scene, no allocation.

use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::{Error, Memory, Sampler, Schedule, Settings, Workspace};
use wide::f32x8;

const WIDTH: u32 = 64;
const HEIGHT: u32 = 48;
const PIXELS: usize = (WIDTH * HEIGHT) as usize;

/// A noisy disc, of mean radiance 1, on a black ground.
struct Disc;

impl Integrand for Disc {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        let (x, y) = (batch.x - f32x8::splat(32.0), batch.y - f32x8::splat(24.0));
        let (u, _) = batch.point(1);
        let inside = (x * x + y * y).simd_lt(f32x8::splat(256.0));
        let value = inside & (u + u);
        Rgb8 { r: value, g: value, b: value }
    }
}

fn main() -> Result<(), Error> {
    // `Sampler::required(WIDTH, HEIGHT)` says how much to lend.
    let (mut floats, mut words) = ([0.0; 8 * PIXELS], [0; 4 * PIXELS]);
    let memory = Memory { floats: &mut floats, words: &mut words };
    let mut sampler = Sampler::new(Settings::new(WIDTH, HEIGHT).for_frame(2, 16), memory)?;

    let (mut batches, mut radiance) = ([Batch8::default(); 64], [Rgb8::default(); 64]);
    let mut work = Workspace::new(&mut batches, &mut radiance)?;
    for samples in Schedule::new(PIXELS as u64, 16, 2, 8) {
        sampler.begin(samples)?;
        for mut job in sampler.jobs() {
            job.render(&mut Disc, &mut work);
        }
        sampler.end()?;
    }

    // `Sampler::resolve_scratch(WIDTH, HEIGHT)` says how much.
    let (mut rgb, mut scratch) = ([0.0; 3 * PIXELS], [[0.0; 16]; PIXELS / 256 + WIDTH as usize]);
    sampler.resolve(Estimator::Balanced, &mut scratch, &mut rgb)?;
    let mut count = [0; PIXELS];
    sampler.count(&mut count)?;
    let energy = rgb.iter().sum::<f32>() / 3.0;
    println!("energy {energy:.1}, exact {:.1}", core::f32::consts::PI * 256.0);
    println!("samples: {} in the middle of the disc, {} in a corner", count[24 * 64 + 32], count[0]);
    Ok(())
}
