//! Values over time: keys, and what is between them.
//!
//! Before its first key a value is that of the first, after its last that of the last. Between two keys it is
//! either linear or smooth. With h the time from key to key and s the slope, a smooth value is the cubic (Hermite)
//! whose tangent at a key is that of the parabola through the key and its neighbours, and at the first and last key
//! that of the parabola through the nearest three: motion that is a parabola stays one, whatever the times of the
//! keys (for even times this is Catmull and Rom, *A class of local interpolating splines*, 1974). Two keys give a
//! straight line.
//!
//! Such a curve swings beyond its keys. What must not, because it has to keep its sign or stay in a range, follows
//! the monotone tangents of Fritsch and Butland, *A method for constructing local monotone piecewise cubic
//! interpolants*, 1984, and never leaves the range of the two keys around it.
//!
//! Rotations are unit quaternions. Linear is slerp, smooth the cumulative cubic of Kim, Kim and Shin, *A general
//! construction scheme for unit quaternion curves with simple high order derivatives*, SIGGRAPH 1995, with angular
//! velocities at the keys as above. Both take the short way from key to key.

use glam::{Quat, Vec3};
use serde::Deserialize;

/// How a value gets from key to key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Interpolation {
    Linear,
    #[default]
    Smooth,
}

/// Whether a smooth value may swing beyond its keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Swing {
    Free,
    Bounded,
}

/// Keys of `N` numbers in order of their frames, at least one.
#[derive(Clone, Debug)]
pub(super) struct Track<const N: usize> {
    keys: Vec<(f64, [f64; N])>,
    interpolation: Interpolation,
    swing: Swing,
}

impl<const N: usize> Track<N> {
    /// A value that follows `keys`; without any it is `still`.
    pub fn new(
        still: [f64; N],
        keys: impl IntoIterator<Item = (u32, [f64; N])>,
        interpolation: Interpolation,
        swing: Swing,
    ) -> Self {
        let mut keys: Vec<_> = keys.into_iter().map(|(frame, value)| (f64::from(frame), value)).collect();
        if keys.is_empty() {
            keys.push((0.0, still));
        }
        Track { keys, interpolation, swing }
    }

    /// The value of a frame, or of a time between frames.
    pub fn at(&self, frame: impl Into<f64>) -> [f64; N] {
        let frame = frame.into();
        let Some((i, u)) = locate(&self.keys, frame) else { return self.end(frame) };
        std::array::from_fn(|c| self.component(i, u, c))
    }

    /// The value before the first key or after the last.
    fn end(&self, frame: f64) -> [f64; N] {
        let last = self.keys.len() - 1;
        self.keys[if frame <= self.keys[0].0 { 0 } else { last }].1
    }

    fn component(&self, i: usize, u: f64, c: usize) -> f64 {
        let value = |k: usize| self.keys[k].1[c];
        let (a, b) = (value(i), value(i + 1));
        if self.interpolation == Interpolation::Linear {
            return a + (b - a) * u;
        }
        let slope = |k: usize| (value(k + 1) - value(k)) / self.span(k);
        let [from, to] = [i, i + 1].map(|k| self.span(i) * self.tangent(k, slope));
        hermite(a, b, from, to, u)
    }

    /// Time from key `k` to the next.
    fn span(&self, k: usize) -> f64 {
        self.keys[k + 1].0 - self.keys[k].0
    }

    /// The tangent at key `k` of one component, whose slope after a key is `slope`.
    fn tangent(&self, k: usize, slope: impl Fn(usize) -> f64) -> f64 {
        let last = self.keys.len() - 1;
        if last == 1 {
            return slope(0);
        }
        let bounded = self.swing == Swing::Bounded;
        // The spans next to the key, the nearer first where the key is an end.
        let at_end = |near: usize, far: usize| {
            let (s, t) = (slope(near), slope(far));
            let tangent = end_tangent([self.span(near), self.span(far)], [s, t]);
            if bounded { bounded_end(tangent, s, t) } else { tangent }
        };
        match k {
            0 => at_end(0, 1),
            k if k == last => at_end(last - 1, last - 2),
            k => {
                let (h, s) = ([self.span(k - 1), self.span(k)], [slope(k - 1), slope(k)]);
                if bounded { monotone(h, s) } else { parabola(h, s) }
            }
        }
    }
}

/// The keys around a frame and how far it is from the first to the second; none outside of all keys.
pub(super) fn locate<T>(keys: &[(f64, T)], frame: f64) -> Option<(usize, f64)> {
    let after = keys.partition_point(|key| key.0 <= frame);
    if after == 0 || after == keys.len() {
        return None;
    }
    let (from, to) = (keys[after - 1].0, keys[after].0);
    Some((after - 1, (frame - from) / (to - from)))
}

