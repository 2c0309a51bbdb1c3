//! What lies beyond the ends of a row.

/// The position that half-sample reflection puts at `i`: period 2n, ends repeated.
#[inline(always)]
pub(crate) fn fold(i: i64, n: usize) -> usize {
    if (0..n as i64).contains(&i) {
        return i as usize;
    }
    let j = i.rem_euclid(2 * n as i64) as usize;
    if j < n { j } else { 2 * n - 1 - j }
}
