//! A film of an analytic integrand in memory of its own, as a number: the same wherever the sampler has the same bits.

use pmcip_core::sampler::batch::{Batch8, Rgb8};
use pmcip_core::sampler::{Error, Memory, Sampler, Schedule, Settings, Workspace};

const WIDTH: u32 = 48;
const HEIGHT: u32 = 31;
const PIXELS: usize = (WIDTH * HEIGHT) as usize;

/// Noise that grows to the right, and to the bottom where it is green.
fn noise(batch: &Batch8) -> Rgb8 {
    let (u, v) = batch.point(1);
    Rgb8 { r: u * batch.x, g: (u * v).sqrt() * batch.y, b: u }
}

/// Of all bits of picture, kernel and counts after six iterations, in order (FNV-1a over words).
pub fn digest() -> Result<u64, Error> {
    let (mut floats, mut words) = ([0.0; 8 * PIXELS], [0; 3 * PIXELS]);
    let memory = Memory { floats: &mut floats, words: &mut words };
    let mut sampler = Sampler::new(Settings::new(WIDTH, HEIGHT).for_frame(2, 12), memory)?;
    let (mut batches, mut radiance) = ([Batch8::default(); 9], [Rgb8::default(); 9]);
    let mut work = Workspace::new(&mut batches, &mut radiance)?;
    for samples in Schedule::new(PIXELS as u64, 12, 2, 6) {
        sampler.begin(samples)?;
        sampler.jobs().for_each(|mut job| _ = job.render(&mut { noise }, &mut work));
        sampler.end()?;
    }
    let mut scratch = [[0.0; 16]; PIXELS];
    let (mut rgb, mut alpha, mut count) = ([0.0; 3 * PIXELS], [0.0; PIXELS], [0; PIXELS]);
    sampler.resolve(sampler.settings().estimator, &mut scratch, &mut rgb)?;
    sampler.alpha(&mut alpha)?;
    sampler.count(&mut count)?;
    let bits = rgb.iter().chain(&alpha).map(|value: &f32| value.to_bits()).chain(count);
    Ok(bits.fold(0xcbf2_9ce4_8422_2325, |sum, word| (sum ^ u64::from(word)).wrapping_mul(0x0100_0000_01b3)))
}
