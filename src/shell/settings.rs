//! Everything that a frame's bits depend on, besides the scene's file.
//!
//! ```no_run
//! use pmcip::{render, scene, settings::{Method, Settings}};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = scene::load("scenes/caustic.toml".as_ref())?;
//! let mut settings = Settings::new(&scene, Method::Pmc, Some(16), Some((320, 240)));
//! settings.sampler.seed = 7;
//! let frame = render::render(&scene, &settings, None, &|_| ())?;
//! println!("{} samples in {} s", frame.tally.samples, frame.seconds);
//! # Ok(())
//! # }
//! ```

mod list;

pub use list::word;

use crate::scene::{LoadedScene, View};
use crate::stop::{Growth, LEAST_SPP, PILOT_SPP, Target};
use clap::ValueEnum;
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::{self, Schedule, Sequence};
use std::fmt::{self, Display, Formatter};

/// Samples a pixel where nobody says.
pub const DEFAULT_SPP: u32 = 64;
/// Path depth where nobody says.
pub const DEFAULT_DEPTH: u32 = 8;
/// Deepest paths.
pub const MAX_DEPTH: u32 = 1024;
/// Light samples of direct lighting where nobody says.
pub const DEFAULT_LIGHT_SAMPLES: u32 = 8;
/// Most light or bsdf samples of direct lighting.
pub const MAX_LIGHT_SAMPLES: u32 = 1024;
/// Photon paths where nobody says.
pub const DEFAULT_PHOTONS: u32 = 200_000;
/// Most photon paths: they take about 400 bytes each while they are shot.
pub const MAX_PHOTONS: u32 = 20_000_000;

/// How light is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Integrator {
    /// Path tracing: all light, with one ray to a light at each bounce.
    Path,
    /// Direct lighting: light that reaches a rough surface straight from a lamp, seen directly or through mirrors
    /// and glass.
    Direct {
        /// Points on lights that each pixel sample aims at, at least 1.
        light_samples: u32,
        /// Directions that each pixel sample draws from the scattering function, at least 1.
        bsdf_samples: u32,
    },
    /// Photon mapping: all light, what comes after the first bounce from maps that are shot once a frame.
    Gather {
        /// Photon paths of the global map. The caustic map gets about half as many photons, if there are caustics.
        photons: u32,
        /// Seed of the maps: renders that differ in the sampler's seed alone share them.
        photon_seed: u32,
    },
}

impl Integrator {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Integrator::Path => "path",
            Integrator::Direct { .. } => "direct",
            Integrator::Gather { .. } => "gather",
        }
    }

    /// What the picture depends on that it converges to as samples grow.
    pub fn limit(self) -> String {
        match self {
            Integrator::Path | Integrator::Direct { .. } => self.name().into(),
            Integrator::Gather { photons, photon_seed } => format!("gather {photons} {photon_seed}"),
        }
    }
}

/// Where samples go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Where the eye would see noise, with this project's defaults
    Pmc,
    /// Everywhere the same
    Uniform,
    /// As Lai et al. 2010 published it: weights of power 1, no window; loses energy
    Paper,
}

/// What a frame of an animation starts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Startup {
    /// From nothing: uniform samples
    #[default]
    Uniform,
    /// From earlier frames, carried along by homographies that are found in the pictures alone
    Homography,
    /// From earlier frames, carried along by the depth and the motion of what is seen
    Motion,
}

/// How samples become pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Estimate {
    /// Unbiased over neighbourhoods, with little more noise than pooled
    Balanced,
    /// The mean of all samples of a pixel; adaptive sampling makes it too dark
    Pooled,
    /// The mean of the iterations' images; unbiased, as each is sampled anew
    Subframe,
    /// Unbiased in every pixel, noisy where samples are few
    Difference,
    /// Filtered, with every neighbourhood's light as unbiased samples have it
    Guided,
}

impl From<Estimate> for Estimator {
    fn from(estimate: Estimate) -> Estimator {
        match estimate {
            Estimate::Balanced => Estimator::Balanced,
            Estimate::Pooled => Estimator::Pooled,
            Estimate::Subframe => Estimator::Subframe,
            Estimate::Difference => Estimator::Difference,
            Estimate::Guided => Estimator::Guided,
        }
    }
}

impl Method {
    /// Iterations for `spp` samples a pixel: of two samples a pixel, at most sixteen; three as published.
    pub fn default_iterations(self, spp: u32) -> u32 {
        match self {
            Method::Pmc => (spp / 2).clamp(1, 16),
            // They learn nothing from each other: small enough for the core's limit and for a bar that moves.
            Method::Uniform => spp.div_ceil(8),
            Method::Paper => spp.min(3),
        }
    }

    /// The core's settings for a film of this size.
    fn sampler(self, width: u32, height: u32) -> sampler::Settings {
        match self {
            Method::Pmc => sampler::Settings::new(width, height),
            Method::Uniform => sampler::Settings::uniform(width, height),
            Method::Paper => sampler::Settings::paper(width, height),
        }
    }
}

impl Display for Method {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Method::Pmc => "pmc",
            Method::Uniform => "uniform",
            Method::Paper => "paper",
        })
    }
}

/// The settings of a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Samples a pixel on average.
    pub spp: u32,
    /// Rounds of sampling; the first is uniform.
    pub iterations: u32,
    /// Where samples go.
    pub method: Method,
    /// The core's settings, size and seed among them.
    pub sampler: sampler::Settings,
    /// How light is followed.
    pub integrator: Integrator,
    /// Longest path in segments, counted from the eye.
    pub max_depth: u32,
    /// The camera.
    pub view: View,
    /// What a frame starts from that follows another one.
    pub startup: Startup,
    /// When to end before all samples are spent.
    pub target: Option<Target>,
}

