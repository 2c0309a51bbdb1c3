//! The choices that a user has.

use clap::ValueEnum;
use pmcip_core::sampler;
use pmcip_core::sampler::estimate::Estimator;
use std::fmt::{self, Display, Formatter};

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
    pub(super) fn sampler(self, width: u32, height: u32) -> sampler::Settings {
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
