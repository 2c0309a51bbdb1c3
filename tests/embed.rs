//! Under another program: any integrand, pieces in any order, films as bytes, a film of its own.

use pmcip::Film;
use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::guide::Feature;
use pmcip_core::sampler::saved::Saved;
use pmcip_core::sampler::wave::{Piece, Wave, points};
use pmcip_core::sampler::{Error, Memory, Sampler, Settings, Workspace};
use wide::f32x8;

const WIDTH: u32 = 53;
const HEIGHT: u32 = 38;
const PIXELS: usize = (WIDTH * HEIGHT) as usize;

fn settings() -> Settings {
    Settings { seed: 4, ..Settings::new(WIDTH, HEIGHT).for_frame(2, 12) }
}

/// Noise that grows to the right.
fn ramp(batch: &Batch8) -> Rgb8 {
    let (u, v) = batch.point(1);
    let value = batch.x * u * u;
    Rgb8 { r: value, g: value * v, b: f32x8::ONE }
}

/// The same from flat arrays.
fn flat(x: &[f32], index: &[u32], key: &[u32]) -> Vec<[f32; 3]> {
    let (mut u, mut v) = (vec![0.0; x.len()], vec![0.0; x.len()]);
    points(1, index, key, &mut u, &mut v);
    (0..x.len()).map(|i| [x[i] * u[i] * u[i], x[i] * u[i] * u[i] * v[i], 1.0]).collect()
}

/// A picture of four iterations, each one's samples taken by `work`.
fn picture(labels: bool, mut work: impl FnMut(&mut Sampler<'_>)) -> Vec<[f32; 3]> {
    let required = Sampler::required_with_labels(WIDTH, HEIGHT);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    let memory = Memory { floats: &mut floats, words: &mut words };
    let islands: Vec<u8> = (0..PIXELS).map(|i| (i % 53 / 20) as u8).collect();
    let mut sampler = match labels {
        true => Sampler::with_labels(settings(), memory, &islands).unwrap(),
        false => Sampler::new(settings(), memory).unwrap(),
    };
    for _ in 0..4 {
        sampler.begin(3 * sampler.pixels() as u64).unwrap();
        work(&mut sampler);
        sampler.end().unwrap();
    }
    resolved(&sampler)
}

fn resolved(sampler: &Sampler<'_>) -> Vec<[f32; 3]> {
    let mut rgb = vec![[0.0; 3]; PIXELS];
    let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(WIDTH, HEIGHT)];
    sampler.resolve(Estimator::Balanced, &mut scratch, rgb.as_flattened_mut()).unwrap();
    rgb
}

fn render(sampler: &mut Sampler<'_>, integrand: &mut dyn Integrand) {
    let (mut batches, mut radiance) = ([Batch8::default(); 5], [Rgb8::default(); 5]);
    let mut work = Workspace::new(&mut batches, &mut radiance).unwrap();
    sampler.jobs().for_each(|mut job| {
        job.render(integrand, &mut work);
    });
}

#[test]
fn closures_references_and_objects_are_integrands() {
    let by_function = picture(false, |sampler| render(sampler, &mut { ramp }));
    let mut calls = 0;
    let by_closure = picture(false, |sampler| {
        render(sampler, &mut |batch: &Batch8| {
            calls += 1;
            ramp(batch)
        });
    });
    let mut boxed: Box<dyn Integrand> = Box::new(ramp);
    assert_eq!(by_function, picture(false, |sampler| render(sampler, &mut *boxed)));
    assert_eq!(by_function, by_closure);
    assert!(calls >= 12 * PIXELS / 8);
}

