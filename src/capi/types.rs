//! What crosses the border by value.

use pmcip_core::predict::Belief;
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::guide::Feature;
use pmcip_core::sampler::{self, Error, Mode, Sequence, Tally};

/// What a call came to. `pmcip_message` says it in words.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PmcipStatus {
    /// It was done.
    Ok = 0,
    /// There are no more jobs.
    Done = 1,
    /// A pointer that must not be NULL is, or is not aligned.
    Pointer = 2,
    /// Memory is shorter than asked for.
    Memory = 3,
    /// A setting is out of range.
    Settings = 4,
    /// An iteration without samples, or with more than 2^32 - 1.
    Samples = 5,
    /// Calls in the wrong order: begin, then the samples, then end; read between iterations.
    Order = 6,
    /// Not all samples of the iteration have been delivered.
    Unfinished = 7,
    /// The film accumulates for another estimator.
    Estimator = 8,
    /// Labels are all 0.
    Labels = 9,
    /// Arrays have no room for the samples of a single pixel.
    Room = 10,
    /// A piece that was delivered already, is of another iteration, or comes with another number of radiances.
    Piece = 11,
    /// Bytes that are not a saved film of this version.
    Saved = 12,
    /// A fault of the library: please report it. The film must not be used any more.
    Fault = 13,
}

impl From<Error> for PmcipStatus {
    fn from(error: Error) -> Self {
        match error {
            Error::Memory | Error::Scratch | Error::Workspace => PmcipStatus::Memory,
            Error::Samples => PmcipStatus::Samples,
            Error::Begun | Error::NotBegun | Error::Running => PmcipStatus::Order,
            Error::Unfinished => PmcipStatus::Unfinished,
            Error::Estimator | Error::Guide => PmcipStatus::Estimator,
            Error::Labels => PmcipStatus::Labels,
            Error::Wave => PmcipStatus::Room,
            Error::Piece => PmcipStatus::Piece,
            Error::Saved => PmcipStatus::Saved,
            _ => PmcipStatus::Settings,
        }
    }
}

/// Which estimator makes the picture.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PmcipEstimator {
    /// The mean of all samples: biased.
    Pooled = 0,
    /// The average of the iterations' pictures.
    Subframe = 1,
    /// The mean of each pixel's first samples: unbiased, and noisy.
    Difference = 2,
    /// Pooled, with the energy it lost given back to the neighbourhood. The default.
    Balanced = 3,
}

/// The estimator of a number, which C may have got wrong.
pub(crate) fn estimator(number: u32) -> Option<Estimator> {
    let all = [Estimator::Pooled, Estimator::Subframe, Estimator::Difference, Estimator::Balanced];
    all.get(number as usize).copied()
}

/// Everything a film is asked for. Fill it by `pmcip_settings_new` and change what you like.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct PmcipSettings {
    /// Columns and rows, 1 to 16384.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Seed of all randomness.
    pub seed: u32,
    /// Number of the frame: another frame has other noise.
    pub frame: u32,
    /// Luminance in cd/m^2 of radiance 1; positive.
    pub cd_per_unit: f32,
    /// The same number of samples everywhere, if not 0.
    pub uniform: u32,
    /// What is accumulated: a `pmcip_estimator`.
    pub estimator: u32,
    /// Sequences begin anew in every iteration, if not 0.
    pub fresh: u32,
    /// Exponent of the weights, 0 to 4.
    pub gamma: f32,
    /// Part of the samples that is given out uniformly, 0 to 1.
    pub epsilon: f32,
    /// Part of an iteration that is promised to every pixel until it has its fair samples, 0 to 1.
    pub defensive: f32,
    /// First samples of each pixel that the energy is taken from; 0 to let `pmcip_settings_new` choose.
    pub fair: u32,
    /// Radius in pixels over which energy is given back, at most 4096.
    pub balance_radius: u32,
}

impl From<sampler::Settings> for PmcipSettings {
    fn from(s: sampler::Settings) -> Self {
        PmcipSettings {
            width: s.width,
            height: s.height,
            seed: s.seed,
            frame: s.frame,
            cd_per_unit: s.cd_per_unit,
            uniform: u32::from(s.mode == Mode::Uniform),
            estimator: s.estimator as u32,
            fresh: u32::from(s.sequence == Sequence::Fresh),
            gamma: s.gamma,
            epsilon: s.epsilon,
            defensive: s.defensive,
            fair: s.fair,
            balance_radius: s.balance_radius,
        }
    }
}

impl PmcipSettings {
    /// Those of the core.
    pub(crate) fn settings(&self) -> Result<sampler::Settings, PmcipStatus> {
        Ok(sampler::Settings {
            width: self.width,
            height: self.height,
            seed: self.seed,
            frame: self.frame,
            cd_per_unit: self.cd_per_unit,
            mode: if self.uniform == 0 { Mode::Adaptive } else { Mode::Uniform },
            estimator: estimator(self.estimator).ok_or(PmcipStatus::Settings)?,
            sequence: if self.fresh == 0 { Sequence::Continued } else { Sequence::Fresh },
            gamma: self.gamma,
            epsilon: self.epsilon,
            defensive: self.defensive,
            fair: self.fair,
            balance_radius: self.balance_radius,
            ..sampler::Settings::new(self.width, self.height)
        })
    }
}

/// A part of the film whose samples were planned together.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct PmcipPiece {
    /// The first pixel, in storage order.
    pub first: usize,
    /// One after the last: where the next piece begins; the number of the film's pixels after the last piece.
    pub end: usize,
    /// Samples planned.
    pub samples: usize,
}

/// Samples of all iterations.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct PmcipTally {
    /// Samples in the film.
    pub samples: u64,
    /// Samples left out because a component was not finite or beyond 1e15.
    pub rejected: u64,
}

impl From<Tally> for PmcipTally {
    fn from(tally: Tally) -> Self {
        PmcipTally { samples: tally.samples, rejected: tally.rejected }
    }
}

/// What is seen through a pixel, averaged over it; all 0 where nothing is.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct PmcipFeature {
    /// Part of the light that the surface reflects, 1 where it shines itself.
    pub albedo: [f32; 3],
    /// Shading normal.
    pub normal: [f32; 3],
    /// Length of the way from the eye, in any unit.
    pub depth: f32,
}

/// What is believed of a pixel before a frame has seen it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct PmcipBelief {
    /// Variance of a sample's luminance.
    pub variance: f32,
    /// Mean luminance.
    pub light: f32,
    /// Of how many samples more than one the variance could be; 0: nothing is known.
    pub freedom: f32,
}

// Arrays of these are taken for arrays of the core's.
const _: () = assert!(size_of::<PmcipFeature>() == size_of::<Feature>());
const _: () = assert!(size_of::<PmcipBelief>() == size_of::<Belief>());
