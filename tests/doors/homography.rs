//! Any pairs of points, or those of any mapping with some moved: refused, or a mapping that is what is said of it.

use super::bytes::Bytes;
use pmcip_core::predict::homography::{self, Block, Error, Fit, Homography, MAX_COORDINATE, Pair, Settings};

/// More pairs than two blocks have, so that a last one is not full.
const PAIRS: usize = 60;

/// A head of settings, nine numbers of a matrix if `mapped`, then the pairs.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let kind = bytes.byte();
    let (tame, mapped, any_settings) = (kind & 1 == 1, kind & 2 == 2, kind & 4 == 4);
    let mut settings =
        Settings { max_iterations: bytes.word() % 64, seed: bytes.word(), ..Settings::default() };
    if any_settings {
        settings.threshold = f64::from_bits(bytes.long());
        settings.confidence = f64::from(bytes.float(tame));
    }
    let count = bytes.below(PAIRS + 1);
    let mut pairs = Vec::new();
    let number = |bytes: &mut Bytes| match tame {
        true => 8.0 * f64::from(bytes.level()),
        false => f64::from_bits(bytes.long()),
    };
    let matrix = [[0; 3]; 3].map(|row| row.map(|_| if mapped { f64::from(bytes.level()) } else { 0.0 }));
    for _ in 0..count {
        let from = [number(&mut bytes), number(&mut bytes)];
        let to = Homography { matrix }.apply(from).filter(|_| mapped && bytes.below(5) > 0);
        pairs.push(Pair { from, to: to.unwrap_or_else(|| [number(&mut bytes), number(&mut bytes)]) });
    }
    let mut scratch = vec![Block::default(); homography::required(count)];
    let found = homography::estimate(&pairs, &settings, &mut scratch);
    assert_eq!(found, homography::estimate(&pairs, &settings, &mut scratch), "another time, other bits");
    if count >= 4 && found != Err(Error::Settings) {
        let short = homography::estimate(&pairs, &settings, &mut scratch[1..]);
        assert!(short == Err(Error::Scratch), "{short:?}");
    }
    match found {
        Ok(fit) => sound(&fit, &pairs, &settings),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

fn sound(fit: &Fit, pairs: &[Pair], settings: &Settings) {
    let matrix = fit.homography.matrix;
    assert!(matrix.as_flattened().iter().all(|v| v.is_finite()), "{matrix:?}");
    assert!(pairs.iter().flat_map(|p| [p.from, p.to]).flatten().all(|v| v.abs() <= MAX_COORDINATE));
    let inliers = pairs.iter().filter(|pair| fit.homography.error(pair) <= settings.threshold).count();
    assert_eq!(fit.inliers as usize, inliers);
    assert!(fit.sigma > 0.0 && fit.sigma.is_finite(), "sigma {}", fit.sigma);
    assert!(fit.iterations <= settings.max_iterations);
    let corners = [-MAX_COORDINATE, -1.0, 0.0, 0.5, 640.0, MAX_COORDINATE];
    let points =
        corners.iter().flat_map(|x| corners.map(|y| [*x, y])).chain(pairs.iter().map(|pair| pair.from));
    let back = fit.homography.inverse();
    for point in points {
        for map in [Some(&fit.homography), back.as_ref()].into_iter().flatten() {
            assert!(map.apply(point).is_none_or(|p| p.iter().all(|v| v.is_finite())), "{map:?} of {point:?}");
        }
    }
}

/// A grid moved; a grid in perspective, some pairs wrong; a line; one point; any bits.
pub fn seeds() -> Vec<Vec<u8>> {
    let words = |values: &[i16]| -> Vec<u8> { values.iter().flat_map(|v| v.to_le_bytes()).collect() };
    let head = |kind: u8, count: u8| [&[kind, 50, 0, 0, 0, 1, 0, 0, 0], &[count][..]].concat();
    let grid = |point: fn(i16) -> [i16; 2], right: u8| -> Vec<u8> {
        (0..40).flat_map(|i| [words(&point(i)), vec![if i % 7 == 3 { 0 } else { right }]].concat()).collect()
    };
    let moved = words(&[256, 3, 700, -3, 256, 200, 0, 0, 256]);
    let perspective = words(&[250, 30, 700, -20, 270, 200, 1, 2, 300]);
    let square: fn(i16) -> [i16; 2] = |i| [(i % 6) * 900, (i / 6) * 1100];
    let line: fn(i16) -> [i16; 2] = |i| [i * 300, i * 200];
    vec![
        [head(3, 40), moved.clone(), grid(square, 1)].concat(),
        [head(3, 40), perspective, grid(square, 1)].concat(),
        [head(3, 40), moved.clone(), grid(line, 1)].concat(),
        [head(3, 4), moved, grid(square, 1)].concat(),
        [head(1, 12), vec![5; 96]].concat(),
        [head(4, 9), 3.0f64.to_le_bytes().to_vec(), (0..96u8).map(|i| i.wrapping_mul(37)).collect()].concat(),
    ]
}
