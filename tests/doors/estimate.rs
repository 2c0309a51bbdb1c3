//! Any radiances in any film, of pixels or islands: every picture it can be asked for is finite and within what was seen, and
//! `balanced` has the energy of `difference`, island by island.

use super::bytes::{Bytes, Cycle};
use pmcip::film::Film;
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::{Mode, Sequence, Settings};

const ESTIMATORS: [Estimator; 5] =
    [Estimator::Pooled, Estimator::Subframe, Estimator::Difference, Estimator::Balanced, Estimator::Guided];
/// A film's sides are below this.
const SIDE: usize = 36;

/// A head of settings, iterations and labels, then radiances that are repeated.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let (kind, settings) = (bytes.byte(), settings(&mut bytes));
    let (tame, labelled) = (kind & 1 == 1, kind & 2 == 2);
    let iterations = [0; 3].map(|_| bytes.byte());
    let pixels = settings.width as usize * settings.height as usize;
    let labels =
        bytes.cycle(8, true).list(pixels).iter().map(|v| v.abs() as u16 / 8 % 4).collect::<Vec<u16>>();
    let film = if labelled { Film::with_labels(settings, &labels) } else { Film::new(settings) };
    let Ok(mut film) = film else { return };
    let labels = if labelled { labels } else { vec![1; pixels] };
    let mut integrand = bytes.cycle(usize::MAX, tame);
    let mut total = 0;
    for samples in iterations.map(|n| u64::from(n % 6) * film.pixels() + u64::from(n)) {
        if film.begin(samples).is_err() {
            assert_eq!(samples, 0);
            continue;
        }
        film.render(&mut integrand).expect("it runs");
        let tally = film.end().expect("all is taken");
        total += samples;
        assert_eq!(tally.samples + tally.rejected, total);
    }
    pictures(&mut film, &labels, &integrand);
}

fn settings(bytes: &mut Bytes) -> Settings {
    let [width, height] = [0; 2].map(|_| bytes.below(SIDE) as u32);
    let choice = bytes.byte();
    Settings {
        estimator: ESTIMATORS[usize::from(choice) % 5],
        sequence: if choice & 8 == 0 { Sequence::Continued } else { Sequence::Fresh },
        mode: if choice & 16 == 0 { Mode::Adaptive } else { Mode::Uniform },
        balance_radius: u32::from(bytes.byte()) << (choice >> 6),
        fair: u32::from(bytes.byte() % 16),
        gamma: bytes.level().abs() % 4.0,
        epsilon: bytes.level().abs() % 1.0,
        defensive: bytes.level().abs() % 1.0,
        ..Settings::new(width, height)
    }
}

fn pictures(film: &mut Film, labels: &[u16], integrand: &Cycle) {
    let own = film.settings().estimator;
    // Black where nothing is, or where nothing was usable.
    let usable = |v: &f32| v.abs() <= pmcip_core::sampler::batch::MAX_RADIANCE;
    let all = || integrand.values().iter().copied().filter(usable).chain([0.0]);
    let all = || all().chain(integrand.values().is_empty().then_some(1.0));
    let (least, most) = (all().fold(0.0, f32::min), all().fold(0.0, f32::max));
    let rounding = 1e-4 * least.abs().max(most);
    for estimator in ESTIMATORS {
        let asked = film.resolve(estimator);
        let serves = own.serves(estimator) && estimator != Estimator::Guided;
        assert_eq!(asked.is_ok(), serves, "{estimator:?} of a film for {own:?}");
        let Ok(picture) = asked else { continue };
        assert!(picture.as_flattened().iter().all(|v| v.is_finite()), "{estimator:?}");
        if estimator != Estimator::Balanced {
            let within = |v: &f32| (least - rounding..=most + rounding).contains(v);
            assert!(picture.as_flattened().iter().all(within), "{estimator:?} is outside of {least}..{most}");
        }
    }
    if own.serves(Estimator::Balanced) {
        let of = |film: &mut Film, estimator| film.resolve(estimator).expect("it serves");
        let used = of(film, Estimator::Pooled);
        let (fair, out) = (of(film, Estimator::Difference), of(film, Estimator::Balanced));
        (1..4).for_each(|label| energy(label, labels, [&used, &fair, &out]));
    }
}

/// ΣC = ΣD over an island, but for the rounding of what was summed.
fn energy(label: u16, labels: &[u16], pictures: [&[[f32; 3]]; 3]) {
    for c in 0..3 {
        let island = |picture: &[[f32; 3]], of: fn(f64) -> f64| -> f64 {
            let pixels = labels.iter().zip(picture).filter(|(l, _)| **l == label);
            pixels.map(|(_, rgb)| of(f64::from(rgb[c]))).sum()
        };
        let rounding = 1e-5 * pictures.iter().map(|p| island(p, f64::abs)).sum::<f64>() + 1e-30;
        let [_, fair, out] = pictures.map(|picture| island(picture, |v| v));
        assert!((out - fair).abs() <= rounding, "island {label}: {out}, not {fair}, to {rounding}");
    }
}

/// Pixels and islands, tame and of any bits.
pub fn seeds() -> Vec<Vec<u8>> {
    let settings = |estimator: u8| [&[20, 17, estimator, 96, 2], &[200, 0, 2, 0, 80, 0][..]].concat();
    let labels: Vec<u8> = [3i16, 3000, 5000, 7000].iter().flat_map(|v| v.to_le_bytes()).collect();
    let ramp: Vec<u8> = (0..90i16).flat_map(|i| (i * 83).to_le_bytes()).collect();
    let any = [f32::NAN, f32::INFINITY, 1e-40, 0.3, -1.0, 1e15, 9e14, 1e-20].map(f32::to_le_bytes).concat();
    let seed = |kind: u8, estimator: u8, radiance: &[u8]| {
        [&[kind], &settings(estimator)[..], &[2, 4, 3], &labels, radiance].concat()
    };
    vec![
        seed(1, 3, &ramp),
        seed(3, 3, &ramp),
        seed(1, 9, &ramp),
        seed(0, 1, &any),
        seed(2, 3, &any),
        seed(1, 0, &ramp),
        seed(1, 20, &ramp),
    ]
}
