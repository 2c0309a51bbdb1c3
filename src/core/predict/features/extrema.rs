//! Extrema of differences of Gaussians in place and scale.

use super::blur::load;
use super::octave::{Octave, STEPS};
use super::picture::Settings;
use crate::maths::matrix::{adjugate, determinant};
use wide::f32x8;

/// Pixels at the edge of an octave where nothing is looked for.
const MARGIN: usize = 5;
/// Moves to a neighbour before an extremum is given up.
const MOVES: u32 = 5;

/// An extremum, in pixels and levels of its octave.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extremum {
    pub x: f32,
    pub y: f32,
    pub level: f32,
    pub response: f32,
}

/// Looks for extrema.
pub(super) struct Finder {
    contrast: f32,
    /// (r + 1)²/r with r the largest ratio of curvatures.
    edge: f32,
}

/// The difference of two levels: level + 1 less level.
#[derive(Clone, Copy)]
struct Difference<'a> {
    upper: &'a [f32],
    lower: &'a [f32],
}

impl<'a> Difference<'a> {
    fn new(octave: &'a Octave<'_>, level: usize) -> Self {
        Difference { upper: octave.level(level + 1), lower: octave.level(level) }
    }

    #[inline(always)]
    fn eight(&self, at: usize) -> f32x8 {
        load(self.upper, at) - load(self.lower, at)
    }

    #[inline(always)]
    fn one(&self, at: usize) -> f32 {
        self.upper[at] - self.lower[at]
    }
}

impl Finder {
    pub fn new(settings: &Settings) -> Self {
        let r = settings.edge;
        Finder { contrast: settings.contrast, edge: (r + 1.0) * (r + 1.0) / r }
    }

    /// Calls `found` for every extremum of the octave.
    pub fn find(&self, octave: &Octave<'_>, mut found: impl FnMut(Extremum)) {
        let end = octave.width - MARGIN;
        for level in 1..=STEPS {
            let around = [level - 1, level, level + 1].map(|level| Difference::new(octave, level));
            for y in MARGIN..octave.height - MARGIN {
                for start in (MARGIN..end).step_by(8) {
                    // The last packet overlaps the one before; `fresh` are the lanes not seen yet.
                    let x = start.min(octave.width - 9);
                    let fresh = (0xff << (start - x)) & 0xff;
                    let mut mask = self.extrema(&around, y * octave.width + x, octave.width) & fresh;
                    while mask != 0 {
                        let x = x + mask.trailing_zeros() as usize;
                        mask &= mask - 1;
                        if x < end
                            && let Some(extremum) = self.locate(octave, [x, y, level])
                        {
                            found(extremum);
                        }
                    }
                }
            }
        }
    }

    /// The lanes from `at` on that are no smaller or no larger than their 26 neighbours.
    #[inline(always)]
    fn extrema(&self, around: &[Difference<'_>; 3], at: usize, width: usize) -> u32 {
        let centre = around[1].eight(at);
        // Half the contrast: the fitted extremum can be higher than the highest pixel.
        let mut high = centre.simd_gt(f32x8::splat(0.5 * self.contrast));
        let mut low = centre.simd_lt(f32x8::splat(-0.5 * self.contrast));
        for difference in [around[1], around[0], around[2]] {
            if (high | low).to_bitmask() == 0 {
                return 0;
            }
            for row in [at - width, at, at + width] {
                for neighbour in [difference.eight(row - 1), difference.eight(row), difference.eight(row + 1)]
                {
                    high &= centre.simd_ge(neighbour);
                    low &= centre.simd_le(neighbour);
                }
            }
        }
        (high | low).to_bitmask()
    }

    /// The extremum of the quadratic through the pixels around; nothing if it runs away, is faint, or lies on an edge.
    fn locate(&self, octave: &Octave<'_>, mut place: [usize; 3]) -> Option<Extremum> {
        let mut moves = 0;
        let (derivatives, offset) = loop {
            let derivatives = Derivatives::new(octave, place);
            let offset = derivatives.offset()?;
            if offset.iter().all(|o| o.abs() <= 0.5) {
                break (derivatives, offset);
            }
            moves += 1;
            let inside = [octave.width, octave.height].map(|side| MARGIN..side - MARGIN);
            for (i, (coordinate, o)) in place.iter_mut().zip(offset).enumerate() {
                let step = if o > 0.5 { 1 } else { -isize::from(o < -0.5) };
                *coordinate = coordinate.checked_add_signed(step)?;
                let fits = inside.get(i).map_or((1..=STEPS).contains(coordinate), |r| r.contains(coordinate));
                if !fits || moves > MOVES {
                    return None;
                }
            }
        };
        let slope: f64 = derivatives.gradient.iter().zip(offset).map(|(g, o)| g * o).sum();
        let response = (derivatives.value + 0.5 * slope) as f32;
        let at = |i: usize| place[i] as f32 + offset[i] as f32;
        let strong = response.abs() >= self.contrast && !derivatives.is_edge(self.edge);
        strong.then(|| Extremum { x: at(0), y: at(1), level: at(2), response })
    }
}

/// Value, gradient and second derivatives in x, y and level.
struct Derivatives {
    value: f64,
    gradient: [f64; 3],
    hessian: [[f64; 3]; 3],
}

impl Derivatives {
    fn new(octave: &Octave<'_>, [x, y, level]: [usize; 3]) -> Self {
        let [below, here, above] = [level - 1, level, level + 1].map(|level| Difference::new(octave, level));
        let (at, w) = (y * octave.width + x, octave.width);
        let v = |difference: &Difference<'_>, at: usize| f64::from(difference.one(at));
        let mixed = |pp: f64, pm: f64, mp: f64, mm: f64| 0.25 * (pp - pm - mp + mm);
        let value = v(&here, at);
        let pairs = [
            (v(&here, at + 1), v(&here, at - 1)),
            (v(&here, at + w), v(&here, at - w)),
            (v(&above, at), v(&below, at)),
        ];
        let xy =
            mixed(v(&here, at + w + 1), v(&here, at + w - 1), v(&here, at - w + 1), v(&here, at - w - 1));
        let xs = mixed(v(&above, at + 1), v(&above, at - 1), v(&below, at + 1), v(&below, at - 1));
        let ys = mixed(v(&above, at + w), v(&above, at - w), v(&below, at + w), v(&below, at - w));
        let [xx, yy, ss] = pairs.map(|(p, m)| p + m - 2.0 * value);
        Derivatives {
            value,
            gradient: pairs.map(|(p, m)| 0.5 * (p - m)),
            hessian: [[xx, xy, xs], [xy, yy, ys], [xs, ys, ss]],
        }
    }

    /// Where the quadratic's extremum lies; nothing if it has none.
    fn offset(&self) -> Option<[f64; 3]> {
        let by = -1.0 / determinant(&self.hessian);
        let solve = |row: [f64; 3]| row.iter().zip(self.gradient).map(|(a, g)| a * g).sum::<f64>() * by;
        let offset = adjugate(&self.hessian).map(solve);
        offset.iter().all(|o| o.abs() < 1e3).then_some(offset)
    }

    /// Whether the curvature along is small against that across.
    fn is_edge(&self, limit: f32) -> bool {
        let [[xx, xy, _], [_, yy, _], _] = self.hessian;
        let (trace, determinant) = (xx + yy, xx * yy - xy * xy);
        determinant <= 0.0 || trace * trace >= f64::from(limit) * determinant
    }
}
