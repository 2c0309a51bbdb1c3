//! Beginnings and pictures in parts: the bits of one thread, whoever works on what and whatever is left undone.

use pmcip_core::predict::{Belief, Prior};
use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use pmcip_core::sampler::estimate::resolve;
use pmcip_core::sampler::guide::Filter;
use pmcip_core::sampler::{Error, Estimator, Memory, Mode, Sampler, Settings, Workspace, begin};
use std::sync::Mutex;
use wide::f32x8;

/// Noise of a strength that differs over the picture; a firefly now and then, and black here and there.
struct Noise;

impl Integrand for Noise {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        let (u, v) = batch.point(1);
        let stripe = (batch.x * f32x8::splat(0.11)).floor() * f32x8::splat(0.5);
        let lit = (stripe - stripe.floor()).simd_gt(f32x8::ZERO);
        let firefly = v.simd_lt(f32x8::splat(0.01)) & f32x8::splat(300.0);
        let light = lit & (u * batch.y * f32x8::splat(0.3) + firefly);
        Rgb8 { r: light, g: light * v, b: lit & v }
    }
}

/// Who works on parts.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Hands {
    /// Nobody knows of them.
    Plain,
    /// So many threads.
    Threads(usize),
    /// One, the last part first.
    Backward,
    /// Nobody, and after so many steps even the rest is dropped.
    Lazy(usize),
}

impl Hands {
    fn all<P: Send>(self, parts: impl Iterator<Item = P> + Send, work: impl Fn(P) + Sync) {
        match self {
            Hands::Threads(count) => {
                let parts = Mutex::new(parts);
                let next = || parts.lock().unwrap().next();
                std::thread::scope(|scope| {
                    (0..count).for_each(|_| _ = scope.spawn(|| std::iter::from_fn(next).for_each(&work)));
                });
            }
            Hands::Backward => parts.collect::<Vec<_>>().into_iter().rev().for_each(work),
            // Some are taken and left, the others are never asked for.
            Hands::Plain | Hands::Lazy(_) => drop(parts.take(2).collect::<Vec<_>>()),
        }
    }

    fn steps(self) -> usize {
        if let Hands::Lazy(steps) = self { steps } else { usize::MAX }
    }