/// Pieces of the running iteration, and what belongs to each.
fn pieces(sampler: &mut Sampler<'_>, room: usize) -> Vec<(Piece, Vec<[f32; 3]>)> {
    let ([mut x, mut y], [mut index, mut key]) =
        ([vec![0.0; room], vec![0.0; room]], [vec![0; room], vec![0; room]]);
    let (mut first, mut pieces) = (0, vec![]);
    while first < PIXELS {
        let mut wave = Wave { x: &mut x, y: &mut y, index: &mut index, key: &mut key };
        let piece = sampler.plan(first, &mut wave).unwrap();
        let n = piece.samples;
        assert!(y[..n].iter().all(|y| (0.0..HEIGHT as f32).contains(y)));
        pieces.push((piece, flat(&x[..n], &index[..n], &key[..n])));
        first = piece.end;
    }
    pieces
}

#[test]
fn a_wavefront_in_any_pieces_and_any_order_has_the_bits_of_jobs() {
    for labels in [false, true] {
        let jobs = picture(labels, |sampler| render(sampler, &mut { ramp }));
        for room in [40, 41, 1000, 3 * PIXELS] {
            let waves = picture(labels, |sampler| {
                let mut pieces = pieces(sampler, room);
                pieces.reverse();
                let half = pieces.len() / 2;
                pieces.rotate_left(half);
                for (piece, radiance) in pieces {
                    assert_eq!(sampler.deliver(piece, &radiance).unwrap().samples, piece.samples as u64);
                }
            });
            assert_eq!(jobs, waves);
        }
        // All planned at once, handed back in portions of 61 samples, of which a pixel's rest waits for the next one.
        let portions = picture(labels, |sampler| {
            let (whole, radiance) = pieces(sampler, 3 * PIXELS).remove(0);
            let (mut rest, mut delivered, mut parts) = (whole, 0, 0);
            for received in (61..whole.samples).step_by(61).chain([whole.samples]) {
                let (part, next) = sampler.split(rest, received - delivered).unwrap();
                parts += usize::from(part.samples > 0);
                sampler.deliver(part, &radiance[delivered..delivered + part.samples]).unwrap();
                (rest, delivered) = (next, delivered + part.samples);
            }
            assert_eq!((delivered, rest.samples), (whole.samples, 0));
            assert!(parts > whole.samples / 122, "{parts}");
        });
        assert_eq!(jobs, portions);
        let flat_jobs = picture(labels, |sampler| {
            for mut job in sampler.jobs() {
                let ([mut x, mut y], [mut index, mut key]) = ([[0.0; 13]; 2], [[0; 13]; 2]);
                loop {
                    let n = job.plan(&mut Wave { x: &mut x, y: &mut y, index: &mut index, key: &mut key });
                    if n == 0 {
                        break;
                    }
                    let radiance = flat(&x[..n], &index[..n], &key[..n]);
                    let (a, b) = radiance.split_at(n / 2);
                    [a, b].into_iter().for_each(|part| job.deliver(part));
                }
            }
        });
        assert_eq!(jobs, flat_jobs);
    }
}

#[test]
fn misuse_of_a_wavefront_is_refused() {
    picture(false, |sampler| {
        let all = pieces(sampler, 500);
        let (piece, radiance) = &all[1];
        assert_eq!(sampler.deliver(*piece, &radiance[1..]), Err(Error::Piece));
        let wrong = Piece { samples: piece.samples - 1, ..*piece };
        assert_eq!(sampler.deliver(wrong, &radiance[1..]), Err(Error::Piece));
        assert_eq!(sampler.deliver(Piece { end: PIXELS + 1, ..*piece }, radiance), Err(Error::Piece));
        assert_eq!(sampler.deliver(Piece { first: 9, end: 3, samples: 0 }, &[]), Err(Error::Piece));
        assert_eq!(sampler.split(wrong, 9), Err(Error::Piece));
        assert_eq!(sampler.split(*piece, 0).map(|(head, tail)| (head.samples, tail)), Ok((0, *piece)));
        assert_eq!(
            sampler.split(*piece, usize::MAX).map(|(head, tail)| (head, tail.samples)),
            Ok((*piece, 0))
        );
        assert!(sampler.deliver(*piece, radiance).is_ok());
        assert_eq!(sampler.split(*piece, 9), Err(Error::Piece));
        assert_eq!(sampler.deliver(*piece, radiance), Err(Error::Piece));
        let mut wave = Wave { x: &mut [], y: &mut [], index: &mut [], key: &mut [] };
        assert_eq!(sampler.plan(all[2].0.first, &mut wave), Err(Error::Wave));
        assert_eq!(sampler.plan(PIXELS, &mut wave).map(|piece| piece.samples), Ok(0));
        for (piece, radiance) in all.iter().filter(|(other, _)| other != piece) {
            sampler.deliver(*piece, radiance).unwrap();
        }
        sampler.end().unwrap();
        assert_eq!(sampler.plan(0, &mut wave), Err(Error::NotBegun));
        assert_eq!(sampler.deliver(*piece, radiance), Err(Error::NotBegun));
        sampler.begin(9).unwrap();
        render(sampler, &mut { ramp });
    });
}

