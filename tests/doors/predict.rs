//! Any beliefs, any motion, any matches and regions: what is carried is usable or nothing, and a film that starts from it
//! plans and samples as ever.

use super::bytes::{Bytes, Cycle};
use pmcip::film::Film;
use pmcip_core::predict::homography::{self, Block, Pair};
use pmcip_core::predict::tracks::{MAX_REGIONS, NO_REGION, Tracks, regions};
use pmcip_core::predict::{Belief, Filter, Prior, carry};
use pmcip_core::sampler::Settings;

/// A head of sizes and numbers of the filter, a few pairs, then numbers that are repeated.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let tame = bytes.bit();
    let (width, height) = (1 + bytes.below(24), 1 + bytes.below(24));
    let filter =
        Filter { cd_per_unit: bytes.float(tame), spread: bytes.float(tame), drift: bytes.float(tame) };
    let (quantile, least) = (bytes.float(tame), u32::from(bytes.byte()));
    let number = |bytes: &mut Bytes| f64::from(bytes.level());
    let pairs: Vec<Pair> = (0..bytes.below(32))
        .map(|_| Pair { from: [0; 2].map(|_| number(&mut bytes)), to: [0; 2].map(|_| number(&mut bytes)) })
        .collect();
    let mut any = bytes.cycle(usize::MAX, tame);
    let pixels = width * height;
    let (mut labels, mut words) = (vec![0; pixels], vec![0; pixels]);
    let density = any.list(pixels);
    let count = regions(&density, width, quantile, least, &mut labels, &mut words).expect("right lengths");
    assert!(count as usize <= MAX_REGIONS);
    assert!(labels.iter().all(|label| *label < count || *label == NO_REGION));
    let positions = tracked(&pairs, &labels, (width, height), &mut any);
    let before = beliefs(&mut any, pixels);
    let seen = beliefs(&mut any, pixels);
    for positions in [positions, (0..pixels).map(|_| [any.one(), any.one()]).collect()] {
        let mut carried = vec![Belief::NONE; pixels];
        carry(&before, width, height, &positions, Belief::NONE, &mut carried).expect("right lengths");
        sampled(&carried, &any, (width, height));
        let sane = filter.cd_per_unit > 0.0 && filter.spread > 0.0 && filter.drift >= 0.0;
        let sane = sane && [filter.cd_per_unit, filter.spread, filter.drift].iter().all(|v| *v < 1e6);
        let outlook = filter.update(width, &mut carried, &seen).expect("right lengths");
        if sane {
            assert!(
                (0.0..=1.0).contains(&outlook.miss) && (0.0..=1.0).contains(&outlook.known),
                "{outlook:?}"
            );
            // Nothing is known of a pixel, or what is known can be used, unless that was at the end of all numbers.
            let fine = |b: &Belief| {
                b.usable().is_some() || b.freedom == 0.0 || b.freedom > 1e30 || b.light.abs() > 1e30
            };
            assert_eq!(carried.iter().find(|belief| !fine(belief)), None);
        }
    }
}

fn beliefs(any: &mut Cycle, pixels: usize) -> Vec<Belief> {
    (0..pixels).map(|_| Belief { variance: any.one(), light: any.one(), freedom: any.one() }).collect()
}

/// Where the pixels were by homographies of regions, those of the picture and any.
fn tracked(
    pairs: &[Pair],
    labels: &[u32],
    (width, height): (usize, usize),
    any: &mut Cycle,
) -> Vec<[f32; 2]> {
    let (mut picked, mut blocks) =
        (pairs.to_vec(), vec![Block::default(); homography::required(pairs.len())]);
    let settings = homography::Settings { max_iterations: 50, ..homography::Settings::default() };
    let mut positions = vec![[0.0; 2]; width * height];
    let labels_too: Vec<u32> = any.list(labels.len()).iter().map(|v| *v as u32 % 12).collect();
    for labels in [&labels_too[..], labels] {
        let tracks =
            Tracks::find(pairs, labels, width, &settings, &mut picked, &mut blocks).expect("right lengths");
        let all = tracks.regions.iter().chain([&tracks.global]).flatten();
        assert!(all.flat_map(|h| h.matrix).flatten().all(|v| v.is_finite()));
        tracks.positions(labels, width, height, &mut positions).expect("right lengths");
    }
    positions
}

/// Begins with beliefs and with a kernel, whatever they are.
fn sampled(beliefs: &[Belief], any: &Cycle, (width, height): (usize, usize)) {
    let mut film = Film::new(Settings::new(width as u32, height as u32)).expect("there is memory");
    let alpha = any.clone().list(beliefs.len());
    let mut integrand = any.clone();
    let mut total = 0;
    for prior in [Prior::Beliefs(beliefs), Prior::Alpha(&alpha)] {
        let samples = 2 * film.pixels() + 3;
        film.begin_predicted(samples, prior).expect("it is at rest");
        film.render(&mut integrand).expect("it runs");
        let tally = film.end().expect("all is taken");
        total += samples;
        assert_eq!(tally.samples + tally.rejected, total);
        let alpha = film.alpha().expect("there is memory");
        assert!(alpha.iter().all(|a| a.is_finite() && *a >= 0.0));
    }
    let mut seen = vec![Belief::NONE; beliefs.len()];
    film.with(|sampler| sampler.beliefs(&mut seen)).expect("right length");
    assert!(
        seen.iter().all(|b| b.usable().is_some() || b.freedom == 0.0 || !b.variance.is_finite()),
        "{seen:?}"
    );
}

/// Tame numbers with a motion, tame ones without, numbers of any bits.
pub fn seeds() -> Vec<Vec<u8>> {
    let words = |values: &[i16]| -> Vec<u8> { values.iter().flat_map(|v| v.to_le_bytes()).collect() };
    let grid: Vec<u8> = (0..30i16)
        .flat_map(|i| {
            let (x, y) = (i % 6 * 900, i / 6 * 1000);
            words(&[x, y, x + 256 + y / 30, y - 300])
        })
        .collect();
    let ramp: Vec<u8> = (0..120i16).flat_map(|i| (i * 61).to_le_bytes()).collect();
    let any = [f32::NAN, f32::INFINITY, 1e-40, 0.3, -1.0, 1e30, 5.0, 2.0, 8.0, 100.0]
        .map(f32::to_le_bytes)
        .concat();
    let head =
        |kind: u8, pairs: u8| [vec![kind, 19, 15], words(&[25_600, 2048, 12, 230]), vec![4, pairs]].concat();
    vec![
        [head(1, 30), grid.clone(), ramp.clone()].concat(),
        [head(1, 0), ramp].concat(),
        [vec![0, 9, 9], [100.0f32, 8.0, 0.05, 0.9].map(f32::to_le_bytes).concat(), vec![1, 0], any.clone()]
            .concat(),
        [head(0, 12), grid, any].concat(),
    ]
}