/// The cubic from `a` to `b` with these changes per interval at its ends.
pub(super) fn hermite(a: f64, b: f64, from: f64, to: f64, u: f64) -> f64 {
    let v = 1.0 - u;
    a + (b - a) * u * u * (3.0 - 2.0 * u) + u * v * (v * from - u * to)
}

/// Slope of a parabola at its middle point of three.
fn parabola(h: [f64; 2], s: [f64; 2]) -> f64 {
    (h[1] * s[0] + h[0] * s[1]) / (h[0] + h[1])
}

/// Slope of a parabola at its end.
fn end_tangent(h: [f64; 2], s: [f64; 2]) -> f64 {
    ((2.0 * h[0] + h[1]) * s[0] - h[0] * s[1]) / (h[0] + h[1])
}

/// Tangent between slopes `s` that makes no new extremum: a weighted harmonic mean.
fn monotone(h: [f64; 2], s: [f64; 2]) -> f64 {
    if s[0] * s[1] <= 0.0 {
        return 0.0;
    }
    let w = [2.0 * h[1] + h[0], h[1] + 2.0 * h[0]];
    (w[0] + w[1]) / (w[0] / s[0] + w[1] / s[1])
}

/// An end's tangent such that the curve stays between its two keys; `s` is the slope there, `t` the next one.
fn bounded_end(tangent: f64, s: f64, t: f64) -> f64 {
    if tangent * s <= 0.0 {
        0.0
    } else if s * t < 0.0 && tangent.abs() > 3.0 * s.abs() {
        3.0 * s
    } else {
        tangent
    }
}

/// Keys of rotations in order of their frames, at least one.
#[derive(Clone, Debug)]
pub(super) struct Turn {
    keys: Vec<(f64, Quat)>,
    interpolation: Interpolation,
}

impl Turn {
    /// A rotation that follows `keys`; without any it is `still`.
    pub fn new(
        still: Quat,
        keys: impl IntoIterator<Item = (u32, Quat)>,
        interpolation: Interpolation,
    ) -> Self {
        let mut turn = Turn { keys: Vec::new(), interpolation };
        for (frame, rotation) in keys {
            // q and −q are the same rotation; the nearer one makes the way short.
            let near = turn.keys.last().is_none_or(|(_, last)| last.dot(rotation) >= 0.0);
            turn.keys.push((f64::from(frame), if near { rotation } else { -rotation }));
        }
        if turn.keys.is_empty() {
            turn.keys.push((0.0, still));
        }
        turn
    }

    /// The rotation of a frame, or of a time between frames.
    pub fn at(&self, frame: impl Into<f64>) -> Quat {
        let frame = frame.into();
        let Some((i, u)) = locate(&self.keys, frame) else {
            let last = self.keys.len() - 1;
            return self.keys[if frame <= self.keys[0].0 { 0 } else { last }].1;
        };
        let (from, u) = (self.keys[i].1, u as f32);
        if self.interpolation == Interpolation::Linear {
            return (from * exp(self.step(i) * u)).normalize();
        }
        let h = self.span(i);
        let [first, third] = [i, i + 1].map(|k| self.velocity(k) * (h / 3.0));
        let whole = exp(self.step(i));
        let second = log(exp(-first) * whole * exp(-third));
        let v = 1.0 - u;
        let (b3, b2) = (u * u * u, 3.0 * u * u * v);
        let b1 = 3.0 * u * v * v;
        (from * exp(first * (b1 + b2 + b3)) * exp(second * (b2 + b3)) * exp(third * b3)).normalize()
    }

    fn span(&self, k: usize) -> f32 {
        (self.keys[k + 1].0 - self.keys[k].0) as f32
    }

    /// The rotation from key `k` to the next, as axis times angle.
    fn step(&self, k: usize) -> Vec3 {
        log(self.keys[k].1.inverse() * self.keys[k + 1].1)
    }

    /// Angular velocity at key `k`, by the rule for tangents.
    fn velocity(&self, k: usize) -> Vec3 {
        let last = self.keys.len() - 1;
        let pick = |near: usize, far: usize, rule: fn([f64; 2], [f64; 2]) -> f64| {
            let h = [near, far].map(|k| f64::from(self.span(k)));
            let s = [near, far].map(|k| (self.step(k) / self.span(k)).to_array());
            Vec3::from_array([0, 1, 2].map(|c| rule(h, s.map(|s| f64::from(s[c]))) as f32))
        };
        match k {
            _ if last == 1 => self.step(0) / self.span(0),
            0 => pick(0, 1, end_tangent),
            k if k == last => pick(last - 1, last - 2, end_tangent),
            k => pick(k - 1, k, parabola),
        }
    }
}

