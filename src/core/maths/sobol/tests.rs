//! Points against published direction numbers, scalar twin, net property, marginals, decorrelation.

extern crate std;

use super::*;
use std::vec::Vec;

/// The key of the sequence of the pixel at `x`, `y`, as the sampler makes it.
fn pixel_key(seed: u32, frame: u32, x: u32, y: u32) -> u32 {
    PixelKeys::new(seed, frame).at(u32x8::splat(y << 16 | x)).to_array()[0]
}

/// Eight points of one key, as pairs.
fn eight(index: u32, key: u32, set: u32) -> [(f32, f32); 8] {
    let (x, y) = point(u32x8::from(core::array::from_fn(|i| index + i as u32)), u32x8::splat(key), set);
    let (x, y) = (x.to_array(), y.to_array());
    core::array::from_fn(|i| (x[i], y[i]))
}

/// Direction numbers of Joe and Kuo, `new-joe-kuo-6`: dimension 1 van der Corput; dimension 2 s = 1, a = 0, m = 1.
fn sobol(index: u32) -> (u32, u32) {
    let mut v = [1u32 << 31; 32];
    for i in 1..32 {
        v[i] = v[i - 1] ^ v[i - 1] >> 1;
    }
    let y = (0..32).filter(|i| index >> i & 1 == 1).fold(0, |y, i| y ^ v[i]);
    (index.reverse_bits(), y)
}

