//! The pictures of a comparison as colours: what was rendered, how far it is off, and where samples went.
//!
//! Every kind of picture has one scale for all methods. Errors are those of luminance.

use super::colour::{Scale, quantile};
use super::data::{Comparison, Shown};
use super::raster::{Block, Raster};
use crate::picture::frame_io::{Picture, encode_srgb};
use crate::picture::metrics::{acuity, luminance};
use std::ops::Range;

/// Blocks that are enlarged at most.
const ZOOMS: usize = 3;

/// One picture of each method in colours that mean the same for all.
pub struct Kind {
    /// What it shows.
    pub title: &'static str,
    /// What its numbers are.
    pub unit: &'static str,
    /// What the colours mean; the rendered image has none.
    pub scale: Option<Scale>,
    /// In the order of the methods; then those of other programs, of the image and the difference.
    pub rasters: Vec<Raster>,
}

/// All pictures.
pub struct Gallery {
    /// Brightness of the images in stops.
    pub exposure: f64,
    /// The reference in the brightness of the images.
    pub reference: Raster,
    /// Image, difference, relative variance, samples, kernel.
    pub kinds: Vec<Kind>,
    /// Where methods differ most.
    pub zooms: Vec<Block>,
}

impl Gallery {
    /// Colours everything.
    pub fn new(comparison: &Comparison, reference: &Picture, cd_per_unit: f64) -> Gallery {
        let shown = &comparison.shown;
        let size = (reference.width as usize, reference.height as usize);
        let truth: Vec<f64> = reference.rgb.iter().map(|rgb| luminance(*rgb)).collect();
        let exposure = exposure(&truth);
        let image = |rgb: &[[f32; 3]]| develop(rgb, size, exposure);
        let images =
            Kind { title: "Image", unit: "", scale: None, rasters: pixels(comparison).map(image).collect() };
        let mapped = [
            ("Difference to the reference", "luminance, scene units", difference(comparison, &truth)),
            ("Relative variance", "of the pixel’s mean, over L² + 0.01", relative_variance(shown, &truth)),
            ("Samples", "a pixel", samples(shown)),
            ("Kernel α", "times the number of pixels; uniform is 1", kernel(shown)),
        ];
        let mapped = mapped.into_iter().enumerate().map(|(i, (title, unit, planes))| {
            let values = planes.iter().flatten().copied();
            let scale = if i == 0 { Scale::symmetric(values) } else { Scale::logarithmic(values) };
            let rasters = planes.iter().map(|plane| paint(plane, size, &scale)).collect();
            Kind { title, unit, scale: Some(scale), rasters }
        });
        Gallery {
            exposure,
            reference: image(&reference.rgb),
            kinds: std::iter::once(images).chain(mapped).collect(),
            zooms: zooms(&visible_errors(comparison, &truth, cd_per_unit), size),
        }
    }
}

/// Stops that make the brightest luminances, but for one per cent, as bright as the screen can show.
fn exposure(truth: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = truth.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let white = quantile(&sorted, 0.99);
    if white > 0.0 { -white.log2() } else { 0.0 }
}

fn develop(rgb: &[[f32; 3]], (width, height): (usize, usize), exposure: f64) -> Raster {
    let factor = exposure.exp2() as f32;
    let pixels = rgb.iter().map(|rgb| rgb.map(|value| encode_srgb(value * factor))).collect();
    Raster { width, height, pixels }
}

fn paint(plane: &[f64], (width, height): (usize, usize), scale: &Scale) -> Raster {
    Raster { width, height, pixels: plane.iter().map(|value| scale.colour(*value)).collect() }
}

/// A plane of each method, from its frame and the reference's luminance.
fn planes(shown: &[Shown], of: impl Fn(&Shown) -> Vec<f64>) -> Vec<Vec<f64>> {
    shown.iter().map(of).collect()
}

/// The pixels of all pictures: of the methods, then of other programs.
fn pixels(comparison: &Comparison) -> impl Iterator<Item = &[[f32; 3]]> {
    let own = comparison.shown.iter().map(|shown| shown.frame.rgb.as_slice());
    own.chain(comparison.other_pictures.iter().map(Vec::as_slice))
}

