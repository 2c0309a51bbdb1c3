//! What a frame shows without light, for the filter and for the layers of its file.

use super::memory::zeros;
use super::threads::each;
use crate::error::Error;
use pmcip_core::sampler::guide::Feature;
use pmcip_core::tracer::camera::Camera;
use pmcip_core::tracer::scene::Scene;
use pmcip_core::tracer::shade::features::Features;
use rayon::ThreadPool;

/// Rows that a thread sees at once.
const ROWS: usize = 8;

/// What a frame looks at.
#[derive(Clone, Copy)]
pub struct Sight<'a> {
    /// The scene.
    pub scene: Scene<'a>,
    /// The frame's camera.
    pub camera: Camera,
    /// Longest chain of mirrors and glass.
    pub max_depth: u32,
    /// Columns and rows of pixels.
    pub size: (u32, u32),
}

/// What all pixels show, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seen {
    /// One a pixel: 28 bytes.
    pub features: Vec<Feature>,
    /// The part of each pixel where a surface is seen, 0 to 1; empty unless asked for.
    pub coverage: Vec<f32>,
}

impl Sight<'_> {
    /// Looks, on all threads of `pool`, on the caller's if there is none.
    ///
    /// # Errors
    /// [`Error::Work`] if memory is lacking.
    pub fn look(self, with_coverage: bool, pool: Option<&ThreadPool>) -> Result<Seen, Error> {
        let (width, height) = (self.size.0 as usize, self.size.1 as usize);
        let covered = if with_coverage { width * height } else { 0 };
        let mut seen = Seen { features: zeros(width * height)?, coverage: zeros(covered)? };
        let mut coverage = seen.coverage.chunks_mut(ROWS * width);
        let parts = seen.features.chunks_mut(ROWS * width).enumerate();
        let parts = parts.map(|(part, rows)| (part, rows, coverage.next().unwrap_or_default())).collect();
        each(pool, parts, |(part, rows, coverage)| {
            let mut eye = Features::new(self.scene, self.camera, self.max_depth);
            let mut coverage = coverage.chunks_mut(width);
            for (dy, row) in rows.chunks_mut(width).enumerate() {
                eye.row((part * ROWS + dy) as u32, row, coverage.next().unwrap_or_default());
            }
        });
        Ok(seen)
    }
}
