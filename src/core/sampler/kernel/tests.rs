//! Weights against a scalar twin that reads the film pixel by pixel.

extern crate std;

use super::*;
use crate::maths::colour::luminance;
use crate::maths::sobol::hash;
use crate::sampler::film::{FLOATS, Planes, WORDS};
use std::vec;
use std::vec::Vec;

/// The weight of the pixel in column `x` and row `y`, by the definition.
fn scalar(kernel: &Kernel, layout: &Layout, planes: &Planes<'_>, x: u32, y: u32) -> f32 {
    let reach = if kernel.window == Window::Pixel { 0 } else { 1 };
    let (mut m2, mut freedom, mut light, mut known) = (0.0, 0.0, 0.0, 0.0);
    for row in y.saturating_sub(reach)..(y + reach + 1).min(layout.height()) {
        for column in x.saturating_sub(reach)..(x + reach + 1).min(layout.width()) {
            let i = layout.index(column, row);
            let share = f64::from((2 - row.abs_diff(y)) * (2 - column.abs_diff(x)));
            m2 += share * f64::from(planes.m2[i]);
            freedom += share * f64::from(planes.count[i].saturating_sub(1));
            light += share * f64::from(luminance(planes.mean_at(i)));
            known += if planes.count[i] > 0 { share } else { 0.0 };
        }
    }
    if freedom == 0.0 {
        return UNKNOWN;
    }
    let cd = f64::from(kernel.cd_per_unit);
    let threshold = crate::maths::tvi::tvi(f32x8::splat((light / known * cd) as f32)).to_array()[0];
    let spent = if kernel.criterion == Criterion::Mean { planes.count[layout.index(x, y)].max(1) } else { 1 };
    let variance = m2 / freedom / f64::from(spent);
    libm::pow(variance * cd * cd / f64::from(threshold), f64::from(kernel.gamma)) as f32
}

/// A film of random moments; about a third of the pixels have no sample, a third one, a third several.
fn fill(planes: &mut Planes<'_>) {
    for i in 0..planes.count.len() {
        let random = hash(i as u32);
        let count = [0, 1, 2 + random % 7][(random >> 8) as usize % 3];
        planes.count[i] = count;
        planes.m2[i] = if count > 1 { (random >> 12) as f32 * 1e-5 } else { 0.0 };
        for c in 0..3 {
            planes.mean[c][i] = if count > 0 { (hash(random + c as u32) >> 20) as f32 * 1e-3 } else { 0.0 };
        }
    }
}

#[test]
fn weights_equal_the_scalar_twin() {
    for (width, height) in [(1, 1), (1, 20), (16, 16), (17, 33), (50, 3), (40, 40)] {
        let layout = Layout::new(width, height).unwrap();
        let (mut floats, mut words) = (vec![0.0; FLOATS * layout.pixels()], vec![0; WORDS * layout.pixels()]);
        let mut planes = Planes::new(&mut floats, &mut words, layout.pixels()).unwrap();
        fill(&mut planes);
        for (window, gamma, criterion) in [
            (Window::Pixel, 1.0, Criterion::Sample),
            (Window::Square3, 2.0 / 3.0, Criterion::Mean),
            (Window::Square3, 0.0, Criterion::Sample),
        ] {
            let kernel = Kernel { criterion, gamma, window, cd_per_unit: 20.0 };
            let (film, target, _) = planes.apart();
            kernel.adapt(&layout, 0..layout.tiles(), &film, target, &[], |_| ());
            let pixels: Vec<_> = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).collect();
            for (x, y) in pixels {
                let (got, want) =
                    (planes.target[layout.index(x, y)], scalar(&kernel, &layout, &planes, x, y));
                assert!(
                    (got - want).abs() <= 1e-4 * want.abs(),
                    "{got}, not {want}, at {x}, {y} of {width}×{height}"
                );
            }
        }
    }
}

