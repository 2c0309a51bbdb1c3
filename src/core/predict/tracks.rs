//! Correspondences from two pictures alone, by homographies: one for the picture, one for each region in which the
//! kernel is dense (Lai et al. 2010, section 3.2).
//!
//! A homography is right for a plane or a turning camera, and near the truth for a small region: dense regions are
//! small, and matter most. Where neither a region's nor the picture's homography holds, nothing is carried.

use super::belief::Error;
use super::carry::pixel_at;
use crate::predict::features::{Feature, matches};
use crate::predict::homography::{self, Block, Homography, Pair};

/// Most regions that are tracked, the largest first.
pub const MAX_REGIONS: usize = 8;
/// The label of a pixel that is in no region.
pub const NO_REGION: u32 = u32::MAX;

/// Matches that a homography needs.
const MIN_INLIERS: u32 = 10;
/// Pixels by which the box around a region grows before it is searched for matches.
const MARGIN: f64 = 6.0;
/// Scale in pixels up to which features are exact to about a pixel.
const FINE: f32 = 4.0;
/// Matches of fine scale that make coarse ones superfluous.
const FINE_ENOUGH: usize = 60;
/// Bins of the histogram of densities: exponent and three bits of an `f32`.
const BINS: usize = 1 << 11;

/// Labels the dense regions of a plane: connected pixels, by their sides, above the `quantile` (0 to 1) of all values.
///
/// Regions of fewer than `least` pixels are left out, and of the rest the largest [`MAX_REGIONS`] are numbered from 0.
/// What is not a number or not positive is not dense. Returns how many regions there are.
///
/// # Errors
/// [`Error::Size`] if `labels` is not as long as `density` or that is not whole rows of `width`; [`Error::Scratch`] if
/// `scratch` is shorter.
pub fn regions(
    density: &[f32],
    width: usize,
    quantile: f32,
    least: u32,
    labels: &mut [u32],
    scratch: &mut [u32],
) -> Result<u32, Error> {
    let pixels = density.len();
    if width == 0 || labels.len() != pixels || !pixels.is_multiple_of(width) || pixels > 1 << 28 {
        return Err(Error::Size);
    }
    let sizes = scratch.get_mut(..pixels).ok_or(Error::Scratch)?;
    let limit = limit(density, quantile);
    connect(density, width, limit, labels);
    sizes.fill(0);
    for i in 0..pixels {
        if labels[i] != NO_REGION {
            labels[i] = root(labels, i as u32);
            sizes[labels[i] as usize] += 1;
        }
    }
    Ok(number(labels, sizes, least.max(1)))
}

/// Lowest value of the bin in which the quantile lies.
fn limit(density: &[f32], quantile: f32) -> u32 {
    let mut histogram = [0u32; BINS];
    density.iter().filter_map(bin).for_each(|bin| histogram[bin] += 1);
    let target = (quantile.clamp(0.0, 1.0) * density.len() as f32) as u32;
    let mut below = density.len() as u32 - histogram.iter().sum::<u32>();
    for (bin, count) in histogram.iter().enumerate() {
        below += count;
        if below > target {
            // The values of a bin are alike: a plane that is even has no dense regions.
            return bin as u32 + 1;
        }
    }
    BINS as u32
}

/// The bin of a positive number.
fn bin(value: &f32) -> Option<usize> {
    (*value > 0.0 && *value < f32::MAX).then(|| (value.to_bits() >> 20) as usize)
}

/// Joins neighbours from `limit` on: each label names another pixel of the same region, or the pixel itself.
fn connect(density: &[f32], width: usize, limit: u32, labels: &mut [u32]) {
    for i in 0..density.len() {
        labels[i] = NO_REGION;
        if bin(&density[i]).is_none_or(|bin| (bin as u32) < limit) {
            continue;
        }
        labels[i] = i as u32;
        let left = (!i.is_multiple_of(width)).then(|| i - 1);
        for neighbour in [left, i.checked_sub(width)].into_iter().flatten() {
            if labels[neighbour] != NO_REGION {
                let (a, b) = (root(labels, neighbour as u32), root(labels, i as u32));
                labels[a.max(b) as usize] = a.min(b);
            }
        }
    }
}

/// The first pixel of a region; the way there becomes shorter.
fn root(labels: &mut [u32], mut i: u32) -> u32 {
    while labels[i as usize] != i {
        let next = labels[i as usize];
        labels[i as usize] = labels[next as usize];
        i = next;
    }
    i
}

/// Replaces first pixels by the numbers of the largest regions.
fn number(labels: &mut [u32], sizes: &[u32], least: u32) -> u32 {
    let mut largest = [(0u32, NO_REGION); MAX_REGIONS];
    for (first, size) in sizes.iter().enumerate().filter(|(_, size)| **size >= least) {
        if *size > largest[MAX_REGIONS - 1].0 {
            largest[MAX_REGIONS - 1] = (*size, first as u32);
            largest.sort_unstable_by_key(|(size, first)| (core::cmp::Reverse(*size), *first));
        }
    }
    for label in labels.iter_mut().filter(|label| **label != NO_REGION) {
        let found = largest.iter().position(|(_, first)| first == label);
        *label = found.map_or(NO_REGION, |number| number as u32);
    }
    largest.iter().filter(|(size, _)| *size > 0).count() as u32
}

