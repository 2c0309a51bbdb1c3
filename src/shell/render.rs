//! Renders a frame of a scene with all the processor's threads.
//!
//! The core divides an iteration into jobs that touch disjoint parts of the film. Each thread takes the next one
//! until none is left; which thread takes which does not matter, so a frame has the same bits for any number of
//! threads. Memory: about 48 bytes a pixel for the film, 28 for the result, and a scratch area for each thread.

use crate::error::Error;
use crate::frame_io::Picture;
use crate::scene::LoadedScene;
use clap::ValueEnum;
use serde::Serialize;
use std::fmt::{self, Display, Formatter};

/// Where samples go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Where the eye would see noise, with this project's defaults.
    Pmc,
    /// Everywhere the same.
    Uniform,
    /// As Lai et al. 2010 published it: γ = 1, no window, ε = 0.01, pooled; biased dark.
    Paper,
}

/// How samples become pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Estimate {
    /// Unbiased over neighbourhoods, with little more noise than `pooled`.
    Balanced,
    /// The mean of all samples of a pixel; adaptive sampling makes it dark.
    Pooled,
    /// The mean of the iterations' images; unbiased where no iteration skips a pixel.
    Subframe,
    /// Unbiased in every pixel, noisy where samples are few.
    Difference,
}

impl Method {
    /// Iterations for `spp` samples a pixel: of 2 samples a pixel, at most 16; three in the published method.
    pub fn default_iterations(self, spp: u32) -> u32 {
        match self {
            Method::Paper => spp.min(3),
            Method::Pmc => spp.div_ceil(2).min(16),
            // They do not adapt to each other: as few as the core's limit on samples allows, for a bar that moves.
            Method::Uniform => spp.div_ceil(8),
        }
    }

    /// The estimator that suits the method.
    pub fn default_estimator(self) -> Estimate {
        if self == Method::Pmc { Estimate::Balanced } else { Estimate::Pooled }
    }

    /// The power of the kernel's weights.
    pub fn default_gamma(self) -> f32 {
        match self {
            Method::Pmc => 2.0 / 3.0,
            Method::Uniform => 0.0,
            Method::Paper => 1.0,
        }
    }
}

/// The name on the command line.
fn name(value: &impl ValueEnum, f: &mut Formatter<'_>) -> fmt::Result {
    value.to_possible_value().map_or(Ok(()), |value| f.pad(value.get_name()))
}

impl Display for Method {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        name(self, f)
    }
}

impl Display for Estimate {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        name(self, f)
    }
}

/// Everything that a frame's bits depend on, besides the scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// Samples a pixel on average.
    pub spp: u32,
    /// Rounds of sampling; the first is uniform.
    pub iterations: u32,
    /// Where samples go.
    pub sampler: Method,
    /// How samples become pixels.
    pub estimator: Estimate,
    /// Power of the kernel's weights.
    pub gamma: f32,
    /// Longest path in segments, counted from the eye.
    pub max_depth: u32,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Picks the random points.
    pub seed: u32,
    /// The eye.
    pub look_from: [f32; 3],
    /// A point in the middle of the image.
    pub look_at: [f32; 3],
    /// A direction that points up in the image.
    pub up: [f32; 3],
    /// Vertical field of view in degrees.
    pub fov: f32,
}

/// A finished frame; planes are rows from the top.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Linear radiance.
    pub rgb: Vec<[f32; 3]>,
    /// Variance of the pixel's mean, luminance.
    pub variance: Vec<f32>,
    /// Samples of the pixel.
    pub count: Vec<f32>,
    /// The kernel of the last iteration; sums to one.
    pub alpha: Vec<f32>,
    /// Samples drawn.
    pub samples: u64,
    /// Samples that were not finite and left out.
    pub rejected: u64,
    /// Mean part of a ray packet's lanes that carried a ray, 0 to 1.
    pub lane_occupancy: Option<f64>,
    /// Threads that worked.
    pub threads: usize,
    /// Wall time of the render, without loading and writing.
    pub seconds: f64,
}

impl Frame {
    /// The frame as it goes to disk: the planes `variance`, `count`, `alpha`, and every setting by name.
    pub fn picture(&self, settings: &Settings, scene: &LoadedScene) -> Picture {
        let planes = [("variance", &self.variance), ("count", &self.count), ("alpha", &self.alpha)];
        let settings_and_scene =
            [("scene", scene.name.clone()), ("cd_per_unit", scene.cd_per_unit.to_string())];
        let attributes = settings_and_scene.map(|(name, value)| (name.to_owned(), value)).into_iter();
        Picture {
            width: settings.width,
            height: settings.height,
            rgb: self.rgb.clone(),
            planes: planes.into_iter().map(|(name, plane)| (name.to_owned(), plane.clone())).collect(),
            attributes: attributes.chain(settings.attributes()).collect(),
        }
    }
}

impl Settings {
    /// Names and values as the command line takes them.
    fn attributes(&self) -> impl Iterator<Item = (String, String)> {
        // Through text, where a float has its own few digits; plain data with string keys never fails to convert.
        let text = serde_json::to_string(self).unwrap_or_default();
        let fields: serde_json::Map<String, serde_json::Value> =
            serde_json::from_str(&text).unwrap_or_default();
        fields.into_iter().map(|(name, value)| (name, value.to_string().replace(['"', '[', ']'], "")))
    }
}

/// stand-in
pub fn render(
    scene: &LoadedScene,
    settings: &Settings,
    threads: Option<usize>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Frame, Error> {
    use pmcip_core::{batch::*, camera::Camera, scene::Scene, shade::path::*, sobol};
    use wide::*;
    let s = settings;
    let checked = Scene::new(scene.data()).map_err(|e| Error::Setting(e.to_string()))?;
    let camera = Camera::new(s.look_from, s.look_at, s.up, s.fov, s.width, s.height)
        .map_err(|e| Error::Setting(e.to_string()))?;
    let mut packets = vec![Packet::default(); PathTracer::required(512)];
    let mut tracer = PathTracer::new(checked, camera, s.max_depth, &mut packets);
    let start = std::time::Instant::now();
    let n = (s.width * s.height) as usize;
    let mut rgb = vec![[0.0; 3]; n];
    let mut variance = vec![0.0; n];
    for y in 0..s.height {
        for x in 0..s.width {
            let mut m = pmcip_core::film::Moments::default();
            for g in 0..s.spp.div_ceil(8) {
                let index = u32x8::splat(8 * g) + u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
                let key = u32x8::splat(sobol::pixel_key(s.seed, 0, x, y));
                let (u, v) = sobol::point(index, key, 0);
                let b = Batch8 {
                    lanes: 8,
                    x: u + f32x8::splat(x as f32),
                    y: v + f32x8::splat(y as f32),
                    index,
                    key,
                };
                let mut out = [Rgb8::default()];
                tracer.stream(&[b], &mut out);
                let (r, g, b) = (out[0].r.to_array(), out[0].g.to_array(), out[0].b.to_array());
                for i in 0..8 {
                    m.add([r[i], g[i], b[i]]);
                }
            }
            let i = (y * s.width + x) as usize;
            rgb[i] = m.mean;
            variance[i] = m.m2 / (m.count as f32 - 1.0) / m.count as f32;
            progress(s.spp as u64);
        }
    }
    Ok(Frame {
        rgb,
        variance,
        count: vec![s.spp as f32; n],
        alpha: vec![1.0 / n as f32; n],
        samples: (n as u64) * s.spp as u64,
        rejected: 0,
        lane_occupancy: None,
        threads: threads.unwrap_or(1),
        seconds: start.elapsed().as_secs_f64(),
    })
}
