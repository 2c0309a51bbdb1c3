//! The median of 3 × 3 pixels.

use super::blur::{load, starts};
use super::picture::{Error, Picture};
use wide::f32x8;

/// Writes the median of every pixel's 3 × 3 neighbourhood to `target`; beyond the border pixels repeat.
///
/// Single wild pixels vanish, edges stay; nothing is blurred together.
///
/// # Errors
/// [`Error::Size`] if `target` has not as many values as the picture.
pub fn median3(picture: Picture<'_>, target: &mut [f32]) -> Result<(), Error> {
    if target.len() != picture.values.len() {
        return Err(Error::Size);
    }
    let width = picture.width;
    let row = |y: usize| &picture.values[y * width..][..width];
    for (y, target) in target.chunks_exact_mut(width).enumerate() {
        let rows = [y.saturating_sub(1), y, (y + 1).min(picture.height - 1)].map(row);
        for x in starts(width) {
            let columns = [-1, 0, 1].map(|shift| sorted(rows.map(|row| shifted(row, x, shift))));
            target[x..x + 8].copy_from_slice(&median(columns).to_array());
        }
    }
    Ok(())
}

/// Eight values of a row from `x + shift` on, those beyond its ends repeated.
#[inline(always)]
fn shifted(row: &[f32], x: usize, shift: isize) -> f32x8 {
    match x.checked_add_signed(shift) {
        Some(x) if x + 8 <= row.len() => load(row, x),
        _ => f32x8::from(core::array::from_fn::<f32, 8, _>(|lane| {
            row[(x + lane).saturating_add_signed(shift).min(row.len() - 1)]
        })),
    }
}

/// Three values, the least first.
#[inline(always)]
fn sorted([a, b, c]: [f32x8; 3]) -> [f32x8; 3] {
    let (low, high) = (a.fast_min(b), a.fast_max(b));
    let (least, rest) = (low.fast_min(c), low.fast_max(c));
    [least, rest.fast_min(high), rest.fast_max(high)]
}

/// The median of three sorted columns: of the largest least, the middle middle and the smallest largest one.
#[inline(always)]
fn median([a, b, c]: [[f32x8; 3]; 3]) -> f32x8 {
    let least = a[0].fast_max(b[0]).fast_max(c[0]);
    let middle = sorted([a[1], b[1], c[1]])[1];
    let largest = a[2].fast_min(b[2]).fast_min(c[2]);
    sorted([least, middle, largest])[1]
}
