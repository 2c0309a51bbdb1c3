//! Any picture: what is found in it lies in it and is finite, twice the same, and matches lead to what was found.

use super::bytes::Bytes;
use pmcip_core::predict::features::{self, Feature, MIN_SIDE, Picture, Settings, UNIT, matches, median3};

/// Room for features: fewer than a noisy picture has.
const ROOM: usize = 24;

/// A head of sizes and settings, then numbers that are repeated over the picture.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let kind = bytes.byte();
    let (tame, any_settings, smooth) = (kind & 1 == 1, kind & 2 == 2, kind & 4 == 4);
    let [width, height] = [0; 2].map(|_| MIN_SIDE - 1 + bytes.below(40));
    let settings = match any_settings {
        true => Settings { blur: bytes.float(tame), contrast: bytes.float(tame), edge: bytes.float(tame) },
        false => Settings::default(),
    };
    let mut values = bytes.cycle(usize::MAX, tame).list(width * height);
    if smooth {
        values
            .iter_mut()
            .enumerate()
            .for_each(|(i, v)| *v *= ((i % width) as f32 / 5.0).sin() * (i / width) as f32);
    }
    let Ok(picture) = Picture::new(&values, width, height) else {
        return assert!(width < MIN_SIDE || height < MIN_SIDE);
    };
    let mut scratch = vec![0.0; features::required(width, height)];
    let mut detect = |picture: Picture| {
        let mut found = [Feature::default(); ROOM];
        let count = features::detect(picture, &settings, &mut scratch, &mut found)?;
        Ok::<_, features::Error>(found[..count].to_vec())
    };
    let Ok(found) = detect(picture) else { return };
    assert!(found == detect(picture).expect("as before"), "another time, other bits");
    // Values count as clamped, and as black if they are none.
    let clamped: Vec<f32> = values.iter().map(|v| if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) }).collect();
    let same = detect(Picture::new(&clamped, width, height).expect("as before")).expect("as before");
    assert!(found == same, "clamped, it has other features");
    let mut median = vec![0.0; values.len()];
    median3(picture, &mut median).expect("as long");
    let calmer = detect(Picture::new(&median, width, height).expect("as before")).expect("as before");
    found.iter().chain(&calmer).for_each(|feature| sound(feature, width, height));
    for ratio in [0.8, 1.0, f32::NAN] {
        for found in matches(&found, &calmer, ratio).map(|m| (m.pair(&found, &calmer), m.ratio)) {
            assert!(found.1 >= 0.0 && found.1 < ratio, "{found:?}");
        }
    }
}

fn sound(feature: &Feature, width: usize, height: usize) {
    let Feature { x, y, scale, turn, response, descriptor } = feature;
    assert!(*x >= 0.0 && *y >= 0.0 && *x <= width as f32 && *y <= height as f32, "at {x} {y}");
    assert!(*scale > 0.0 && scale.is_finite() && (0.0..=1.0).contains(turn), "scale {scale}, turn {turn}");
    assert!(response.is_finite());
    let norm = descriptor.iter().map(|v| f32::from(*v) * f32::from(*v)).sum::<f32>().sqrt();
    assert!((norm / UNIT - 1.0).abs() < 0.01, "a descriptor of {norm}");
}

/// Blobs, noise, one colour, numbers of any bits.
pub fn seeds() -> Vec<Vec<u8>> {
    let noise: Vec<u8> = (0..400u16).flat_map(|i| (i.wrapping_mul(7919) % 256).to_le_bytes()).collect();
    let blobs: Vec<u8> = (0..300i16)
        .flat_map(|i| {
            let (x, y) = (i % 20 - 9, i / 20 - 7);
            (200 / (1 + (x * x + y * y) / 8)).to_le_bytes()
        })
        .collect();
    let any = [f32::NAN, f32::INFINITY, 1e-40, 0.3, -1.0, 0.9].map(f32::to_le_bytes).concat();
    vec![
        [&[1, 5, 0], &blobs[..]].concat(),
        [&[1, 21, 29], &noise[..]].concat(),
        [&[5, 39, 20], &noise[..200]].concat(),
        [&[3, 9, 9, 0x66, 1, 1, 0, 0, 9], &noise[..300]].concat(),
        [&[0, 10, 4], &any[..]].concat(),
        vec![1, 1, 1, 80],
    ]
}
