//! Keys that have a time each and say how to get to the next, as glTF's do: by a step, straight, or as a cubic (Hermite)
//! whose tangents are given.
//!
//! Before its first key a value is that of the first, after its last that of the last.

use super::track::{hermite, locate};
use glam::DQuat;

/// How a value gets from key to key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Blend {
    /// It stays until the next key.
    Step,
    /// Straight; rotations the short way at an even pace.
    Linear,
    /// A cubic.
    Cubic,
}

/// A key: the tangent on the way to it, its value, the tangent on the way from it. Tangents are changes a second.
pub(super) type Key<const N: usize> = [[f64; N]; 3];

/// Keys of `N` numbers in order of their times in seconds, at least one.
#[derive(Clone, Debug)]
pub(super) struct Channel<const N: usize> {
    keys: Vec<(f64, Key<N>)>,
    blend: Blend,
}

impl<const N: usize> Channel<N> {
    /// Values that follow `keys`, none if there are none or if their times do not rise.
    pub fn new(keys: Vec<(f64, Key<N>)>, blend: Blend) -> Option<Self> {
        let rises = keys.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let finite = |(time, key): &(f64, Key<N>)| {
            time.is_finite() && key.as_flattened().iter().all(|v| v.is_finite())
        };
        (rises && !keys.is_empty() && keys.iter().all(finite)).then_some(Channel { keys, blend })
    }

    /// Times of the first key and the last, in seconds.
    pub fn span(&self) -> (f64, f64) {
        (self.keys[0].0, self.keys[self.keys.len() - 1].0)
    }

    /// The value at a time in seconds.
    pub fn at(&self, time: f64) -> [f64; N] {
        let Some((i, u)) = locate(&self.keys, time) else { return self.end(time) };
        let ((start, from), (end, to)) = (&self.keys[i], &self.keys[i + 1]);
        let step = end - start;
        std::array::from_fn(|c| match self.blend {
            Blend::Step => from[1][c],
            Blend::Linear => from[1][c] + (to[1][c] - from[1][c]) * u,
            Blend::Cubic => hermite(from[1][c], to[1][c], step * from[2][c], step * to[0][c], u),
        })
    }

    /// The value before the first key or after the last.
    fn end(&self, time: f64) -> [f64; N] {
        let last = self.keys.len() - 1;
        self.keys[if time <= self.keys[0].0 { 0 } else { last }].1[1]
    }
}

impl Channel<4> {
    /// The rotation at a time in seconds; none where the numbers make no rotation.
    pub fn turn(&self, time: f64) -> Option<DQuat> {
        let unit = |q: [f64; 4]| {
            let q = DQuat::from_array(q);
            let length = q.length();
            (length.is_normal()).then(|| q * length.recip())
        };
        match (self.blend, locate(&self.keys, time)) {
            (Blend::Linear, Some((i, u))) => {
                let [from, to] = [i, i + 1].map(|k| unit(self.keys[k].1[1]));
                Some(from?.slerp(to?, u))
            }
            _ => unit(self.at(time)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Keys of a cubic and of its derivative, at uneven times.
    fn keys(law: impl Fn(f64) -> f64, slope: impl Fn(f64) -> f64) -> Vec<(f64, Key<1>)> {
        [0.5, 1.0, 3.0].map(|t| (t, [[slope(t)], [law(t)], [slope(t)]])).to_vec()
    }

    #[test]
    fn cubics_with_their_tangents_are_exact() {
        let law = |t: f64| t * t * t - 4.0 * t + 1.0;
        let channel = Channel::new(keys(law, |t| 3.0 * t * t - 4.0), Blend::Cubic).unwrap();
        for time in [0.5, 0.6, 0.99, 1.0, 1.7, 2.9, 3.0] {
            assert!((channel.at(time)[0] - law(time)).abs() < 1e-12, "{time}");
        }
        assert_eq!(channel.at(0.0), [law(0.5)]);
        assert_eq!(channel.at(9.0), [law(3.0)]);
    }

    #[test]
    fn steps_hold_and_lines_are_straight() {
        let of = |blend| Channel::new(keys(|t| 2.0 * t, |_| 7.0), blend).unwrap();
        let (step, line) = (of(Blend::Step), of(Blend::Linear));
        for (time, held) in [(0.1, 1.0), (0.99, 1.0), (1.0, 2.0), (2.99, 2.0), (3.0, 6.0), (4.0, 6.0)] {
            assert_eq!(step.at(time), [held], "{time}");
        }
        assert!((line.at(1.75)[0] - 3.5).abs() < 1e-12);
    }

    #[test]
    fn turns_go_the_short_way_at_an_even_pace() {
        let about = |angle: f64| DQuat::from_rotation_y(angle);
        let key = |time, q: DQuat| (time, [[0.0; 4], q.to_array(), [0.0; 4]]);
        let turn = Channel::new(vec![key(0.0, about(0.0)), key(2.0, -about(1.0))], Blend::Linear).unwrap();
        for time in [0.0, 0.5, 1.3, 2.0, 5.0] {
            let away = turn.turn(time).unwrap().angle_between(about(0.5 * f64::min(time, 2.0)));
            assert!(away < 1e-6, "{time}: {away}");
        }
    }

    #[test]
    fn keys_that_do_not_rise_or_are_no_numbers_are_refused() {
        let key = |time: f64, value: f64| (time, [[0.0], [value], [0.0]]);
        for keys in [
            vec![],
            vec![key(1.0, 0.0), key(1.0, 0.0)],
            vec![key(f64::NAN, 0.0)],
            vec![key(0.0, f64::INFINITY)],
        ] {
            assert!(Channel::new(keys, Blend::Linear).is_none());
        }
    }
}
