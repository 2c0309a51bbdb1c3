//! Error measures against values worked out by hand and against plain twins.

use pmcip::error::Error;
use pmcip::picture::frame_io::Picture;
use pmcip::picture::metrics::{luminance, measure, oracle_ratio, oracle_ratio_at_cost};
use pmcip_core::maths::tvi::tvi;
use wide::f32x8;

const WIDTH: u32 = 50;
const HEIGHT: u32 = 30;
const CD: f64 = 100.0;

fn filled(pixel: impl Fn(u32, u32) -> [f32; 3]) -> Picture {
    let rgb = (0..WIDTH * HEIGHT).map(|i| pixel(i % WIDTH, i / WIDTH)).collect();
    Picture { width: WIDTH, height: HEIGHT, rgb, ..Picture::default() }
}

fn tvi_scalar(luminance: f32) -> f32 {
    tvi(f32x8::splat(luminance)).to_array()[0]
}

#[track_caller]
fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-6 * b.abs().max(1e-12), "{a} is not {b}");
}

#[test]
fn a_constant_error_has_the_values_worked_out_by_hand() {
    let m = measure(&filled(|_, _| [0.75; 3]), &filled(|_, _| [0.5; 3]), CD).unwrap();
    let err = 25.0 * 25.0 / f64::from(tvi_scalar(50.0));
    close(m.err, err);
    close(m.err_lowpass, err);
    close(m.mse, 0.0625);
    close(m.mse_trimmed, 0.0625);
    close(m.rel_mse, 0.0625 / 0.26);
    close(m.energy_bias, 0.5);
    assert!(m.energy_bias_stderr < 1e-9);
    assert_eq!(m.oracle_ratio, None);
}

#[test]
fn equal_images_have_no_error() {
    let image = filled(|x, y| [x as f32, y as f32, 0.0]);
    let m = measure(&image, &image, CD).unwrap();
    assert_eq!([m.err, m.err_lowpass, m.mse, m.rel_mse, m.energy_bias], [0.0; 5]);
}

#[test]
fn trimming_leaves_out_a_thousandth_of_the_pixels_rounded_up() {
    let reference = filled(|_, _| [1.0; 3]);
    let image = filled(|x, y| if y == 0 && x < 3 { [101.0; 3] } else { [1.0; 3] });
    let m = measure(&image, &reference, CD).unwrap();
    close(m.mse, 3.0 * 1e4 / 1500.0);
    close(m.mse_trimmed, 1e4 / 1498.0);
    close(m.rel_mse_trimmed, 1e4 / 1.01 / 1498.0);
}

#[test]
fn channels_are_averaged_in_mse_and_weighted_in_luminance() {
    let m = measure(&filled(|_, _| [1.0, 2.0, 1.0]), &filled(|_, _| [1.0; 3]), CD).unwrap();
    close(m.mse, 1.0 / 3.0);
    close(m.energy_bias, luminance([0.0, 1.0, 0.0]));
    close(luminance([0.0, 1.0, 0.0]), 0.7152);
}

#[test]
fn low_pass_cancels_what_alternates_and_keeps_what_stays() {
    let checker = |x: u32, y: u32| if (x + y).is_multiple_of(2) { 0.1 } else { -0.1 };
    let m = measure(&filled(|x, y| [1.0 + checker(x, y); 3]), &filled(|_, _| [1.0; 3]), CD).unwrap();
    assert!(m.err > 1.0 && m.err_lowpass < 1e-9 * m.err);
}

