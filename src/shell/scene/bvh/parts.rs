//! Divides boxes into parts of little surface, on all threads.

use glam::Vec3A;
use std::array::from_fn;

/// Bins along an axis in which a place to divide is looked for.
const BINS: usize = 32;

/// Boxes together: how many, and what is around them.
#[derive(Clone, Copy)]
struct Bin {
    count: usize,
    low: Vec3A,
    high: Vec3A,
}

impl Bin {
    const EMPTY: Bin = Bin { count: 0, low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };

    fn join(self, other: Bin) -> Bin {
        Bin { count: self.count + other.count, low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Half the surface times the number.
    fn cost(&self) -> f32 {
        let size = (self.high - self.low).max(Vec3A::ZERO);
        self.count as f32 * (size.x * size.y + size.y * size.z + size.z * size.x)
    }
}

/// Divides `all` into `parts` parts, a power of two, in the order in which they come: in halves by the least surface of the
/// boxes around them times their numbers, of [`BINS`] places along each axis. There must be as many boxes as parts.
pub(super) fn divide(
    bounds: &(impl Fn(u32) -> (Vec3A, Vec3A) + Sync),
    all: Vec<u32>,
    parts: usize,
) -> Vec<Vec<u32>> {
    if parts == 1 {
        return vec![all];
    }
    let (low, high) = halve(bounds, all, parts / 2);
    let below = |half| divide(bounds, half, parts / 2);
    let (mut low, high) = rayon::join(|| below(low), || below(high));
    low.extend(high);
    low
}

/// Two halves of at least `least` boxes.
fn halve(bounds: &impl Fn(u32) -> (Vec3A, Vec3A), all: Vec<u32>, least: usize) -> (Vec<u32>, Vec<u32>) {
    let middle = |i: u32| {
        let (low, high) = bounds(i);
        0.5 * low + 0.5 * high
    };
    let start = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
    let (low, high) = all.iter().map(|i| middle(*i)).fold(start, |(low, high), m| (low.min(m), high.max(m)));
    let scale = BINS as f32 / (high - low);
    let place = |i: u32| {
        let place = (middle(i) - low) * scale;
        place.to_array().map(|x| (x as usize).min(BINS - 1))
    };
    let mut bins = [[Bin::EMPTY; BINS]; 3];
    for i in &all {
        let (low, high) = bounds(*i);
        for (axis, at) in place(*i).into_iter().enumerate() {
            bins[axis][at] = bins[axis][at].join(Bin { count: 1, low, high });
        }
    }
    let best = (0..3).filter_map(|axis| best_place(&bins[axis], least).map(|best| (best, axis)));
    match best.min_by(|a, b| a.0.0.total_cmp(&b.0.0)) {
        Some(((_, limit), axis)) => all.into_iter().partition(|i| place(*i)[axis] < limit),
        None => {
            let mut low = all;
            let high = low.split_off(low.len() / 2);
            (low, high)
        }
    }
}

/// Least cost, and the bin before which to divide for it; none if a side would have less than `least`.
fn best_place(bins: &[Bin; BINS], least: usize) -> Option<(f32, usize)> {
    let mut above = [Bin::EMPTY; BINS];
    let mut sum = Bin::EMPTY;
    for at in (0..BINS).rev() {
        sum = sum.join(bins[at]);
        above[at] = sum;
    }
    let mut below = Bin::EMPTY;
    let costs: [Option<f32>; BINS] = from_fn(|at| {
        let fits = below.count >= least && above[at].count >= least;
        let cost = fits.then(|| below.cost() + above[at].cost());
        below = below.join(bins[at]);
        cost
    });
    let known = (0..BINS).filter_map(|at| costs[at].map(|cost| (cost, at)));
    known.min_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_that_lie_apart_are_told_apart() {
        // Four clouds along x, of which the second is large.
        let at =
            |i: u32| Vec3A::new([0.0, 10.0, 40.0, 41.0][i as usize % 4] + (i / 4) as f32 * 1e-3, 0.0, 0.0);
        let bounds = |i: u32| (at(i), at(i) + 0.5);
        let parts = divide(&bounds, (0..400).collect(), 4);
        let mut all: Vec<u32> = parts.concat();
        all.sort_unstable();
        assert_eq!(all, (0..400).collect::<Vec<_>>());
        for part in parts {
            assert_eq!(part.len(), 100);
            assert!(part.iter().all(|i| i % 4 == part[0] % 4) && part.is_sorted());
        }
    }

    #[test]
    fn what_coincides_or_is_no_number_is_divided_all_the_same() {
        for corner in [Vec3A::ONE, Vec3A::NAN, Vec3A::splat(f32::MAX)] {
            let parts = divide(&|_| (corner, corner), (0..80).collect(), 8);
            assert_eq!(parts.iter().map(Vec::len).collect::<Vec<_>>(), [10; 8]);
        }
    }
}
