//! Weights against a scalar twin that reads the film pixel by pixel.

extern crate std;

use super::*;
use crate::film::{FLOATS, WORDS, luminance};
use crate::sobol::hash;
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
    let threshold = crate::tvi::tvi(f32x8::splat((light / known * cd) as f32)).to_array()[0];
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
            kernel.adapt(&layout, &mut planes, &[]);
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
