//! What a render is asked for, and what can be wrong with it.

use crate::sampler::allocate;
use crate::sampler::estimate::{Estimator, MAX_RADIUS};
use crate::sampler::film::{Layout, MAX_SIDE};
use crate::sampler::kernel::{Criterion, Kernel, Window};

/// Where samples go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Where the kernel says.
    #[default]
    Adaptive,
    /// Everywhere alike.
    Uniform,
}

/// How a pixel's Sobol sequence goes on in the next iteration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sequence {
    /// With points that complete those of earlier iterations: best stratified.
    #[default]
    Continued,
    /// Anew, scrambled by another key.
    Fresh,
}

/// Everything a sampler is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Columns, 1 to 16384.
    pub width: u32,
    /// Rows, 1 to 16384.
    pub height: u32,
    /// Seed of all randomness.
    pub seed: u32,
    /// Number of the frame: another frame has other noise.
    pub frame: u32,
    /// Luminance in cd/m² of radiance 1; positive.
    pub cd_per_unit: f32,
    /// Adaptive or uniform.
    pub mode: Mode,
    /// What is accumulated, for [`Sampler::resolve`](super::Sampler::resolve).
    pub estimator: Estimator,
    /// How sequences go on.
    pub sequence: Sequence,
    /// What the kernel evens out.
    pub criterion: Criterion,
    /// Pixels the kernel looks at.
    pub window: Window,
    /// γ, exponent of the weights, 0 to 4.
    pub gamma: f32,
    /// ε, the part given out uniformly, 0 to 1.
    pub epsilon: f32,
    /// Part of an iteration's samples that is promised to every pixel alike, whatever has been seen, until it has its fair
    /// samples, 0 to 1.
    pub defensive: f32,
    /// Fair samples of a pixel: its first ones, of which the estimators `difference` and `balanced` take their energy, and
    /// whose noise that has. More than the part `defensive` of the frame's samples and the first iteration are not
    /// promised in time, and an estimate with fewer is as biased as `pooled`. At least those of the first iteration: 0 if
    /// nothing is known of what follows, else see [`for_frame`](Self::for_frame).
    pub fair: u32,
    /// Radius r in pixels of the balanced estimator's three boxes: σ² is about r(r + 1), and at least 16, as it works on
    /// cells of 8 × 8 pixels.
    pub balance_radius: u32,
}

/// Pixels from which on a quarter of the samples are enough for the energy.
const SMALL: u64 = 1 << 16;
/// Fair samples of a pixel, where there are twice as many in all.
const LEAST_FAIR: u32 = 4;
/// Samples a pixel that are promised beyond the fair ones, so that none is lost to rounding.
const SPARE: f32 = 0.01;

impl Settings {
    /// The defaults, found by measurement: variance of the mean, γ 0.8, binomial window, ε 0.01, balanced with σ 96.5
    /// pixels. A third of the samples are promised until every pixel has its fair ones, of which none are fixed yet: see
    /// [`for_frame`](Self::for_frame).
    pub fn new(width: u32, height: u32) -> Settings {
        Settings {
            width,
            height,
            seed: 0,
            frame: 0,
            cd_per_unit: 100.0,
            mode: Mode::Adaptive,
            estimator: Estimator::Balanced,
            sequence: Sequence::Continued,
            criterion: Criterion::Mean,
            window: Window::Square3,
            gamma: 0.8,
            epsilon: 0.01,
            defensive: 1.0 / 3.0,
            fair: 0,
            balance_radius: 96,
        }
    }

    /// The method as published: γ 1, no window, nothing promised but the first iteration, ε 0.01, pooled.
    pub fn paper(width: u32, height: u32) -> Settings {
        Settings {
            estimator: Estimator::Pooled,
            criterion: Criterion::Sample,
            window: Window::Pixel,
            gamma: 1.0,
            defensive: 0.0,
            ..Settings::new(width, height)
        }
    }

    /// Fixes the fair samples of a frame of `spp` samples a pixel, `pilot` of them in the first iteration: as many as
    /// [`fair`](Self::fair) says, or if that is 0 the power of two up to a quarter, up to half in a picture of less than
    /// 2¹⁶ pixels, where neighbourhoods are small; four if there are eight in all. Points of a Sobol sequence are best in
    /// such numbers; more make the energy less noisy and the picture noisier, see
    /// [`defaults`](super#how-the-defaults-were-chosen). Promises just what that takes, or nothing where
    /// [`defensive`](Self::defensive) is 0.
    pub fn for_frame(self, pilot: u32, spp: u32) -> Settings {
        self.for_pixels(u64::from(self.width) * u64::from(self.height), pilot, spp)
    }

    /// As [`for_frame`](Self::for_frame), for a film with labels, of which `pixels` have one that is not 0: the others do not
    /// make a picture large.
    pub fn for_pixels(self, pixels: u64, pilot: u32, spp: u32) -> Settings {
        if self.defensive == 0.0 || spp <= pilot {
            return self;
        }
        let part = if pixels < SMALL { spp / 2 } else { spp / 4 };
        let part = part.max(LEAST_FAIR.min(spp / 2)).max(1);
        let fair = if self.fair > 0 { self.fair } else { 1 << part.ilog2() }.clamp(pilot, spp);
        let defensive = ((fair - pilot) as f32 + SPARE) / (spp - pilot) as f32;
        Settings { fair, defensive: defensive.min(1.0), ..self }
    }