/// The rotation about an axis by its length, in radians.
fn exp(axis: Vec3) -> Quat {
    Quat::from_scaled_axis(axis)
}

/// Axis times angle, at most half a turn.
fn log(rotation: Quat) -> Vec3 {
    let near = if rotation.w < 0.0 { -rotation } else { rotation };
    near.normalize().to_scaled_axis()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(keys: &[(u32, f64)], interpolation: Interpolation, swing: Swing) -> Track<1> {
        Track::new([9.0], keys.iter().map(|&(frame, value)| (frame, [value])), interpolation, swing)
    }

    #[test]
    fn linear_values_are_exact_at_keys_and_straight_between() {
        let track = track(&[(10, 1.0), (20, 3.0), (24, -1.0)], Interpolation::Linear, Swing::Free);
        for (frame, value) in [(0, 1.0), (10, 1.0), (15, 2.0), (20, 3.0), (21, 2.0), (24, -1.0), (99, -1.0)] {
            assert_eq!(track.at(frame), [value], "{frame}");
        }
    }

    #[test]
    fn smooth_values_reproduce_parabolas_at_uneven_keys_ends_included() {
        let law = |t: u32| 0.25 * f64::from(t * t) - 3.0 * f64::from(t) + 7.0;
        let keys = [0, 3, 10, 11, 30].map(|t| (t, law(t)));
        let track = track(&keys, Interpolation::Smooth, Swing::Free);
        for t in 0..=30 {
            assert!((track.at(t)[0] - law(t)).abs() < 1e-4, "{t}: {} {}", track.at(t)[0], law(t));
        }
    }

    #[test]
    fn bounded_values_stay_between_their_keys() {
        let keys = [(0, 0.0), (10, 0.0), (11, 5.0), (40, 5.5), (50, 0.1), (90, 0.1)];
        let track = track(&keys, Interpolation::Smooth, Swing::Bounded);
        for pair in keys.windows(2) {
            let (low, high) = (pair[0].1.min(pair[1].1), pair[0].1.max(pair[1].1));
            for t in pair[0].0..=pair[1].0 {
                let value = track.at(t)[0];
                assert!(low - 1e-6 <= value && value <= high + 1e-6, "{t}: {value}");
            }
        }
    }

    #[test]
    fn nothing_keyed_stands_still_and_one_key_holds() {
        assert_eq!(track(&[], Interpolation::Smooth, Swing::Free).at(5), [9.0]);
        assert_eq!(track(&[(7, 2.0)], Interpolation::Smooth, Swing::Free).at(5), [2.0]);
        assert_eq!(track(&[(0, 2.0), (10, 4.0)], Interpolation::Smooth, Swing::Free).at(5), [3.0]);
    }

    /// A turn about a fixed axis by an angle for each frame.
    fn turn(angle: impl Fn(u32) -> f32, frames: &[u32], interpolation: Interpolation) -> (Turn, Vec3) {
        let axis = Vec3::new(1.0, 2.0, -0.5).normalize();
        let keys = frames.iter().map(|&f| (f, Quat::from_axis_angle(axis, angle(f))));
        (Turn::new(Quat::IDENTITY, keys, interpolation), axis)
    }

    #[test]
    fn rotations_turn_evenly_and_the_short_way() {
        for interpolation in [Interpolation::Linear, Interpolation::Smooth] {
            // More than a whole turn in all, less than half a one from key to key.
            let (turn, axis) = turn(|f| 0.1 * f as f32, &[0, 20, 50, 75], interpolation);
            for f in 0..=75 {
                let away = turn.at(f).angle_between(Quat::from_axis_angle(axis, 0.1 * f as f32));
                assert!(away < 2e-3, "{interpolation:?} {f}: {away}");
            }
        }
    }

    #[test]
    fn smooth_rotations_reproduce_even_acceleration_and_meet_their_keys() {
        let law = |f: u32| 0.002 * f as f32 * f as f32;
        let (turn, axis) = turn(law, &[0, 10, 25, 40], Interpolation::Smooth);
        for f in 0..=40 {
            let away = turn.at(f).angle_between(Quat::from_axis_angle(axis, law(f)));
            assert!(away < 2e-3, "{f}: {away}");
        }
        let keys = [
            (0, Quat::from_rotation_x(0.4)),
            (9, Quat::from_rotation_y(1.9)),
            (12, Quat::from_rotation_z(-1.0)),
        ];
        let turn = Turn::new(Quat::IDENTITY, keys, Interpolation::Smooth);
        for (frame, key) in keys {
            assert!(turn.at(frame).angle_between(key) < 2e-3);
        }
    }
}
