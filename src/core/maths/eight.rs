//! Eight neighbouring values of a plane as a vector.

use wide::f32x8;

/// The first eight values of `from`; lanes beyond its end are 0.
#[inline(always)]
pub(crate) fn read8(from: &[f32]) -> f32x8 {
    match from.first_chunk::<8>() {
        Some(whole) => f32x8::from(*whole),
        None => {
            let mut lanes = [0.0; 8];
            lanes.iter_mut().zip(from).for_each(|(lane, value)| *lane = *value);
            f32x8::from(lanes)
        }
    }
}

/// [`read8`] of counts, limited to 2^31 − 1.
#[inline(always)]
pub(crate) fn count8(from: &[u32]) -> f32x8 {
    let float = |n: u32| n.min(i32::MAX as u32) as i32 as f32;
    match from.first_chunk::<8>() {
        Some(whole) => f32x8::from(whole.map(float)),
        None => {
            let mut lanes = [0.0; 8];
            lanes.iter_mut().zip(from).for_each(|(lane, n)| *lane = float(*n));
            f32x8::from(lanes)
        }
    }
}

/// Writes as many lanes as there is room for, up to eight.
#[inline(always)]
pub(crate) fn write8(to: &mut [f32], value: f32x8) {
    let lanes = value.to_array();
    match to.first_chunk_mut::<8>() {
        Some(whole) => *whole = lanes,
        None => to.iter_mut().zip(lanes).for_each(|(to, lane)| *to = lane),
    }
}

/// Writes as many colours as there is room for, up to eight.
#[inline(always)]
pub(crate) fn write_rgb8(to: &mut [[f32; 3]], [r, g, b]: [f32x8; 3]) {
    let (r, g, b) = (r.to_array(), g.to_array(), b.to_array());
    let colour = |i: usize| [r[i], g[i], b[i]];
    match to.first_chunk_mut::<8>() {
        Some(whole) => *whole = core::array::from_fn(colour),
        None => to.iter_mut().enumerate().for_each(|(i, to)| *to = colour(i)),
    }
}

/// The first eight colours of `from`; lanes beyond its end are black.
#[inline(always)]
pub(crate) fn read_rgb8(from: &[[f32; 3]]) -> [f32x8; 3] {
    let colour = |c: usize| match from.first_chunk::<8>() {
        Some(whole) => f32x8::from(whole.map(|rgb| rgb[c])),
        None => f32x8::from(core::array::from_fn(|i| from.get(i).map_or(0.0, |rgb| rgb[c]))),
    };
    [0, 1, 2].map(colour)
}
