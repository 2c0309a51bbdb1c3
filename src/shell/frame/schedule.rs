//! When a frame may end early, and the samples of its iterations then.

use pmcip_core::sampler::allocate::MAX_SAMPLES;
use std::time::Instant;

/// Samples a pixel before which no frame ends.
pub const LEAST_SPP: u64 = 8;

/// Samples a pixel of the first iteration, and of the others at least.
pub const PILOT_SPP: u32 = 2;

/// Most samples a pixel of a frame that has a time but no number of samples.
pub const MOST_SPP: u32 = 1 << 20;

/// Ends a frame when its time is over.
#[derive(Clone, Debug)]
pub struct Clock {
    start: Instant,
    seconds: Option<f32>,
}

impl Clock {
    /// A clock that starts now, and leaves time for ever without a limit.
    pub fn new(seconds: Option<f32>) -> Clock {
        Clock { start: Instant::now(), seconds }
    }

    /// Whether the next iteration, an eighth of what has been done (see [`Growth`]), ends nearer to the limit than the last
    /// one, by the time that samples have taken so far.
    pub fn leaves_time(&self, samples: u64) -> bool {
        let spent = self.start.elapsed().as_secs_f64();
        self.seconds.is_none_or(|limit| samples == 0 || spent * (1.0 + 1.0 / 16.0) < f64::from(limit))
    }
}

/// When a frame may end before its samples are spent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Estimated Err below which it ends, above 0.
    pub err: f32,
    /// Samples a pixel that the frame will presumably take: what the one before took.
    pub expected_spp: Option<u32>,
}

/// Samples of the iterations of a frame that may end early: whole samples a pixel.
///
/// ```
/// use pmcip::frame::schedule::Growth;
///
/// let early = [2; 12].into_iter().chain([3, 3, 3, 4, 4, 5, 5, 6, 7, 8, 9, 10, 9]);
/// assert!(Growth::new(10, 100, None).map(|n| n / 10).eq(early));
/// assert!(Growth::new(10, 100, Some(80)).take(17).map(|n| n / 10).eq([5; 16].into_iter().chain([10])));
/// ```
#[derive(Clone, Debug)]
pub struct Growth {
    pixels: u64,
    most: u32,
    expected: u32,
    spent: u32,
}

impl Growth {
    /// At most `most` samples a pixel, presumably `expected`.
    pub fn new(pixels: u64, most: u32, expected: Option<u32>) -> Growth {
        Growth { pixels, most, expected: expected.unwrap_or(0).min(most), spent: 0 }
    }
}

impl Iterator for Growth {
    type Item = u64;

    fn next(&mut self) -> Option<u64> {
        let part = if self.spent < self.expected { self.expected / 16 } else { self.spent / 8 };
        let limit = (MAX_SAMPLES / self.pixels.max(1)).max(1);
        let spp =
            part.max(PILOT_SPP).min(self.most - self.spent).min(u32::try_from(limit).unwrap_or(u32::MAX));
        self.spent += spp;
        (spp > 0).then(|| self.pixels * u64::from(spp))
    }
}