/// Fills `pairs` with the matches of the features `now` and `before`; returns how many there are.
///
/// Of matches between the same places one counts, and if there are enough of fine scale, only those: coarse ones are
/// off by one to three pixels.
pub fn pairs(now: &[Feature], before: &[Feature], ratio: f32, pairs: &mut [Pair]) -> usize {
    let fine = |f: &Feature| f.scale <= FINE;
    let mut count = 0;
    for coarse in [false, true] {
        if coarse && count >= FINE_ENOUGH {
            break;
        }
        let wanted =
            matches(now, before, ratio).filter(|m| (fine(&now[m.from]) && fine(&before[m.to])) != coarse);
        for m in wanted {
            let pair = m.pair(now, before);
            if count < pairs.len() && !pairs[..count].contains(&pair) {
                pairs[count] = pair;
                count += 1;
            }
        }
    }
    count
}

/// Where a picture was a frame ago.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tracks {
    /// Of the picture as a whole, from now to then.
    pub global: Option<Homography>,
    /// Of the regions, by their labels.
    pub regions: [Option<Homography>; MAX_REGIONS],
}

impl Tracks {
    /// Finds the homographies of `pairs`, each from now to the frame before, in which `labels` marks the dense regions.
    ///
    /// `picked` is scratch as long as `pairs`, `blocks` as [`homography::required`] says of them.
    ///
    /// # Errors
    /// [`Error::Scratch`] if scratch is too short. That nothing fits is no error: there is no homography then.
    pub fn find(
        pairs: &[Pair],
        labels: &[u32],
        width: usize,
        settings: &homography::Settings,
        picked: &mut [Pair],
        blocks: &mut [Block],
    ) -> Result<Tracks, Error> {
        if picked.len() < pairs.len() || blocks.len() < homography::required(pairs.len()) {
            return Err(Error::Scratch);
        }
        let mut tracks = Tracks { global: fit(pairs, settings, blocks), ..Tracks::default() };
        for (track, bounds) in tracks.regions.iter_mut().zip(boxes(labels, width.max(1))) {
            let mut count = 0;
            for pair in pairs.iter().filter(|pair| bounds.holds(pair.to)) {
                picked[count] = *pair;
                count += 1;
            }
            *track = fit(&picked[..count], settings, blocks);
        }
        Ok(tracks)
    }

    /// Writes where every pixel's centre was: by the homography of a region if that leads into the region, else by the
    /// picture's; not a number if there is none.
    ///
    /// # Errors
    /// [`Error::Size`] if `labels` or `out` have not `width · height` entries.
    pub fn positions(
        &self,
        labels: &[u32],
        width: usize,
        height: usize,
        out: &mut [[f32; 2]],
    ) -> Result<(), Error> {
        if [labels.len(), out.len()] != [width * height; 2] {
            return Err(Error::Size);
        }
        for (i, out) in out.iter_mut().enumerate() {
            let centre = [(i % width) as f64 + 0.5, (i / width) as f64 + 0.5];
            let by = |track: &Homography| track.apply(centre).map(|p| p.map(|x| x as f32));
            let inside = |number: usize, track: &Option<Homography>| {
                let position = by(track.as_ref()?)?;
                let label = labels[pixel_at(position, width, height)?];
                (label == number as u32).then_some(position)
            };
            let mut regions = self.regions.iter().enumerate();
            let position = regions.find_map(|(number, track)| inside(number, track));
            *out = position.or_else(|| by(self.global.as_ref()?)).unwrap_or([f32::NAN; 2]);
        }
        Ok(())
    }
}

/// The homography of enough pairs, which has them in front of the horizon.
fn fit(pairs: &[Pair], settings: &homography::Settings, blocks: &mut [Block]) -> Option<Homography> {
    let fit = homography::estimate(pairs, settings, blocks).ok()?;
    let count = pairs.len() as f64;
    let centroid = [0, 1].map(|axis| pairs.iter().map(|pair| pair.from[axis]).sum::<f64>() / count);
    (fit.inliers >= MIN_INLIERS && fit.homography.apply(centroid).is_some()).then_some(fit.homography)
}

/// A box around a region.
#[derive(Clone, Copy)]
struct Bounds {
    low: [f64; 2],
    high: [f64; 2],
}

impl Bounds {
    const EMPTY: Bounds = Bounds { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };

    fn holds(&self, point: [f64; 2]) -> bool {
        (0..2).all(|axis| point[axis] >= self.low[axis] - MARGIN && point[axis] <= self.high[axis] + MARGIN)
    }
}

/// The boxes around all regions.
fn boxes(labels: &[u32], width: usize) -> [Bounds; MAX_REGIONS] {
    let mut boxes = [Bounds::EMPTY; MAX_REGIONS];
    for (i, label) in labels.iter().enumerate() {
        if let Some(bounds) = boxes.get_mut(*label as usize) {
            let pixel = [(i % width) as f64, (i / width) as f64];
            bounds.low = [0, 1].map(|axis| bounds.low[axis].min(pixel[axis]));
            bounds.high = [0, 1].map(|axis| bounds.high[axis].max(pixel[axis] + 1.0));
        }
    }
    boxes
}