/// Jobs say where they are: their rectangles hold their samples, and their tiles are all of them, once.
#[test]
fn jobs_know_their_place() {
    picture(false, |sampler| {
        let mut next = 0;
        for mut job in sampler.jobs() {
            assert_eq!(job.tiles().start, next);
            next = job.tiles().end;
            let (columns, rows) = job.bounds();
            let mut batch = [Batch8::default()];
            while job.fill(&mut batch) > 0 {
                let [x, y] = [batch[0].x, batch[0].y].map(|v| v.to_array());
                assert!((0..8).all(|k| columns.contains(&(x[k] as u32)) && rows.contains(&(y[k] as u32))));
                job.accept(&[ramp(&batch[0])]);
            }
        }
        assert_eq!(next, WIDTH.div_ceil(16) * HEIGHT.div_ceil(16));
    });
}

/// A film of two iterations, as bytes.
fn saved(labels: bool) -> Vec<u8> {
    let islands: Vec<u16> = (0..PIXELS).map(|i| (i % 53 / 20) as u16).collect();
    let mut film = match labels {
        true => Film::with_labels(settings(), &islands).unwrap(),
        false => Film::new(settings()).unwrap(),
    };
    for _ in 0..2 {
        film.begin(3 * film.pixels()).unwrap();
        film.render(&mut { ramp }).unwrap();
        film.end().unwrap();
    }
    film.save().unwrap()
}

#[test]
fn a_saved_film_goes_on_as_if_nothing_had_happened() {
    for labels in [false, true] {
        let want = picture(labels, |sampler| render(sampler, &mut { ramp }));
        let mut film = Film::load(&saved(labels)).unwrap();
        assert_eq!(film.save().unwrap(), saved(labels));
        for _ in 0..2 {
            film.resolve(Estimator::Balanced).unwrap(); // looking changes nothing
            film.begin(3 * film.pixels()).unwrap();
            film.render(&mut { ramp }).unwrap();
            film.end().unwrap();
        }
        assert_eq!(film.resolve(Estimator::Balanced).unwrap(), want);
    }
}

#[test]
fn a_film_saved_in_the_middle_of_an_iteration_goes_on_as_if_nothing_had_happened() {
    for labels in [false, true] {
        let want = picture(labels, |sampler| render(sampler, &mut { ramp }));
        let mut bytes = saved(labels);
        for done in [1, 0, 2] {
            let (mut floats, mut words) = (Vec::new(), Vec::new());
            let saved = Saved::new(&bytes).unwrap();
            floats.resize(saved.state().required().floats, 0.0);
            words.resize(saved.state().required().words, 0);
            let mut sampler = saved.restore(Memory { floats: &mut floats, words: &mut words }).unwrap();
            if !sampler.is_running() {
                sampler.begin(3 * sampler.pixels() as u64).unwrap();
            }
            let (mut batches, mut radiance) = ([Batch8::default(); 8], [Rgb8::default(); 8]);
            for mut job in sampler.jobs().take(done) {
                let mut work = Workspace::new(&mut batches, &mut radiance).unwrap();
                job.render(&mut { ramp }, &mut work);
            }
            bytes = vec![0; sampler.saved_len()];
            sampler.save(&mut bytes).unwrap();
        }
        let mut film = Film::load(&bytes).unwrap();
        film.render(&mut { ramp }).unwrap();
        film.end().unwrap();
        film.begin(3 * film.pixels()).unwrap();
        film.render(&mut { ramp }).unwrap();
        film.end().unwrap();
        assert_eq!(film.resolve(Estimator::Balanced).unwrap(), want);
    }
}

