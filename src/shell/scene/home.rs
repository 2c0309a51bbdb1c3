//! Where coordinates begin: models far from the origin are moved to their own centre, since single precision would
//! crumble them.

use glam::DVec3;

/// A model is moved if its centre is further away than so many times half its largest side.
const FAR: f64 = 16.0;

/// The point of a box that coordinates in it are best counted from: the origin itself if that is near, else one near the
/// centre, of few digits.
pub(super) fn home(low: DVec3, high: DVec3) -> DVec3 {
    let (centre, half) = (0.5 * (low + high), 0.5 * (high - low).max_element());
    if !(centre.is_finite() && half > 0.0 && half.is_finite() && centre.abs().max_element() > FAR * half) {
        return DVec3::ZERO;
    }
    let step = half.log2().ceil().exp2();
    (centre / step).round() * step
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_far_away_is_moved() {
        let around =
            |centre: DVec3| home(centre - DVec3::new(1.0, 0.5, 0.0), centre + DVec3::new(1.0, 0.5, 0.0));
        assert_eq!(around(DVec3::new(15.9, -15.9, 0.0)), DVec3::ZERO);
        assert_eq!(around(DVec3::new(500_000.25, 4e6, 100.0)), DVec3::new(500_000.0, 4e6, 100.0));
        assert_eq!(home(DVec3::ONE, DVec3::ONE), DVec3::ZERO);
        assert_eq!(home(DVec3::INFINITY, DVec3::NEG_INFINITY), DVec3::ZERO);
    }
}
