//! All settings of a frame.

use super::choices::{Integrator, Method, Startup};
use super::layers::Layers;
use crate::frame::schedule::{Growth, LEAST_SPP, PILOT_SPP, Target};
use crate::scene::{LoadedScene, View};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::{self, Schedule, Sequence};
use pmcip_core::tracer::camera::{self, Camera};

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
    /// The camera; where the shutter is open for a time, as it opens.
    pub view: View,
    /// The camera as the shutter closes, if it moves until then.
    pub closing_view: Option<View>,
    /// What a frame starts from that follows another one.
    pub startup: Startup,
    /// Whether a filtered frame is blended with those before it.
    pub history: bool,
    /// When to end before all samples are spent.
    pub target: Option<Target>,
    /// Seconds after which a frame ends, if that is before its samples are spent; at least one iteration is made.
    pub seconds: Option<f32>,
    /// What the frame's file has beside the picture.
    pub layers: Layers,
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
            closing_view: scene.closing_view,
            startup: Startup::Uniform,
            history: false,
            target: None,
            seconds: None,
            layers: Layers::default(),
        }
    }

    /// The camera of the frame.
    ///
    /// # Errors
    /// If the view is not defined.
    pub fn camera(&self) -> Result<Camera, camera::Error> {
        let (width, height) = (self.sampler.width, self.sampler.height);
        let camera = self.view.camera(width, height)?;
        match self.closing_view {
            None => Ok(camera),
            Some(view) => Ok(camera.moving_to(&view.camera(width, height)?)),
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
    pub(crate) fn pilot(&self) -> u32 {
        let part = self.spp / self.iterations.max(1);
        match self.method {
            Method::Pmc => part.max(1),
            // What is left over, so that all iterations give every pixel the same whole number of samples.
            Method::Uniform => self.spp - part * self.iterations.saturating_sub(1),
            Method::Paper => (self.spp / 4).max(1),
        }
    }

    /// Whether nobody knows beforehand how many samples the frame takes: then iterations grow with what has been spent.
    pub fn grows(&self) -> bool {
        self.target.is_some() || self.seconds.is_some()
    }

    /// Whether the frame goes on from its film alone: nothing is remembered of earlier frames or iterations.
    pub fn stands_alone(&self) -> bool {
        !self.history && self.target.is_none() && self.startup == Startup::Uniform
    }

    /// The core's settings for a frame whose first iteration has `pilot` samples a pixel.
    fn core(&self, pilot: u32) -> sampler::Settings {
        self.core_of(self.pixels(), pilot)
    }

    /// The same if samples go to so many `pixels` of it.
    fn core_of(&self, pixels: u64, pilot: u32) -> sampler::Settings {
        match self.grows() {
            // Nobody knows how long the frame will be, but it has no less than these.
            true => self.sampler.for_pixels(pixels, PILOT_SPP.min(pilot), self.spp.min(LEAST_SPP as u32)),
            false => self.sampler.for_pixels(pixels, pilot, self.spp),
        }
    }

    /// The core's settings for a frame.
    pub fn film(&self) -> sampler::Settings {
        self.core(self.pilot())
    }

    /// The core's settings for a film with labels, samples going to so many `pixels` of it.
    pub fn film_of(&self, pixels: u64) -> sampler::Settings {
        self.core_of(pixels, self.pilot())
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
        let expected = self.target.and_then(|target| target.expected_spp);
        let growth = self.grows().then(|| Growth::new(self.pixels(), self.spp, expected));
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
        let (from, at, up) = ([0.0; 3], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]);
        let view = View { from, at, up, fov: 40.0, aperture: 0.0, focus: None };
        let iterations = method.default_iterations(spp);
        Settings {
            spp,
            iterations,
            method,
            sampler: method.sampler(5, 2),
            integrator: Integrator::Path,
            max_depth: 8,
            view,
            closing_view: None,
            startup: Startup::Uniform,
            history: false,
            target: None,
            seconds: None,
            layers: Layers::default(),
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