fn difference(comparison: &Comparison, truth: &[f64]) -> Vec<Vec<f64>> {
    let off = |rgb: &[[f32; 3]]| rgb.iter().zip(truth).map(|(rgb, truth)| luminance(*rgb) - truth).collect();
    pixels(comparison).map(off).collect()
}

fn relative_variance(shown: &[Shown], truth: &[f64]) -> Vec<Vec<f64>> {
    let relative = |(variance, truth): (&f32, &f64)| f64::from(*variance) / (truth * truth + 0.01);
    planes(shown, |s| s.frame.variance.iter().zip(truth).map(relative).collect())
}

fn samples(shown: &[Shown]) -> Vec<Vec<f64>> {
    planes(shown, |s| s.frame.count.iter().map(|count| f64::from(*count)).collect())
}

fn kernel(shown: &[Shown]) -> Vec<Vec<f64>> {
    planes(shown, |s| {
        let pixels = s.frame.alpha.len() as f64;
        s.frame.alpha.iter().map(|alpha| f64::from(*alpha) * pixels).collect()
    })
}

/// e²/tvi, what each pixel adds to Err.
fn visible_errors(comparison: &Comparison, truth: &[f64], cd_per_unit: f64) -> Vec<Vec<f64>> {
    let weights: Vec<f64> = truth.iter().map(|truth| acuity(*truth, cd_per_unit)).collect();
    let mut planes = difference(comparison, truth);
    for plane in &mut planes {
        plane.iter_mut().zip(&weights).for_each(|(e, weight)| *e = (*e * cd_per_unit).powi(2) * weight);
    }
    planes
}

/// The blocks in which the worst method's mean error is farthest above the best one's.
fn zooms(errors: &[Vec<f64>], (width, height): (usize, usize)) -> Vec<Block> {
    let side = (width.min(height) / 8).clamp(16, 64).min(width).min(height);
    let starts = |length: usize| (0..=length - side).step_by(side);
    let blocks = starts(height).flat_map(|y| starts(width).map(move |x| Block { x, y, side }));
    let mut ranked: Vec<(f64, Block)> = blocks.map(|block| (spread(errors, width, &block), block)).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    ranked.into_iter().filter(|(spread, _)| *spread > 0.0).take(ZOOMS).map(|(_, block)| block).collect()
}

fn spread(errors: &[Vec<f64>], width: usize, block: &Block) -> f64 {
    let columns: Range<usize> = block.x..block.x + block.side;
    let sum = |plane: &Vec<f64>| -> f64 {
        (block.y..block.y + block.side).map(|y| plane[y * width..][columns.clone()].iter().sum::<f64>()).sum()
    };
    let sums = errors.iter().map(sum);
    let (low, high) =
        sums.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), sum| (low.min(sum), high.max(sum)));
    high - low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_block_where_methods_differ_most_comes_first() {
        let mut errors = vec![vec![1.0; 64 * 32]; 2];
        errors[1][20 * 64 + 50] = 9.0;
        errors[0][5 * 64 + 2] = 3.0;
        let zooms = zooms(&errors, (64, 32));
        assert_eq!(zooms, [Block { x: 48, y: 16, side: 16 }, Block { x: 0, y: 0, side: 16 }]);
    }

    #[test]
    fn pictures_smaller_than_a_block_are_one() {
        assert_eq!(zooms(&[vec![0.0; 6], vec![1.0; 6]], (3, 2)).len(), 1);
        assert_eq!(zooms(&[vec![0.0], vec![1.0]], (1, 1)), [Block { x: 0, y: 0, side: 1 }]);
    }

    #[test]
    fn a_crop_is_the_block() {
        let raster = Raster { width: 3, height: 2, pixels: (0..6).map(|i| [i; 3]).collect() };
        assert_eq!(raster.crop(&Block { x: 1, y: 0, side: 2 }).pixels, [[1; 3], [2; 3], [4; 3], [5; 3]]);
    }
}