    /// The same number of samples everywhere.
    pub fn uniform(width: u32, height: u32) -> Settings {
        Settings { mode: Mode::Uniform, estimator: Estimator::Pooled, ..Settings::new(width, height) }
    }

    /// The layout of the film, if every setting is within its range.
    pub(super) fn check(&self) -> Result<Layout, Error> {
        let layout = Layout::new(self.width, self.height).ok_or(Error::Size)?;
        if !(self.cd_per_unit > 0.0 && self.cd_per_unit.is_finite()) {
            return Err(Error::CdPerUnit);
        }
        if !(0.0..=4.0).contains(&self.gamma) {
            return Err(Error::Gamma);
        }
        if !(0.0..=1.0).contains(&self.epsilon) {
            return Err(Error::Epsilon);
        }
        if !(0.0..=1.0).contains(&self.defensive) {
            return Err(Error::Defensive);
        }
        if self.balance_radius > MAX_RADIUS {
            return Err(Error::BalanceRadius);
        }
        Ok(layout)
    }

    pub(super) fn kernel(&self) -> Kernel {
        Kernel {
            criterion: self.criterion,
            gamma: self.gamma,
            window: self.window,
            cd_per_unit: self.cd_per_unit,
        }
    }
}

/// What can be wrong with a sampler's use.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// A side of the film is 0 or too long.
    Size,
    /// `cd_per_unit` is not positive and finite.
    CdPerUnit,
    /// γ is out of range.
    Gamma,
    /// ε is out of range.
    Epsilon,
    /// The defensive part is out of range.
    Defensive,
    /// The balanced estimator's radius is too large.
    BalanceRadius,
    /// Lent memory is shorter than [`Sampler::required`](super::Sampler::required) says.
    Memory,
    /// A workspace without room for a batch.
    Workspace,
    /// An iteration without samples, or with too many.
    Samples,
    /// `begin` while an iteration is running.
    Begun,
    /// `end` without an iteration running.
    NotBegun,
    /// `end` before every job was rendered.
    Unfinished,
    /// The film was asked for while an iteration is running.
    Running,
    /// The film accumulates for another estimator.
    Estimator,
    /// Scratch is shorter than [`Sampler::resolve_scratch`](super::Sampler::resolve_scratch) says.
    Scratch,
    /// Arrays of a wavefront have no room for the samples of a single pixel.
    Wave,
    /// A piece that was delivered already, is of another iteration, or comes with another number of radiances.
    Piece,
    /// Bytes that are not a saved film of this version, or damaged.
    Saved,
    /// Films that are to be merged are not of the same frame with different seeds.
    Merge,
    /// Labels have not the length of the picture, or all are 0.
    Labels,
    /// A prediction has not the length of the picture.
    Prior,
    /// An output has not the length of the picture.
    Output,
    /// A guide or a plane of features has not one entry a pixel.
    Guide,
}

impl core::fmt::Display for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let text = match self {
            Error::Size => return write!(f, "width and height must be 1 to {MAX_SIDE} pixels"),
            Error::BalanceRadius => {
                return write!(f, "the balance radius must be at most {MAX_RADIUS} pixels");
            }
            Error::CdPerUnit => "cd_per_unit must be positive and finite",
            Error::Gamma => "gamma must be between 0 and 4",
            Error::Epsilon => "epsilon must be between 0 and 1",
            Error::Defensive => "the defensive part must be between 0 and 1",
            Error::Memory => "lent memory is too short: lend as much as Sampler::required says",
            Error::Workspace => "a workspace needs room for at least one batch and one radiance",
            Error::Samples => "an iteration must have 1 to 2^32 - 1 samples: use more iterations for more",
            Error::Begun => "an iteration is running: end it before the next one begins",
            Error::NotBegun => "no iteration is running: begin one first",
            Error::Unfinished => "render every job of the iteration before its end",
            Error::Running => "an iteration is running: end it before the film is read",
            Error::Estimator => "the film accumulates for another estimator: set Settings::estimator",
            Error::Scratch => "scratch is too short: lend as much as Sampler::resolve_scratch says",
            Error::Wave => {
                "no room for the samples of one pixel: lend arrays as long as the iteration has samples"
            }
            Error::Piece => {
                "a piece is delivered once, in its iteration, with a radiance for each of its samples"
            }
            Error::Saved => "not a saved film of this version, or damaged",
            Error::Merge => "only films of the same frame with different seeds can be merged",
            Error::Labels => "labels must have one entry a pixel, and one must not be 0",
            Error::Prior => "a prediction must have one entry a pixel",
            Error::Guide => "a guided picture needs a guide, and that and its features one entry a pixel",
            Error::Output => "an output must have one entry a pixel, three for RGB",
        };
        f.write_str(text)
    }
}

impl core::error::Error for Error {}

impl From<allocate::Error> for Error {
    fn from(error: allocate::Error) -> Error {
        match error {
            allocate::Error::Pixels => Error::Size,
            allocate::Error::Samples => Error::Samples,
            allocate::Error::Floor => Error::Defensive,
            allocate::Error::Epsilon => Error::Epsilon,
        }
    }
}
