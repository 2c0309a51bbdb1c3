//! Filtered pictures in time: what earlier frames have shown, carried along and blended in.
//!
//! What is kept of a pixel is its light, radiance over albedo, so that textures are not blurred by being carried. [`carry`]
//! fetches it from where it was a frame ago, between pixels. [`Blend`] weighs it against this frame's pixel as a Kalman filter
//! weighs a prediction and a measurement: by their variances. To that of the past is added what the two differ by, over 7 × 7
//! pixels, beyond what variances explain: of light that fades and of shadows and reflections that move this frame alone
//! tells, what stands still becomes a mean of up to about 20 frames.
//! (The usual way of renderers in real time clamps the past to the colours around a pixel, or to a blend of fixed weight:
//! Schied et al., *Spatiotemporal variance-guided filtering*, HPG 2017, section 4.1.)
//!
//! Tried and lost: to give the past this frame's energy before they are compared (a lamp that shines as before gets what
//! another one loses); sums of differences over sums of variances (a noisy edge hides what has changed beside it).
//!
//! The blend is a guide as any other: the picture gets the energy of this frame's fair samples by
//! [`Sampler::resolve_guided`](crate::sampler::Sampler::resolve_guided) in the end.

use super::Feature;
use crate::maths::colour::luminance;
use crate::sampler::Error;
use crate::sampler::batch::MAX_RADIANCE;

/// Least weight of a frame in what is kept.
const LEAST: f32 = 0.1;
/// What variances of filtered pictures are multiplied by: the filter's weights depend on the noise they average.
const HONESTY: f32 = 2.0;
/// What differences beyond variances are multiplied by: what has changed here changes more somewhere near.
const CAUTION: f32 = 4.0;
/// Squared difference in a pixel, in units of what variances make of it, beyond which it says by itself that it has changed.
const OUTLIER: f32 = 4.0;
/// What one pixel's difference counts at most among others, in units of what variances make of it.
const MOST: f32 = 10.0;
/// How far around a pixel past and present are compared.
const WINDOW: usize = 3;
/// Squared difference of normals from which on two pixels show different surfaces.
const NORMAL: f32 = 0.1;
/// Squared difference of albedos at which the past counts half.
const ALBEDO: f32 = 0.01;
/// Difference of depths of neighbouring pixels that are of one surface, over the depth.
const DEPTH: f32 = 0.1;

/// What is kept of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Past {
    /// Light: radiance over albedo.
    pub light: [f32; 3],
    /// Variance of light's luminance; not finite where nothing is known.
    pub variance: f32,
    /// What the pixel has shown.
    pub feature: Feature,
}

impl Past {
    /// Of a pixel that nothing is known of.
    pub const NONE: Past = Past {
        light: [0.0; 3],
        variance: f32::INFINITY,
        feature: Feature { albedo: [0.0; 3], normal: [0.0; 3], depth: 0.0 },
    };

    /// Whether anything is known that can be used.
    fn known(&self) -> bool {
        self.variance.is_finite()
            && self.variance >= 0.0
            && self.light.iter().all(|v| v.abs() <= MAX_RADIANCE)
    }
}

/// Fetches for every pixel, which shows what `now` says, what was kept `before` at its position then.
///
/// `positions` are in pixels from the upper left corner, not numbers where a pixel was hidden. Of the four pixels around a
/// position those count that show the same surface. Rows of `width` pixels from the top. `labels` say which pixels belong
/// together, in both frames; none if all do.
///
/// # Errors
/// [`Error::Guide`] if slices differ in length or are not whole rows, [`Error::Output`] if `out` is of another length.
pub fn carry(
    before: &[Past],
    width: usize,
    positions: &[[f32; 2]],
    now: &[Feature],
    labels: &[u16],
    out: &mut [Past],
) -> Result<(), Error> {
    let pixels = before.len();
    if width == 0 || !pixels.is_multiple_of(width) || [positions.len(), now.len()] != [pixels; 2] {
        return Err(Error::Guide);
    }
    if out.len() != pixels {
        return Err(Error::Output);
    }
    if !labels.is_empty() && labels.len() != pixels {
        return Err(Error::Labels);
    }
    for (i, ((out, position), now)) in out.iter_mut().zip(positions).zip(now).enumerate() {
        let together = |tap: usize| labels.get(tap) == labels.get(i);
        *out = fetch(before, width, *position, &now.limited(), together);
    }
    Ok(())
}

/// What was kept at a position, by the pixels around it that belong `together` with what is asked for.
fn fetch(
    before: &[Past],
    width: usize,
    [x, y]: [f32; 2],
    now: &Feature,
    together: impl Fn(usize) -> bool,
) -> Past {
    let height = before.len() / width;
    if !(x >= 0.0 && y >= 0.0 && x < width as f32 && y < height as f32) {
        return Past::NONE;
    }
    let at = |x: usize, y: usize| y.min(height - 1) * width + x.min(width - 1);
    let nearest = before[at(x as usize, y as usize)].feature.depth;
    let (x, y) = ((x - 0.5).max(0.0), (y - 0.5).max(0.0));
    let (left, top) = (x as usize, y as usize);
    let (u, v) = (x - left as f32, y - top as f32);
    let taps = [(0, 0, (1.0 - u) * (1.0 - v)), (1, 0, u * (1.0 - v)), (0, 1, (1.0 - u) * v), (1, 1, u * v)];
    let (mut sum, mut weight) = (Past::default(), 0.0);
    for (dx, dy, part) in taps {
        let i = at(left + dx, top + dy);
        let tap = &before[i];
        let near = together(i) && (tap.feature.depth - nearest).abs() <= DEPTH * nearest.abs();
        if part > 0.0 && tap.known() && near && square(tap.feature.normal, now.normal) < NORMAL {
            weight += part;
            sum.variance += part * tap.variance;
            (0..3).for_each(|c| sum.light[c] += part * tap.light[c]);
            (0..3).for_each(|c| sum.feature.albedo[c] += part * tap.feature.albedo[c]);
        }
    }
    if weight < 0.25 {
        return Past::NONE;
    }
    let albedo = sum.feature.albedo.map(|v| v / weight);
    let doubt = 1.0 + square(albedo, now.albedo) / ALBEDO;
    Past { light: sum.light.map(|v| v / weight), variance: doubt * sum.variance / weight, feature: *now }
}

