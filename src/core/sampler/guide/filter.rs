//! A filter that makes a guide of a film: non-local means in two passes.
//!
//! The first pass compares noisy pixels by patches of 11 × 11. The second compares what the first has made, over patches of
//! 5 × 5 and by the variance that is left, and averages the film's own pixels once more: the first pass's decisions,
//! made with less noise (as the second stage of Dabov et al., *Image denoising by sparse 3-D transform-domain
//! collaborative filtering*, IEEE TIP 2007). With features it works on light, radiance over albedo, so that textures stay
//! as they are; without, on radiance.
//!
//! Variances are those of samples as they are, stratified, by the fair samples against all.
//!
//! At last no pixel is made brighter than its samples admit. The eye is most sensitive in the dark, and light that leaks
//! from lit surroundings into a pixel that has seen none shows: see [`Filter::write`].
//!
//! ```
//! # use pmcip_core::sampler::{Error, Sampler, guide::{Feature, Filter}};
//! # fn guided(sampler: &Sampler<'_>, features: &[Feature], floats: &mut [f32]) -> Result<Vec<[f32; 3]>, Error> {
//! let mut filter = Filter::new(sampler, features, floats)?;
//! for _ in 0..Filter::PASSES {
//!     filter.bands().for_each(|mut band| band.filter()); // by any threads, in any order
//!     filter.next();
//! }
//! let pixels = sampler.settings().width as usize * sampler.settings().height as usize;
//! let mut guide = vec![[0.0; 3]; pixels];
//! filter.write(&mut guide)?;
//! # Ok(guide)
//! # }
//! ```

use super::among;
use super::average::{self, BLOCK_ROWS, Rule, Sources, averages, known};
use super::feature::Feature;
use super::neighbours::{finish, slopes};
use super::noise;
use super::rows::{Grid, MARGIN, Rows};
use crate::maths::colour::luminance;
use crate::maths::eight::{read8, write8};
use crate::sampler::{Error, Sampler};

/// See [`Filter::PASSES`].
const PASSES: usize = 2;
/// Largest number that enters a filter, so that no square overflows.
const LARGEST: f32 = 1e16;

/// How pixels are compared in each pass: what had least Err on a box, a glass sphere and a rough mesh at 4 to 64 samples.
const RULES: [Rule; PASSES] = [
    Rule { radius: 10, patch: 5, scale: 1.0, strength: 0.75, features: [0.018, 0.0072, 0.36] },
    Rule { radius: 14, patch: 2, scale: 3.0, strength: 0.6, features: [0.0027, 0.00108, 0.054] },
];

/// By how many standard deviations of its mean a pixel may be made brighter.
const BRIGHTER: f32 = 10.0;
/// As many pixels of 3 × 3 have to admit a brightness: where less do, it is a border.
const WITNESSES: usize = 6;

/// What is seen by a part of 3/n of a pixel's samples is missed by all n of them once in twenty times.
const MISSED: f32 = 3.0;

/// A guide in the making.
#[derive(Debug)]
pub struct Filter<'a> {
    grid: Grid,
    pass: usize,
    known: &'a mut [f32],
    averages: [&'a mut [f32]; PASSES],
    /// Which pixels belong together, if not all do.
    labels: Option<Rows<'a>>,
}

impl<'a> Filter<'a> {
    /// Passes a picture needs.
    pub const PASSES: usize = PASSES;

    /// Floats of scratch a filter needs: 25 a pixel and a margin.
    pub fn required(width: u32, height: u32) -> usize {
        let grid = Grid { width: width as usize, height: height as usize };
        grid.floats(known::PLANES).saturating_add(grid.floats(averages::PLANES).saturating_mul(Self::PASSES))
    }

    /// The same for a film with labels: 26 a pixel.
    pub fn required_with_labels(width: u32, height: u32) -> usize {
        let grid = Grid { width: width as usize, height: height as usize };
        Self::required(width, height).saturating_add(grid.floats(1))
    }

    /// What a filter of this film needs, with labels or without.
    pub fn required_by(sampler: &Sampler<'_>) -> usize {
        let settings = sampler.settings();
        match sampler.planes.label {
            [] => Self::required(settings.width, settings.height),
            _ => Self::required_with_labels(settings.width, settings.height),
        }
    }

    /// Takes what the film has seen. `features` are as many as pixels, rows from the top, or none.
    ///
    /// # Errors
    /// If an iteration is running, `scratch` is too short, or `features` are of another number.
    pub fn new(sampler: &Sampler<'_>, features: &[Feature], scratch: &'a mut [f32]) -> Result<Self, Error> {
        sampler.at_rest()?;
        let settings = sampler.settings();
        if !features.is_empty() && features.len() != sampler.layout.pixels() {
            return Err(Error::Guide);
        }
        let scratch = scratch.get_mut(..Self::required_by(sampler)).ok_or(Error::Scratch)?;
        let grid = Grid { width: settings.width as usize, height: settings.height as usize };
        let (known, rest) = scratch.split_at_mut(grid.floats(known::PLANES));
        let (first, rest) = rest.split_at_mut(grid.floats(averages::PLANES));
        let (second, rest) = rest.split_at_mut(grid.floats(averages::PLANES));
        let labels = (!rest.is_empty()).then(|| {
            among::fill(grid, &sampler.layout, &sampler.planes, rest);
            Rows { data: rest, planes: 1, grid }
        });
        let mut filter = Filter { grid, pass: 0, known, averages: [first, second], labels };
        filter.take(sampler, features);
        Ok(filter)
    }

