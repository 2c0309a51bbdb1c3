//! Allocation over some of the pixels.

use super::{Error, Known, Mixture, Shares, Steps, check};

/// The weight of a pixel that gets nothing, not even of what all get alike.
pub(crate) const CLOSED: f32 = f32::NEG_INFINITY;

/// [`allocate`](super::allocate) over the pixels that are not [`CLOSED`], which stay so.
///
/// Pixel by pixel, the cumulative sum in double precision: within some hundred units of 2^-32 sample.
pub(crate) fn allocate_open(
    target: &mut [f32],
    planned: &mut [u32],
    mix: Mixture,
    offset: u32,
) -> Result<(), Error> {
    check(target, planned, &mix)?;
    let mut known = Known::default();
    known.add(target);
    let open = target.iter().filter(|weight| **weight != CLOSED).count();
    let shares = Shares::new(&mix, open, &known);
    let mut steps = Steps::new(shares.bits, offset);
    let (mut pixels, mut weights) = (0.0, 0.0);
    planned.fill(0);
    for (target, planned) in target.iter_mut().zip(planned).filter(|(target, _)| **target != CLOSED) {
        pixels += 1.0;
        weights += f64::from(shares.weight(*target));
        let end = if pixels == open as f64 { shares.total } else { shares.cumulative(pixels, weights) };
        let units = steps.run(&[0], core::slice::from_mut(planned), end);
        *target = units as f32 * shares.samples;
    }
    Ok(())
}