impl Settings {
    /// What the scene asks for, with the method's defaults for the rest; `size` instead of the scene's own.
    pub fn new(scene: &LoadedScene, method: Method, spp: Option<u32>, size: Option<(u32, u32)>) -> Settings {
        let spp = spp.or(scene.spp).unwrap_or(DEFAULT_SPP);
        let (width, height) = size.unwrap_or((scene.width, scene.height));
        Settings {
            spp,
            iterations: method.default_iterations(spp),
            method,
            sampler: sampler::Settings { cd_per_unit: scene.cd_per_unit, ..method.sampler(width, height) },
            integrator: Integrator::Path,
            max_depth: scene.max_depth.unwrap_or(DEFAULT_DEPTH),
            view: scene.view,
            startup: Startup::Uniform,
            target: None,
        }
    }

    /// Picks an estimator, and the sequence of points that its freedom from bias needs.
    pub fn set_estimator(&mut self, estimator: Estimator) {
        self.sampler.estimator = estimator;
        if estimator == Estimator::Subframe {
            self.sampler.sequence = Sequence::Fresh;
        }
    }

    /// Samples a pixel of the first iteration.
    fn pilot(&self) -> u32 {
        let part = self.spp / self.iterations.max(1);
        match self.method {
            Method::Pmc => part.max(1),
            // What is left over, so that all iterations give every pixel the same whole number of samples.
            Method::Uniform => self.spp - part * self.iterations.saturating_sub(1),
            Method::Paper => (self.spp / 4).max(1),
        }
    }

    /// The core's settings for a frame whose first iteration has `pilot` samples a pixel: as many samples are fair as every
    /// pixel is promised before the frame can end.
    fn core(&self, pilot: u32) -> sampler::Settings {
        let (pilot, least) = match self.target {
            Some(_) => (PILOT_SPP.min(pilot), self.spp.min(LEAST_SPP as u32)),
            None => (pilot, self.spp),
        };
        let promised = self.sampler.defensive * least.saturating_sub(pilot) as f32;
        sampler::Settings { fair: pilot + promised as u32, ..self.sampler }
    }

    /// The core's settings for a frame.
    pub fn film(&self) -> sampler::Settings {
        self.core(self.pilot())
    }

    /// The same for a frame that starts from a prediction.
    pub fn predicted_film(&self) -> sampler::Settings {
        if self.method == Method::Pmc { self.core(1) } else { self.film() }
    }

    /// Samples of each iteration, at most.
    pub fn schedule(&self) -> impl Iterator<Item = u64> {
        self.schedule_after(self.pilot(), self.iterations)
    }

    /// The same for a frame that starts from a prediction: the first iteration is one sample a pixel, and there is one
    /// iteration more.
    pub fn predicted_schedule(&self) -> impl Iterator<Item = u64> {
        match self.method {
            Method::Pmc => self.schedule_after(1, self.iterations.saturating_add(1)),
            _ => self.schedule_after(self.pilot(), self.iterations),
        }
    }

    fn schedule_after(&self, pilot: u32, iterations: u32) -> impl Iterator<Item = u64> + use<> {
        let growth = self.target.map(|target| Growth::new(self.pixels(), self.spp, target.expected_spp));
        let fixed = || Schedule::new(self.pixels(), self.spp, pilot, iterations);
        let fixed = growth.is_none().then(fixed);
        growth.into_iter().flatten().chain(fixed.into_iter().flatten())
    }

    /// Pixels of the film.
    pub fn pixels(&self) -> u64 {
        u64::from(self.sampler.width) * u64::from(self.sampler.height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pmcip_core::sampler::estimate::Estimator;

    /// Settings for a film of ten pixels.
    fn settings(method: Method, spp: u32) -> Settings {
        let view = View { from: [0.0; 3], at: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0], fov: 40.0 };
        let iterations = method.default_iterations(spp);
        Settings {
            spp,
            iterations,
            method,
            sampler: method.sampler(5, 2),
            integrator: Integrator::Path,
            max_depth: 8,
            view,
            startup: Startup::Uniform,
            target: None,
        }
    }

    fn schedule(method: Method, spp: u32) -> Vec<u64> {
        settings(method, spp).schedule().collect()
    }

    #[test]
    fn schedules_are_those_of_the_design() {
        assert_eq!(schedule(Method::Pmc, 16), [20; 8]);
        assert_eq!(schedule(Method::Pmc, 64), [40; 16]);
        assert_eq!(schedule(Method::Paper, 16), [40, 60, 60]);
        assert_eq!(schedule(Method::Uniform, 5), [50]);
    }

    #[test]
    fn every_budget_is_spent_and_uniform_parts_are_whole() {
        for spp in 1..200 {
            for method in [Method::Pmc, Method::Uniform, Method::Paper] {
                assert_eq!(schedule(method, spp).iter().sum::<u64>(), 10 * u64::from(spp), "{method} {spp}");
            }
            assert!(schedule(Method::Uniform, spp).iter().all(|samples| samples % 10 == 0), "{spp}");
        }
    }

    #[test]
    fn subframe_gets_the_points_it_needs() {
        let mut settings = settings(Method::Pmc, 16);
        settings.set_estimator(Estimator::Subframe);
        assert_eq!(settings.sampler.sequence, Sequence::Fresh);
    }
}