/// Squared distance.
fn square(a: [f32; 3], b: [f32; 3]) -> f32 {
    let d = [0, 1, 2].map(|c| a[c] - b[c]);
    d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
}

/// This frame's filtered picture and what is known of its pixels from before, rows from the top, one entry a pixel.
#[derive(Clone, Copy, Debug)]
pub struct Blend<'a> {
    /// Columns.
    pub width: usize,
    /// Filtered radiance, finite.
    pub filtered: &'a [[f32; 3]],
    /// Variance of the luminance of filtered light, as [`Filter::variance`](super::Filter::variance) writes it.
    pub variance: &'a [f32],
    /// What the pixels show.
    pub features: &'a [Feature],
    /// What [`carry`] has fetched.
    pub carried: &'a [Past],
    /// Which pixels belong together; none if all do.
    pub labels: &'a [u16],
}

impl Blend<'_> {
    /// Writes the blended radiance, and what to keep of it for the next frame. `work`, too, has one entry a pixel.
    ///
    /// # Errors
    /// If a slice has the wrong length.
    pub fn run(&self, work: &mut [[f32; 2]], kept: &mut [Past], out: &mut [[f32; 3]]) -> Result<(), Error> {
        let pixels = self.filtered.len();
        let lent = [self.variance.len(), self.features.len(), self.carried.len()];
        if self.width == 0 || !pixels.is_multiple_of(self.width) || lent != [pixels; 3] {
            return Err(Error::Guide);
        }
        if [work.len(), kept.len(), out.len()] != [pixels; 3] {
            return Err(Error::Output);
        }
        if !self.labels.is_empty() && self.labels.len() != pixels {
            return Err(Error::Labels);
        }
        for (i, (kept, work)) in kept.iter_mut().zip(&mut *work).enumerate() {
            *kept = self.present(i);
            *work = compared(kept, &self.carried[i]);
        }
        for (i, (kept, out)) in kept.iter_mut().zip(out).enumerate() {
            *out = self.filtered[i];
            if self.carried[i].known() {
                let albedo = kept.feature.divisor();
                *kept = merged(kept, &self.carried[i], self.around(work, i));
                *out = [0, 1, 2].map(|c| kept.light[c] * albedo[c]);
            }
        }
        Ok(())
    }

    /// Sums over the window around pixel `i`, as far as it is in the picture and belongs to the same label.
    fn around(&self, of: &[[f32; 2]], i: usize) -> [f32; 2] {
        let (x, y) = (i % self.width, i / self.width);
        let rows = y.saturating_sub(WINDOW)..(y + WINDOW + 1).min(of.len() / self.width);
        let columns = x.saturating_sub(WINDOW)..self.width.min(x + WINDOW + 1);
        let all = rows.flat_map(|y| columns.clone().map(move |x| y * self.width + x));
        let all = all.filter(|near| self.labels.get(*near) == self.labels.get(i));
        all.map(|near| of[near]).fold([0.0; 2], |sum, v| [sum[0] + v[0], sum[1] + v[1]])
    }

    /// What this frame says of a pixel.
    fn present(&self, i: usize) -> Past {
        let feature = self.features[i].limited();
        let albedo = feature.divisor();
        let light = [0, 1, 2].map(|c| self.filtered[i][c] / albedo[c]);
        Past { light, variance: HONESTY * self.variance[i], feature }
    }
}

/// Squared difference of present and past over what variances make of it, and 1; zeros if there is no past.
fn compared(now: &Past, past: &Past) -> [f32; 2] {
    if !past.known() {
        return [0.0; 2];
    }
    let gap = gap(now, past);
    [(gap * gap / (past.variance + now.variance).max(f32::MIN_POSITIVE)).min(MOST), 1.0]
}

/// Present and past, weighed; `gaps` and `pixels` are sums of what was [`compared`].
fn merged(now: &Past, past: &Past, [gaps, pixels]: [f32; 2]) -> Past {
    let noise = past.variance + now.variance;
    let gap = gap(now, past);
    let around = CAUTION * (gaps / pixels - 1.0).max(0.0) * noise;
    let old = past.variance + around.max(gap * gap - OUTLIER * noise);
    let sum = old + now.variance;
    let part = if sum > 0.0 { (old / sum).max(LEAST) } else { 1.0 };
    Past {
        light: [0, 1, 2].map(|c| past.light[c] + part * (now.light[c] - past.light[c])),
        variance: part * part * now.variance + (1.0 - part) * (1.0 - part) * past.variance,
        ..*now
    }
}

/// Difference of luminances.
fn gap(now: &Past, past: &Past) -> f32 {
    luminance([0, 1, 2].map(|c| past.light[c] - now.light[c]))
}