/// The scrambling hash, one number at a time, on numbers whose bits are in order.
fn owen_scalar(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed).wrapping_mul(seed >> 16 | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

#[test]
fn first_points_are_the_published_ones() {
    let sixteenths = [
        (0, 0),
        (8, 8),
        (4, 12),
        (12, 4),
        (2, 10),
        (10, 2),
        (6, 6),
        (14, 14),
        (1, 15),
        (9, 7),
        (5, 3),
        (13, 11),
        (3, 5),
        (11, 13),
        (7, 9),
        (15, 1),
    ];
    for (i, want) in sixteenths.into_iter().enumerate() {
        let (x, y) = sobol(i as u32);
        assert_eq!((x >> 28, y >> 28), want, "point {i}");
    }
}

#[test]
fn pascal_is_the_second_dimension() {
    for i in 0..4_000u32 {
        let index = hash(i);
        let got = reverse(pascal(u32x8::splat(index))).to_array()[3];
        assert_eq!(got, sobol(index).1);
    }
}

#[test]
fn equals_the_scalar_twin() {
    for i in 0..2_000 {
        let (key, index, set) = (hash(i), hash(!i), i % 9);
        let base = hash(key ^ hash(set));
        let (x, y) = sobol(owen_scalar(index, base));
        let want = (owen_scalar(x, hash(base ^ 0x9e37_79b9)), owen_scalar(y, hash(base ^ 0x85eb_ca6b)));
        let unit = |v: u32| (v >> 8) as f32 / 16_777_216.0;
        let (x, y) = point(u32x8::splat(index), u32x8::splat(key), set);
        assert_eq!((x.to_array()[5], y.to_array()[5]), (unit(want.0), unit(want.1)));
    }
}

#[test]
fn every_elementary_interval_holds_one_point() {
    for (key, k) in (0..200).map(hash).zip((3..9).cycle()) {
        let n = 1u32 << k;
        let start = (key % 64) * n;
        for split in 0..=k {
            let (columns, rows) = (1u32 << split, 1u32 << (k - split));
            let mut hit = [false; 256];
            for (x, y) in (0..n / 8).flat_map(|i| eight(start + 8 * i, key, k)) {
                let cell = (x * columns as f32) as u32 * rows + (y * rows as f32) as u32;
                assert!(!hit[cell as usize], "two points in an interval of 1/{columns} × 1/{rows}");
                hit[cell as usize] = true;
            }
        }
    }
}

/// χ² of one sample a key over 64 × 64 cells: mean 4095, deviation 90.5. Bound: 5 deviations, 3 tests, so a
/// false alarm has probability below 2e-6. The control, a hash that only shifts keys by 2^-7, is far outside.
#[test]
fn one_point_a_key_is_uniform() {
    let chi_square = |f: &dyn Fn(u32) -> (f32, f32)| {
        let mut cells = [0u32; 4096];
        let n = 1 << 18;
        for i in 0..n {
            let (x, y) = f(i);
            cells[(x * 64.0) as usize * 64 + (y * 64.0) as usize] += 1;
        }
        let expected = f64::from(n) / 4096.0;
        cells.iter().map(|c| (f64::from(*c) - expected) * (f64::from(*c) - expected) / expected).sum::<f64>()
    };
    for index in [0, 5, 1_000_003] {
        let chi = chi_square(&|i| eight(index, pixel_key(7, 1, i % 512, i / 512), 0)[0]);
        assert!((chi - 4095.0).abs() < 5.0 * 90.5, "index {index}: χ² {chi}");
    }
    let control = chi_square(&|i| {
        let (x, y) = eight(0, 1, 0)[0];
        ((x + (i % 100) as f32 / 128.0) % 1.0, (y + (i / 100 % 128) as f32 / 128.0) % 1.0)
    });
    assert!((control - 4095.0).abs() > 5.0 * 90.5);
}

/// Correlation of x over neighbouring keys and sets; deviation 1/√n. Bound: 5 deviations, 3 tests.
#[test]
fn keys_and_sets_are_uncorrelated() {
    let n = 1 << 16;
    let correlation = |f: &dyn Fn(u32) -> (f32, f32)| {
        let sum: f64 = (0..n).map(f).map(|(a, b)| (f64::from(a) - 0.5) * (f64::from(b) - 0.5)).sum();
        12.0 * sum / f64::from(n)
    };
    let key = |i: u32| pixel_key(3, 0, i % 256, i / 256);
    let bound = 5.0 / libm::sqrt(f64::from(n));
    assert!(correlation(&|i| (eight(3, key(i), 0)[0].0, eight(3, key(i + 1), 0)[0].0)).abs() < bound);
    assert!(correlation(&|i| (eight(3, key(i), 0)[0].0, eight(3, key(i), 1)[0].0)).abs() < bound);
    assert!(correlation(&|i| (eight(3, key(i), 4)[0].0, eight(3, key(i), 4)[0].1)).abs() < bound);
    assert!(correlation(&|i| (eight(3, key(i), 0)[0].0, eight(3, key(i), 0)[0].0)).abs() > bound, "control");
}

/// Pairs of equal keys among those of all pixels of 1000 frames and of 1000 seeds, 64 × 64 each: n²/2³³ by chance, a
/// Poisson number. Bound: 5 deviations, 2 tests. The control mixes place and frame by one exclusive or.
#[test]
fn frames_and_seeds_share_keys_as_rarely_as_chance_has_it() {
    let pairs = |keys: &dyn Fn(u32, u32x8) -> u32x8| {
        let mut all = Vec::new();
        for frame in 0..1000 {
            for place in (0..64).flat_map(|y| (0..64).step_by(8).map(move |x| y << 16 | x)) {
                let lanes = u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
                all.extend(keys(frame, u32x8::splat(place) + lanes).to_array());
            }
        }
        all.sort_unstable();
        let expected = (all.len() as f64).powi(2) / 2.0f64.powi(33);
        let runs = all.chunk_by(|a, b| a == b).map(|run| run.len() * (run.len() - 1) / 2);
        (runs.sum::<usize>() as f64 - expected) / libm::sqrt(expected)
    };
    let frames = pairs(&|frame, place| PixelKeys::new(0, frame).at(place));
    assert!(frames.abs() < 5.0, "frames: {frames} deviations too many");
    let seeds = pairs(&|seed, place| PixelKeys::new(seed, 0).at(place));
    assert!(seeds.abs() < 5.0, "seeds: {seeds} deviations too many");
    let control = pairs(&|frame, place| hash8(place ^ u32x8::splat(frame)));
    assert!(control > 5.0, "control: {control}");
}

/// Frames 12 and 26, and 60 and 237, of seed 0 had the same keys in another order at 1920 × 1080.
#[test]
fn frames_whose_first_words_differ_in_coordinates_only_share_few_keys() {
    for (a, b) in [(12, 26), (60, 237)] {
        let keys = |frame| {
            let places = (0..512u32).flat_map(|y| (0..512).map(move |x| y << 16 | x));
            let mut keys: Vec<u32> =
                places.map(|place| PixelKeys::new(0, frame).at(u32x8::splat(place)).to_array()[0]).collect();
            keys.sort_unstable();
            keys
        };
        let (a, b) = (keys(a), keys(b));
        let shared = a.iter().filter(|key| b.binary_search(key).is_ok()).count();
        // 16 by chance, deviation 4.
        assert!(shared < 40, "{shared} of {} keys shared", a.len());
    }
}