    /// The picture in parts that can be filtered by any thread in any order; none after the last pass.
    pub fn bands(&mut self) -> impl Iterator<Item = Band<'_>> {
        let [first, second] = &mut self.averages;
        let known = Rows { data: self.known, planes: known::PLANES, grid: self.grid };
        let (out, guide) = match self.pass {
            0 => (&mut **first, known),
            1 => (&mut **second, Rows { data: first, planes: averages::PLANES, grid: self.grid }),
            _ => (&mut [][..], known),
        };
        let row = averages::PLANES * self.grid.stride();
        let inside = match out.is_empty() {
            true => out,
            false => &mut out[MARGIN * row..(MARGIN + self.grid.height) * row],
        };
        let (pass, sources) = (self.pass, Sources { known, guide, labels: self.labels });
        let chunks = inside.chunks_mut(BLOCK_ROWS * row).enumerate();
        chunks.map(move |(i, out)| Band { sources, rule: &RULES[pass], first: i * BLOCK_ROWS, out })
    }

    /// Ends a pass, when all its bands have been filtered.
    pub fn next(&mut self) {
        if let Some(averages) = self.averages.get_mut(self.pass) {
            let means = (averages::OWN_VARIANCE, averages::VARIANCE);
            finish(self.grid, averages::PLANES, means, self.labels, averages);
            self.pass += 1;
        }
    }

    /// Writes the guide, rows from the top.
    ///
    /// A pixel whose samples' luminance has mean L and whose mean has variance v gets at most L + 10√v, or as much as six of
    /// the 3 × 3 pixels around it may get by that, or the part 3/n of what it was filtered to, n the number of its samples:
    /// so much its samples may have missed.
    ///
    /// # Errors
    /// If `out` has not one entry a pixel.
    pub fn write(&self, out: &mut [[f32; 3]]) -> Result<(), Error> {
        if out.len() != self.grid.width * self.grid.height {
            return Err(Error::Output);
        }
        self.write_rows(0, out)
    }

    /// [`write`](Self::write) of the rows from the `first` on, as many as `out` has: threads can share a picture.
    ///
    /// # Errors
    /// If `out` has other than whole rows, or more than there are.
    pub fn write_rows(&self, first: usize, out: &mut [[f32; 3]]) -> Result<(), Error> {
        let (rows, rest) = (out.len() / self.grid.width, out.len() % self.grid.width);
        if rest != 0 || first > self.grid.height || rows > self.grid.height - first {
            return Err(Error::Output);
        }
        let known = Rows { data: self.known, planes: known::PLANES, grid: self.grid };
        let averages = Rows { data: self.averages[1], planes: averages::PLANES, grid: self.grid };
        for (y, out) in (first..).zip(out.chunks_exact_mut(self.grid.width)) {
            for (x, out) in out.iter_mut().enumerate() {
                let value = |rows: &Rows<'_>, plane: usize| rows.row(plane, y + MARGIN)[x + MARGIN];
                let albedo = [0, 1, 2].map(|c| value(&known, known::ALBEDO + c));
                let albedo = Feature { albedo, ..Feature::default() }.divisor();
                let radiance = [0, 1, 2].map(|c| value(&averages, c) * albedo[c]);
                let most = admitted(&known, self.labels, albedo, (x, y));
                *out = darkened(radiance, most, value(&known, known::UNSEEN));
            }
        }
        Ok(())
    }

    /// Writes the variance of the luminance of what was filtered, radiance over albedo, as if weights did not depend on the
    /// noise that they average: rows from the top.
    ///
    /// # Errors
    /// If `out` has not one entry a pixel.
    pub fn variance(&self, out: &mut [f32]) -> Result<(), Error> {
        if out.len() != self.grid.width * self.grid.height {
            return Err(Error::Output);
        }
        let averages = Rows { data: self.averages[PASSES - 1], planes: averages::PLANES, grid: self.grid };
        for (y, out) in out.chunks_exact_mut(self.grid.width).enumerate() {
            let row = &averages.row(averages::OWN_VARIANCE, y + MARGIN)[MARGIN..];
            out.copy_from_slice(&row[..self.grid.width]);
        }
        Ok(())
    }

    /// Fills the planes of what is known.
    fn take(&mut self, sampler: &Sampler<'_>, features: &[Feature]) {
        let (grid, planes) = (self.grid, &sampler.planes);
        let stride = grid.stride();
        let open = Feature { albedo: [1.0; 3], ..Feature::default() };
        let rows = self.known.chunks_exact_mut(known::PLANES * stride);
        let ratios = self.averages[0].chunks_exact_mut(averages::PLANES * stride);
        for (y, (row, ratios)) in rows.zip(ratios).skip(MARGIN).take(grid.height).enumerate() {
            for x in 0..grid.width {
                let i = sampler.layout.index(x as u32, y as u32);
                let [mean, fair] = [&planes.mean, &planes.fair].map(|of| of.each_ref().map(|plane| plane[i]));
                let (variance, count) = (planes.variance_of_mean(i), planes.count[i]);
                let feature = features.get(y * grid.width + x).unwrap_or(&open).limited();
                let values = pixel(mean, variance, count, &feature);
                for (plane, value) in values.into_iter().enumerate() {
                    row[plane * stride + MARGIN + x] = value;
                }
                let ratio = noise::ratio(mean, fair, variance, sampler.state.fair.count(), count);
                for (plane, value) in ratio.into_iter().enumerate() {
                    ratios[plane * stride + MARGIN + x] = value;
                }
            }
        }
        self.measure_noise();
        finish(grid, known::PLANES, (known::OWN_VARIANCE, known::VARIANCE), self.labels, self.known);
        slopes(grid, self.labels, self.known);
        grid.reflect(known::PLANES, self.known);
    }

    /// Makes variances those of stratified samples. The ratios are where the first averages will be.
    fn measure_noise(&mut self) {
        let (grid, stride) = (self.grid, self.grid.stride());
        noise::gather(grid, averages::PLANES, self.averages[0]);
        let gathered = Rows { data: self.averages[0], planes: averages::PLANES, grid };
        for y in MARGIN..MARGIN + grid.height {
            let own = (y * known::PLANES + known::OWN_VARIANCE) * stride;
            for x in (MARGIN..MARGIN + grid.width).step_by(8) {
                let variance = &mut self.known[own + x..own + stride];
                let factors = noise::factors(&gathered, self.labels, x, y);
                write8(variance, read8(variance) * factors);
            }
        }
    }
}

