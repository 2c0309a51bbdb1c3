//! What a sampler knows beyond the memory it was lent.

use super::allocate::Mixture;
use super::fair::Fair;
use super::memory::Required;
use super::settings::Settings;

/// What a sampler knows beyond the memory it was lent: for those who own both, see
/// [`Sampler::resume`](super::Sampler::resume).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    pub(super) settings: Settings,
    /// Whether pixels have labels.
    pub(super) labelled: bool,
    /// How many pixels there are: all, or those of a label other than 0.
    pub(super) used: usize,
    /// Of how many pixels the current or last iteration's mixture is.
    pub(super) open: usize,
    /// Number of the iteration that runs or is next.
    pub(super) iteration: u32,
    /// Samples of all iterations that have ended.
    pub(super) samples: u64,
    /// What has been promised to every pixel.
    pub(super) fair: Fair,
    /// How the current or last iteration divided its samples beyond that.
    pub(super) mixture: Mixture,
    /// Samples of the running iteration, 0 if none is running.
    pub(super) running: u64,
}

impl State {
    /// Of a film without samples.
    pub(super) fn new(settings: Settings, used: usize, labelled: bool) -> State {
        State {
            settings,
            labelled,
            used,
            open: used,
            iteration: 0,
            samples: 0,
            fair: Fair::default(),
            mixture: Mixture { samples: 0, floor: 0.0, epsilon: 1.0 },
            running: 0,
        }
    }

    /// The settings of the sampler.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Number of pixels that get samples.
    pub fn pixels(&self) -> usize {
        self.used
    }

    /// Samples of the iterations that have ended, rejected ones included.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Samples of the running iteration, 0 if none is running.
    pub fn running(&self) -> u64 {
        self.running
    }

    /// How much memory belongs to it.
    pub fn required(&self) -> Required {
        Required::of(self.settings.width, self.settings.height, self.labelled)
    }
}