    fn begin(self, sampler: &mut Sampler<'_>, samples: u64, prior: Prior<'_>) {
        if self == Hands::Plain {
            return sampler.begin_predicted(samples, prior).unwrap();
        }
        let mut beginning = sampler.beginning(samples, prior).unwrap();
        for _ in 0..self.steps() {
            let Some(parts) = beginning.parts() else { break };
            self.all(parts, |mut part: begin::Part<'_>| part.work());
        }
    }

    fn finish(self, mut resolving: resolve::Resolving<'_>) {
        for _ in 0..self.steps() {
            let Some(parts) = resolving.parts() else { break };
            self.all(parts, |mut part: resolve::Part<'_>| part.work());
        }
    }
}

/// What iterations start from.
#[derive(Clone, Copy, Debug)]
enum Known {
    Nothing,
    Beliefs,
    Alpha,
}

fn hash(i: usize) -> f32 {
    ((i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f32 / (1u64 << 24) as f32
}

/// All that four iterations leave, at their beginnings and ends, and pictures of them.
fn bytes(settings: Settings, labels: Option<&[u16]>, known: Known, hands: Hands) -> Vec<u8> {
    let (width, height) = (settings.width, settings.height);
    let pixels = (width * height) as usize;
    let required = Sampler::required_with_labels(width, height);
    let (mut floats, mut words) = (vec![f32::NAN; required.floats], vec![77; required.words]);
    let memory = Memory { floats: &mut floats, words: &mut words };
    let mut sampler = match labels {
        None => Sampler::new(settings, memory).unwrap(),
        Some(labels) => Sampler::with_labels(settings, memory, labels).unwrap(),
    };
    let belief =
        |i: usize| Belief { variance: hash(i), light: 2.0 * hash(i + 7), freedom: 9.0 * hash(i + 1) - 1.0 };
    let beliefs: Vec<_> = (0..pixels).map(belief).collect();
    let alpha: Vec<_> = (0..pixels).map(|i| if i % 5 == 1 { 0.0 } else { hash(i) }).collect();
    let (mut batches, mut radiance) = ([Batch8::default(); 64], [Rgb8::default(); 64]);
    let mut work = Workspace::new(&mut batches, &mut radiance).unwrap();
    let mut bytes = Vec::new();
    let keep = |sampler: &Sampler<'_>, bytes: &mut Vec<u8>| {
        let first = bytes.len();
        bytes.resize(first + sampler.saved_len(), 0);
        sampler.save(&mut bytes[first..]).unwrap();
    };
    for round in 0..4 {
        let prior = match known {
            Known::Beliefs => Prior::Beliefs(&beliefs),
            Known::Alpha if round > 0 => Prior::Alpha(&alpha),
            Known::Alpha | Known::Nothing => Prior::Beliefs(&[]),
        };
        let samples = 2 * sampler.pixels() as u64 + round;
        hands.begin(&mut sampler, samples, prior);
        keep(&sampler, &mut bytes);
        sampler.jobs().for_each(|mut job| _ = job.render(&mut Noise, &mut work));
        sampler.end().unwrap();
    }
    keep(&sampler, &mut bytes);
    pictures(&sampler, hands).iter().for_each(|value| bytes.extend(value.to_bits().to_le_bytes()));
    bytes
}

/// All pictures that can be made of a film.
fn pictures(sampler: &Sampler<'_>, hands: Hands) -> Vec<f32> {
    let Settings { width, height, estimator, .. } = *sampler.settings();
    let mut scratch = vec![[f32::NAN; 16]; Sampler::resolve_scratch(width, height)];
    let guide: Vec<_> = (0..(width * height) as usize).map(|i| [hash(i), 3.0 * hash(i / 3), 0.0]).collect();
    let (mut out, mut all) = (vec![[f32::NAN; 3]; guide.len()], Vec::new());
    for other in [Estimator::Pooled, Estimator::Subframe, Estimator::Difference, Estimator::Balanced] {
        if estimator.serves(other) {
            let rgb = out.as_flattened_mut();
            match hands {
                Hands::Plain => sampler.resolve(other, &mut scratch, rgb).unwrap(),
                _ => hands.finish(sampler.resolving(other, &mut scratch, rgb).unwrap()),
            }
            all.extend_from_slice(out.as_flattened());
        }
    }
    match hands {
        Hands::Plain => sampler.level(&guide, &mut scratch, &mut out).unwrap(),
        _ => hands.finish(sampler.leveling(&guide, &mut scratch, &mut out).unwrap()),
    }
    all.extend_from_slice(out.as_flattened());
    if estimator.serves(Estimator::Balanced) {
        match hands {
            Hands::Plain => sampler.resolve_guided(&guide, &mut scratch, &mut out).unwrap(),
            _ => hands.finish(sampler.resolving_guided(&guide, &mut scratch, &mut out).unwrap()),
        }
        all.extend_from_slice(out.as_flattened());
    }
    all
}

/// That everybody leaves the same.
fn check(settings: Settings, labels: Option<&[u16]>, known: Known, hands: &[Hands]) {
    let plain = bytes(settings, labels, known, Hands::Plain);
    for hands in hands {
        let same = bytes(settings, labels, known, *hands) == plain;
        assert!(
            same,
            "{hands:?}, {known:?}, {}×{}, {:?}",
            settings.width, settings.height, settings.estimator
        );
    }
}

const ALL: [Hands; 9] = [
    Hands::Threads(1),
    Hands::Threads(2),
    Hands::Threads(3),
    Hands::Threads(7),
    Hands::Backward,
    Hands::Lazy(usize::MAX),
    Hands::Lazy(0),
    Hands::Lazy(1),
    Hands::Lazy(2),
];

/// Odd sizes, one part and many of them, wide and high ones.
#[test]
fn parts_have_the_bits_of_one_thread() {
    for (width, height) in [(1, 1), (17, 9), (100, 3), (900, 20), (1, 3000), (130, 131)] {
        for known in [Known::Nothing, Known::Beliefs, Known::Alpha] {
            check(Settings::new(width, height).for_frame(2, 8), None, known, &ALL);
        }
    }
    for estimator in [Estimator::Subframe, Estimator::Difference, Estimator::Pooled] {
        check(Settings { estimator, ..Settings::new(120, 101) }, None, Known::Nothing, &ALL);
    }
    let uniform = Settings { mode: Mode::Uniform, ..Settings::new(120, 101) };
    check(uniform, None, Known::Nothing, &ALL);
}

/// A large island, on both sides of a small one, and thin ones; with a kernel of its own, too, which leaves out pixels.
#[test]
fn parts_of_islands_have_the_bits_of_one_thread() {
    let (width, height) = (190, 150);
    let label = |x: usize, y: usize| match (x, y) {
        (40..70, 30..50) => 3,
        (0..160, 0..140) if x % 37 != 5 => 9,
        (165..171, _) => 1000,
        (171.., 60..) => 2,
        _ => 0,
    };
    let labels: Vec<u16> = (0..width * height).map(|i| label(i % width, i / width)).collect();
    for known in [Known::Nothing, Known::Beliefs, Known::Alpha] {
        let settings = Settings::new(width as u32, height as u32).for_frame(2, 8);
        check(settings, Some(&labels), known, &ALL);
    }
    check(Settings::new(100, 90), Some(&vec![4; 9000]), Known::Nothing, &ALL);
}

/// There is more than one part where there is work for more than one thread, and what was done is not done again.
#[test]
fn there_are_parts_for_many_threads() {
    let required = Sampler::required(640, 480);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    let memory = Memory { floats: &mut floats, words: &mut words };
    let mut sampler = Sampler::new(Settings::new(640, 480), memory).unwrap();
    let mut beginning = sampler.beginning(1, Prior::Beliefs(&[])).unwrap();
    let mut steps = Vec::new();
    while let Some(parts) = beginning.parts() {
        steps.push(parts.map(|mut part| (part.work(), part.work())).count());
    }
    assert_eq!((steps, beginning.parts().is_none()), (vec![38, 38], true));
    drop(beginning);
    assert_eq!(sampler.jobs().map(|job| job.samples()).sum::<u64>(), 1);
}

/// What cannot begin leaves everything as it is.
#[test]
fn what_is_refused_changes_nothing() {
    let required = Sampler::required(8, 8);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    let memory = Memory { floats: &mut floats, words: &mut words };
    let mut sampler = Sampler::new(Settings::new(8, 8), memory).unwrap();
    let before = sampler.state();
    assert_eq!(sampler.beginning(0, Prior::Beliefs(&[])).err(), Some(Error::Samples));
    assert_eq!(sampler.beginning(64, Prior::Alpha(&[1.0])).err(), Some(Error::Prior));
    assert_eq!(sampler.state(), before);
    drop(sampler.beginning(64, Prior::Beliefs(&[])).unwrap());
    assert_eq!(sampler.beginning(64, Prior::Beliefs(&[])).err(), Some(Error::Begun));
    let (mut scratch, mut out) = ([[0.0; 16]; 6], [0.0; 192]);
    assert_eq!(sampler.resolving(Estimator::Pooled, &mut scratch, &mut out).err(), Some(Error::Running));
}

/// A filter's picture by rows, in any pieces, is the same; what is no row of it is refused.
#[test]
fn rows_of_a_filter_are_its_picture() {
    let (width, height) = (21usize, 13);
    let settings = Settings::new(width as u32, height as u32).for_frame(2, 8);
    let required = Sampler::required(settings.width, settings.height);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    let memory = Memory { floats: &mut floats, words: &mut words };
    let mut sampler = Sampler::new(settings, memory).unwrap();
    let (mut batches, mut radiance) = ([Batch8::default(); 64], [Rgb8::default(); 64]);
    let mut work = Workspace::new(&mut batches, &mut radiance).unwrap();
    sampler.begin(8 * 21 * 13).unwrap();
    sampler.jobs().for_each(|mut job| _ = job.render(&mut Noise, &mut work));
    sampler.end().unwrap();
    let mut scratch = vec![0.0; Filter::required(settings.width, settings.height)];
    let mut filter = Filter::new(&sampler, &[], &mut scratch).unwrap();
    for _ in 0..Filter::PASSES {
        filter.bands().for_each(|mut band| band.filter());
        filter.next();
    }
    let mut whole = vec![[0.0; 3]; width * height];
    filter.write(&mut whole).unwrap();
    for rows in [1, 4, 13] {
        let mut parts = vec![[f32::NAN; 3]; width * height];
        for (part, out) in parts.chunks_mut(rows * width).enumerate() {
            filter.write_rows(part * rows, out).unwrap();
        }
        assert_eq!(parts, whole);
    }
    for (first, pixels) in [(13, 21), (14, 0), (0, 20), (usize::MAX, 21), (12, 42)] {
        assert_eq!(filter.write_rows(first, &mut vec![[0.0; 3]; pixels]), Err(Error::Output));
    }
}