/// Some rows of a pass. Can be sent to another thread.
#[derive(Debug)]
pub struct Band<'a> {
    sources: Sources<'a>,
    rule: &'static Rule,
    first: usize,
    out: &'a mut [f32],
}

impl Band<'_> {
    /// Filters the rows.
    pub fn filter(&mut self) {
        average::average(&self.sources, self.rule, self.first, self.out);
    }
}

/// What is known of a pixel, plane by plane.
fn pixel(mean: [f32; 3], variance: f32, count: u32, feature: &Feature) -> [f32; known::PLANES] {
    let albedo = feature.divisor();
    let light = [0, 1, 2].map(|c| (mean[c] / albedo[c]).clamp(-LARGEST, LARGEST));
    let shade = luminance(albedo);
    let mut values = [0.0; known::PLANES];
    values[known::LIGHT..][..3].copy_from_slice(&light);
    values[known::UNSEEN] = (MISSED / count.max(1) as f32).min(1.0);
    values[known::OWN_VARIANCE] = (variance / (shade * shade)).min(LARGEST * LARGEST);
    values[known::NORMAL..][..3].copy_from_slice(&feature.normal);
    values[known::ALBEDO..][..3].copy_from_slice(&feature.albedo);
    values[known::DEPTH] = feature.depth;
    values
}

/// The luminance that the samples of a pixel admit, or those of enough of the 3 × 3 pixels around it, all seen with `albedo`.
fn admitted(known: &Rows<'_>, labels: Option<Rows<'_>>, albedo: [f32; 3], (x, y): (usize, usize)) -> f32 {
    let shade = luminance(albedo);
    let most = |x: usize, y: usize| {
        let value = |plane: usize| known.row(plane, y)[x];
        let light = luminance([0, 1, 2].map(|c| value(known::LIGHT + c) * albedo[c]));
        light + BRIGHTER * shade * libm::sqrtf(value(known::OWN_VARIANCE))
    };
    let (x, y) = (x + MARGIN, y + MARGIN);
    let own = most(x, y);
    let mut around: [f32; 9] = core::array::from_fn(|i| {
        let near = (x + i % 3 - 1, y + i / 3 - 1);
        if among::together(labels, (x, y), near) { most(near.0, near.1) } else { own }
    });
    around.sort_unstable_by(f32::total_cmp);
    own.max(around[around.len() - WITNESSES]).max(0.0)
}

/// The colour, or that of luminance `most` if it is brighter, but at least a `part` of it.
fn darkened(colour: [f32; 3], most: f32, part: f32) -> [f32; 3] {
    let light = luminance(colour);
    let factor = if light > most { (most / light).max(part) } else { 1.0 };
    colour.map(|v| v * factor)
}