#[test]
fn damaged_bytes_are_no_film() {
    for labels in [false, true] {
        let bytes = saved(labels);
        assert!(Saved::new(&bytes).is_ok());
        for length in [0, 7, 15, 16, 100, bytes.len() - 4, bytes.len() - 1] {
            assert_eq!(Saved::new(&bytes[..length]).err(), Some(Error::Saved));
        }
        for at in (0..200).chain([bytes.len() / 2, bytes.len() - 1]) {
            let mut other = bytes.clone();
            other[at] ^= 0x10;
            assert_eq!(Saved::new(&other).err(), Some(Error::Saved), "byte {at}");
        }
        let mut longer = bytes.clone();
        longer.extend([0; 4]);
        assert_eq!(Saved::new(&longer).err(), Some(Error::Saved));
        let (mut floats, mut words) = ([0.0; 9], [0; 9]);
        let memory = Memory { floats: &mut floats, words: &mut words };
        assert_eq!(Saved::new(&bytes).unwrap().restore(memory).err(), Some(Error::Memory));
    }
}

/// A film lives on another thread, its work on others, which outlive the iteration.
#[test]
fn a_film_owns_itself() {
    fn is_free<T: Send + 'static>(_: &T) {}
    let want = picture(false, |sampler| render(sampler, &mut { ramp }));
    let mut film = Film::new(settings()).unwrap();
    is_free(&film);
    assert!(film.plan(0, 99).is_err());
    for _ in 0..4 {
        film.begin(3 * film.pixels()).unwrap();
        let threads: Vec<_> = film
            .plans(700)
            .unwrap()
            .into_iter()
            .map(|plan| std::thread::spawn(move || (plan.piece, flat(&plan.x, &plan.index, &plan.key))))
            .collect();
        for thread in threads.into_iter().rev() {
            let (piece, radiance) = thread.join().unwrap();
            film.deliver(piece, &radiance).unwrap();
        }
        film.end().unwrap();
    }
    let mut film = std::thread::spawn(move || film).join().unwrap();
    assert_eq!(film.resolve(Estimator::Balanced).unwrap(), want);
    let guided = film.guided(&vec![Feature::default(); PIXELS]).unwrap();
    assert_eq!(film.count().unwrap().iter().sum::<u32>(), 12 * PIXELS as u32);
    assert!(film.variance().unwrap().iter().any(|v| *v > 0.0) && film.alpha().unwrap().len() == PIXELS);
    let sum = |rgb: &[[f32; 3]]| rgb.iter().map(|rgb| f64::from(rgb[0])).sum::<f64>();
    assert!((sum(&guided) / sum(&want) - 1.0).abs() < 1e-5);
}

/// Features that are seen sample by sample.
#[test]
fn features_are_means_of_samples() {
    let mut mean = Feature { albedo: [f32::NAN; 3], ..Feature::default() };
    for (i, depth) in [2.0, 4.0, 9.0].into_iter().enumerate() {
        let sample = Feature { albedo: [depth, 1.0, 0.0], normal: [0.0, f32::NAN, 1.0], depth };
        mean = if i == 0 { Feature::default() } else { mean };
        mean.add(&sample, i as u32);
    }
    assert!((mean.depth - 5.0).abs() < 1e-6 && (mean.albedo[0] - 5.0).abs() < 1e-6);
    assert_eq!(mean.normal, [0.0, 0.0, 1.0]);
}
