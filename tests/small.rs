//! Small machines: films in little memory, small types, little stack.

use pmcip_core::sampler::batch::{Batch8, Rgb8};
use pmcip_core::sampler::estimate::Estimator;
use pmcip_core::sampler::guide::{Feature, Filter};
use pmcip_core::sampler::state::State;
use pmcip_core::sampler::{Job, Jobs, Memory, Sampler, Settings, Workspace};

/// A film of 38 × 38 pixels lives in 64 KiB.
#[test]
fn a_film_lives_in_64_kib() {
    let mut memory = [0u32; 64 * 1024 / 4];
    let required = Sampler::required(38, 38);
    assert!(required.floats + required.words <= memory.len());
    let (floats, words) = memory.split_at_mut(required.floats);
    let memory = Memory { floats: bytemuck::cast_slice_mut(floats), words };
    let mut sampler = Sampler::new(Settings::new(38, 38), memory).unwrap();
    sampler.begin(2 * 38 * 38).unwrap();
    assert_eq!(sampler.jobs().map(|job| job.samples()).sum::<u64>(), 2 * 38 * 38);
}

/// Bytes of what a host stores, on 64-bit machines; stated so that nobody makes them larger unnoticed.
#[test]
#[cfg(target_pointer_width = "64")]
fn types_are_small() {
    assert!(size_of::<Sampler<'_>>() <= 512, "{}", size_of::<Sampler<'_>>());
    assert!(size_of::<State>() <= 192, "{}", size_of::<State>());
    assert!(size_of::<Jobs<'_>>() <= 512, "{}", size_of::<Jobs<'_>>());
    assert!(size_of::<Job<'_>>() <= 2304, "{}", size_of::<Job<'_>>());
    assert_eq!(size_of::<Batch8>(), 160);
    assert_eq!(size_of::<Rgb8>(), 96);
    assert_eq!((size_of::<Settings>(), size_of::<Feature>()), (48, 28));
}

/// Runs on a thread of so much stack; more would end the process.
fn on_stack(bytes: usize, work: impl FnOnce() + Send + 'static) {
    std::thread::Builder::new().stack_size(bytes).spawn(work).unwrap().join().unwrap();
}

/// What `embedding` says of stacks, and a quarter more for the thread's own beginning.
#[test]
fn stacks_are_small() {
    let required = Sampler::required(64, 40);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    let mut scratch = vec![[0.0; 16]; Sampler::resolve_scratch(64, 40)];
    let mut wide = vec![0.0; Filter::required(64, 40)];
    let (mut batches, mut radiance) = (vec![Batch8::default(); 9], vec![Rgb8::default(); 9]);
    let mut rgb = vec![0.0; 3 * 64 * 40];
    on_stack(40 * 1024, move || {
        let memory = Memory { floats: &mut floats, words: &mut words };
        let mut sampler = Sampler::new(Settings::new(64, 40), memory).unwrap();
        let mut work = Workspace::new(&mut batches, &mut radiance).unwrap();
        for _ in 0..3 {
            sampler.begin(2 * 64 * 40).unwrap();
            for mut job in sampler.jobs() {
                job.render(
                    &mut |batch: &Batch8| Rgb8 { r: batch.x, g: batch.point(1).0, b: batch.y },
                    &mut work,
                );
            }
            sampler.end().unwrap();
        }
        sampler.resolve(Estimator::Balanced, &mut scratch, &mut rgb).unwrap();
        let (state, floats, words) = (sampler.state(), floats, words);
        on_stack(80 * 1024, move || {
            let (mut floats, mut words) = (floats, words);
            let memory = Memory { floats: &mut floats, words: &mut words };
            let sampler = Sampler::resume(state, memory).unwrap();
            let mut filter = Filter::new(&sampler, &[], &mut wide).unwrap();
            filter.bands().for_each(|mut band| band.filter());
        });
    });
}