#[test]
fn weights_of_anything_are_finite() {
    let kernel =
        Kernel { criterion: Criterion::Sample, gamma: 4.0, window: Window::Pixel, cd_per_unit: 1e30 };
    let odd = [0.0, -1.0, f32::MIN_POSITIVE, 1.0, f32::MAX, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
    for luminance in odd {
        let weight = kernel.weight(f32x8::from(odd), f32x8::splat(luminance)).to_array();
        assert!(weight.iter().all(|w| w.is_finite() && *w >= 0.0), "{weight:?}");
        assert_eq!((weight[0], weight[1], weight[7]), (0.0, 0.0, 0.0));
    }
}

/// Each window, and how many times it counts a degree of freedom.
const WINDOWS: [(Window, f32); 2] = [(Window::Pixel, 1.0), (Window::Square3, 2.25)];

fn kernel(window: Window) -> Kernel {
    Kernel { criterion: Criterion::Sample, gamma: 1.0, window, cd_per_unit: 20.0 }
}

/// Windows that know `freedom` of eight levels; sums are over windows of `weight`.
fn windows(freedom: [f32; 8], weight: f32) -> Eight {
    let lanes = |of: fn(f32) -> f32| f32x8::from(freedom.map(of)) * f32x8::splat(weight);
    Eight {
        m2: lanes(|freedom| 0.3 * freedom),
        freedom: lanes(|freedom| freedom),
        light: lanes(|freedom| 0.5 * (1.0 + freedom)),
        known: lanes(|freedom| 0.25 * (1.0 + freedom)),
        spent: f32x8::splat(3.0),
    }
}

/// The quantities of a window's sums, by the names of [`Eight`].
fn numbers(eight: &Eight) -> [[f32; 8]; 5] {
    [eight.m2, eight.freedom, eight.light, eight.known, eight.spent].map(|lanes| lanes.to_array())
}

/// What [`Kernel::filled_up`] says of one lane, by its definition in double precision.
fn filled_up(seen: [f64; 5], belief: Option<Belief>, weight: f64) -> [f64; 5] {
    let [m2, freedom, light, known, spent] = seen;
    let Some(belief) = belief.and_then(|belief| belief.usable()) else { return seen };
    let part = (f64::from(ENOUGH) * weight - freedom).clamp(0.0, f64::from(belief.freedom) * weight);
    if part == 0.0 {
        return seen;
    }
    let (before, known) = (f64::from(belief.light), known + part);
    let light = (light + part * before).max(before * known);
    [m2 + part * f64::from(belief.variance), freedom + part, light, known, spent]
}

/// Freedoms on both sides of [`ENOUGH`].
const FREEDOMS: [f32; 8] = [0.0, 0.25, 1.0, 2.5, 3.75, 4.0, 5.0, 100.0];

fn believed(light: f32, freedom: f32) -> Belief {
    Belief { variance: 0.7, light, freedom }
}

#[test]
fn fill_ups_equal_the_scalar_twin() {
    // Darker and brighter than what is seen; too little to fill up, just enough, and plenty.
    for light in [0.0, 0.5, 40.0] {
        for freedom in [0.125, 1.5, 4.0, 1e6] {
            for (window, weight) in WINDOWS {
                let seen = windows(FREEDOMS, weight);
                let belief = believed(light, freedom);
                let got = numbers(&kernel(window).filled_up(seen, &[belief; 8]));
                for lane in 0..8 {
                    let wide = |all: [[f32; 8]; 5]| all.map(|lanes| f64::from(lanes[lane]));
                    let want = filled_up(wide(numbers(&seen)), Some(belief), f64::from(weight));
                    let near = |(got, want): (f64, f64)| (got - want).abs() <= 1e-6 * want.abs();
                    assert!(wide(got).into_iter().zip(want).all(near), "lane {lane}: {got:?}, not {want:?}");
                }
            }
        }
    }
}

#[test]
fn windows_are_filled_up_to_enough_and_no_further() {
    for (window, weight) in WINDOWS {
        let fill = |freedom| {
            let filled = kernel(window).filled_up(windows(FREEDOMS, weight), &[believed(0.5, freedom); 8]);
            (filled.freedom / f32x8::splat(weight)).to_array()
        };
        assert_eq!(fill(50.0), [4.0, 4.0, 4.0, 4.0, 4.0, 4.0, 5.0, 100.0], "full");
        assert_eq!(fill(0.5), [0.5, 0.75, 1.5, 3.0, 4.0, 4.0, 5.0, 100.0], "partial");
    }
}

#[test]
fn windows_that_know_enough_keep_their_bits() {
    for (window, weight) in WINDOWS {
        let seen = windows([4.0, 4.5, 7.0, 9.1, 15.3, 99.9, 1e6, 1e20], weight);
        let filled = kernel(window).filled_up(seen, &[believed(1e30, 1e30); 8]);
        assert_eq!(
            numbers(&filled).map(|q| q.map(f32::to_bits)),
            numbers(&seen).map(|q| q.map(f32::to_bits))
        );
    }
}

#[test]
fn beliefs_that_cannot_be_used_change_nothing() {
    let useless = [
        Belief::NONE,
        Belief { variance: f32::NAN, ..believed(1.0, 1.0) },
        Belief { variance: -1.0, ..believed(1.0, 1.0) },
        Belief { variance: f32::INFINITY, ..believed(1.0, 1.0) },
        believed(f32::NAN, 1.0),
        believed(f32::INFINITY, 1.0),
        believed(1.0, f32::NAN),
        believed(1.0, -2.0),
    ];
    for (window, weight) in WINDOWS {
        let seen = windows(FREEDOMS, weight);
        for prior in [&useless[..], &[]] {
            assert_eq!(numbers(&kernel(window).filled_up(seen, prior)), numbers(&seen));
        }
        // At the border of a picture there are fewer than eight: the lanes beyond it keep what they have.
        let filled = numbers(&kernel(window).filled_up(seen, &[believed(9.0, 9.0)]));
        assert_ne!(filled[1][0], numbers(&seen)[1][0]);
        assert!(filled.iter().zip(numbers(&seen)).all(|(filled, seen)| filled[1..] == seen[1..]));
    }
}

#[test]
fn weights_of_any_belief_are_finite() {
    let odd = [
        0.0,
        -1.0,
        1e-45,
        f32::MIN_POSITIVE,
        1.0,
        1e38,
        f32::MAX,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
    ];
    let beliefs = || {
        let pairs =
            odd.into_iter().flat_map(move |variance| odd.into_iter().map(move |light| (variance, light)));
        pairs.flat_map(move |(variance, light)| {
            odd.into_iter().map(move |freedom| Belief { variance, light, freedom })
        })
    };
    for (window, weight) in WINDOWS {
        for criterion in [Criterion::Sample, Criterion::Mean] {
            let kernel = Kernel { criterion, gamma: 4.0, ..kernel(window) };
            for belief in beliefs() {
                for seen in [Eight::default(), windows(FREEDOMS, weight)] {
                    let (variance, light) = kernel.judge(kernel.filled_up(seen, &[belief; 8]));
                    let weights = kernel.weight_or_unknown(variance, light).to_array();
                    let fine = |weight: &f32| weight.is_finite() && (*weight >= 0.0 || *weight == UNKNOWN);
                    assert!(weights.iter().all(fine), "{belief:?}: {weights:?}");
                }
            }
        }
    }
}

/// Negative control of the twin: a fill-up that lets dark beliefs darken the light of now would be seen.
#[test]
fn what_was_bright_has_its_noise_from_there() {
    let seen = windows([1.0; 8], 1.0);
    let light = |belief| {
        let filled = kernel(Window::Pixel).filled_up(seen, &[belief; 8]);
        (filled.light / filled.known).to_array()[0]
    };
    assert_eq!(light(believed(40.0, 3.0)), 40.0, "as bright as it was, though it is dark now");
    assert!((light(believed(0.0, 3.0)) - 1.0 / 3.5).abs() < 1e-6, "darker: the mean of both");
}
