//! Who is who: the nearest descriptor, if it is clearly nearer than the second.

use super::feature::{DESCRIPTOR, Feature, UNIT};
use crate::predict::homography::Pair;
use wide::{i16x16, i32x8};

/// Two features that look alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Match {
    /// Number of the feature in the first slice.
    pub from: usize,
    /// Number of the feature in the second slice.
    pub to: usize,
    /// Distance of the descriptors over that to the second best, 0 to 1: low is certain.
    pub ratio: f32,
}

impl Match {
    /// The two positions.
    pub fn pair(&self, from: &[Feature], to: &[Feature]) -> Pair {
        let at = |f: &Feature| [f64::from(f.x), f64::from(f.y)];
        Pair { from: at(&from[self.from]), to: at(&to[self.to]) }
    }
}

/// For every feature of `from` the one of `to` with the nearest descriptor, if its distance is below `ratio` times
/// that of the second nearest (Lowe: 0.8). Without a second one there is no match.
///
/// Compares all with all; 1000 × 1000 features take about 10 ms.
pub fn matches<'a>(from: &'a [Feature], to: &'a [Feature], ratio: f32) -> impl Iterator<Item = Match> + 'a {
    from.iter().enumerate().filter_map(move |(number, feature)| {
        let [(first, best), (_, second)] = nearest(feature, to)?;
        let found =
            Match { from: number, to: first, ratio: libm::sqrtf(best / second.max(f32::MIN_POSITIVE)) };
        (found.ratio < ratio).then_some(found)
    })
}

/// Numbers and squared distances of the two nearest features of the same sign of response.
fn nearest(feature: &Feature, among: &[Feature]) -> Option<[(usize, f32); 2]> {
    let mut best = [(usize::MAX, i32::MIN); 2];
    for (number, other) in among.iter().enumerate() {
        if (other.response < 0.0) != (feature.response < 0.0) {
            continue;
        }
        let product = dot(&feature.descriptor, &other.descriptor);
        if product > best[0].1 {
            best = [(number, product), best[0]];
        } else if product > best[1].1 {
            best[1] = (number, product);
        }
    }
    let square = |product: i32| (2.0 - 2.0 * product as f32 / (UNIT * UNIT)).max(0.0);
    (best[1].0 != usize::MAX).then(|| best.map(|(number, product)| (number, square(product))))
}

/// Product of two descriptors: UNIT² if they are equal.
#[inline(always)]
fn dot(a: &[i16; DESCRIPTOR], b: &[i16; DESCRIPTOR]) -> i32 {
    let sixteens = |d: &[i16; DESCRIPTOR]| -> [i16x16; DESCRIPTOR / 16] { bytemuck::cast(*d) };
    let sum = sixteens(a).into_iter().zip(sixteens(b)).fold(i32x8::splat(0), |sum, (a, b)| sum + a.dot(b));
    sum.to_array().iter().sum()
}