#[test]
fn low_pass_equals_a_plain_twin() {
    let wave = |x: u32, y: u32| ((x * 7 + y * 13) % 17) as f32;
    let (image, reference) = (filled(|x, y| [wave(x, y); 3]), filled(|x, y| [wave(y, x) + 0.1; 3]));
    let mut sum = 0.0;
    for (top, left) in (0..HEIGHT - 7).flat_map(|y| (0..WIDTH - 7).map(move |x| (y, x))) {
        let mean = |picture: &Picture| {
            let inside = (0..64).map(|i| ((top + i / 8) * WIDTH + left + i % 8) as usize);
            inside.map(|i| luminance(picture.rgb[i])).sum::<f64>() / 64.0
        };
        let (a, b) = (mean(&image), mean(&reference));
        sum += ((a - b) * CD).powi(2) / f64::from(tvi_scalar((b * CD) as f32));
    }
    let m = measure(&image, &reference, CD).unwrap();
    close(m.err_lowpass, sum / f64::from((HEIGHT - 7) * (WIDTH - 7)));
}

#[test]
fn an_image_smaller_than_the_box_is_averaged_whole() {
    let one = |value: f32| Picture { width: 1, height: 1, rgb: vec![[value; 3]], ..Picture::default() };
    let m = measure(&one(2.0), &one(1.0), CD).unwrap();
    close(m.err_lowpass, m.err);
    close(m.mse_trimmed, 1.0);
}

#[test]
fn the_standard_error_comes_from_the_variance_plane_or_from_the_spread() {
    let reference = filled(|_, _| [1.0; 3]);
    let mut image = filled(|x, _| if x % 2 == 0 { [1.2; 3] } else { [0.8; 3] });
    let spread = measure(&image, &reference, CD).unwrap().energy_bias_stderr;
    assert!((spread - 0.2 / 1500f64.sqrt()).abs() < 1e-6);
    image.planes.insert("variance".into(), vec![0.01; 1500]);
    let stated = measure(&image, &reference, CD).unwrap().energy_bias_stderr;
    assert!((stated - 0.1 / 1500f64.sqrt()).abs() < 1e-6);
}

#[test]
fn the_oracle_gains_nothing_on_even_noise_and_much_on_concentrated_noise() {
    close(oracle_ratio(&[2.0; 64], &[1.0; 64], CD), 1.0);
    let mut spot = [0.0; 64];
    spot[7] = 5.0;
    close(oracle_ratio(&spot, &[1.0; 64], CD), 64.0);
    close(oracle_ratio(&[0.0; 64], &[1.0; 64], CD), 1.0);
}

/// Half of the pixels have all noise, and cost three times what the others do: an oracle that gives them all has
/// (1 + 3)/3 of uniform sampling's samples there. Costs that are the same everywhere change nothing.
#[test]
fn an_oracle_at_equal_cost_pays_for_what_is_dear() {
    let half = |a: f64, b: f64| -> Vec<f64> { (0..64).map(|i| if i % 2 == 0 { a } else { b }).collect() };
    let cost: Vec<f32> = half(1.0, 3.0).iter().map(|v| *v as f32).collect();
    close(oracle_ratio_at_cost(&half(0.0, 1.0), &[1.0; 64], &cost, CD), 4.0 / 3.0);
    let noise = half(1.0, 3.0);
    close(oracle_ratio_at_cost(&noise, &[1.0; 64], &[5.0; 64], CD), oracle_ratio(&noise, &[1.0; 64], CD));
    close(oracle_ratio_at_cost(&[0.0; 64], &[1.0; 64], &cost, CD), 1.0);
}

#[test]
fn images_that_cannot_be_compared_are_refused() {
    let reference = filled(|_, _| [1.0; 3]);
    let small = Picture { width: 1, height: 1, rgb: vec![[1.0; 3]], ..Picture::default() };
    assert!(matches!(measure(&small, &reference, CD), Err(Error::Sizes { .. })));
    let broken = filled(|x, y| if (x, y) == (3, 4) { [0.0, f32::NAN, 0.0] } else { [1.0; 3] });
    assert!(matches!(measure(&broken, &reference, CD), Err(Error::NotFinite { which: "image", count: 1 })));
    assert!(matches!(
        measure(&reference, &broken, CD),
        Err(Error::NotFinite { which: "reference", count: 1 })
    ));
}
