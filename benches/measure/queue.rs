//! A farm, event by event: workers that start, render, send and merge, and a storage that serves whoever comes first.
//!
//! Time is counted in whole nanoseconds, so that events have one order, and the same farm has the same history every time.
//! A transfer takes as long as the worker's network needs, and occupies the storage for as long as that needs, after all
//! transfers that were asked for before. No machine fails.

use pmcip_core::maths::sobol::hash;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Workers and what is between them.
#[derive(Clone, Copy, Debug)]
pub struct Farm {
    /// How many.
    pub workers: usize,
    /// Seconds before a task does anything.
    pub start: f64,
    /// Bytes a second of a worker's network.
    pub network: f64,
    /// Bytes a second of the storage, all workers together.
    pub storage: f64,
}

/// Frames as independent tasks.
#[derive(Clone, Copy, Debug)]
pub struct Frames {
    /// How many.
    pub count: usize,
    /// Frames of a task.
    pub chunk: usize,
    /// Mean time of a frame; from one to the next it is anything from half to one and a half of that.
    pub seconds: f64,
    /// Bytes of its files.
    pub bytes: f64,
}

/// One frame as films of different seeds, and their merging.
#[derive(Clone, Copy, Debug)]
pub struct Seeds {
    /// Time of all samples. Workers take up to 5 % more or less for their part.
    pub seconds: f64,
    /// Bytes of a film.
    pub film: f64,
    /// Seconds to merge one.
    pub merge: f64,
    /// Seconds to write what was merged.
    pub write: f64,
    /// Films that one merge takes.
    pub fan: usize,
}

/// What became of a render.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Time that was spent on samples, by all workers together.
    pub useful: f64,
    /// Until the last file is there.
    pub seconds: f64,
    /// To and from the storage.
    pub bytes: f64,
}

impl Outcome {
    /// The part of the workers' time that was useful.
    pub fn efficiency(&self, workers: usize) -> f64 {
        self.useful / (workers as f64 * self.seconds)
    }

    /// Seconds in which a worker made no samples, on average.
    pub fn waited(&self, workers: usize) -> f64 {
        self.seconds - self.useful / workers as f64
    }
}

/// Evenly from 0 to 1, by a number.
fn unit(i: usize) -> f64 {
    f64::from(hash(i as u32 + 1)) / 4_294_967_296.0
}

fn nanoseconds(seconds: f64) -> u64 {
    (1e9 * seconds).round() as u64
}

/// What happens when; the storage, and what it has served.
struct Clock<E> {
    farm: Farm,
    events: BinaryHeap<Reverse<(u64, E)>>,
    now: u64,
    storage_free: u64,
    outcome: Outcome,
}

impl<E: Ord> Clock<E> {
    fn new(farm: &Farm) -> Self {
        let outcome = Outcome::default();
        Clock { farm: *farm, events: BinaryHeap::new(), now: 0, storage_free: 0, outcome }
    }

    fn at(&mut self, time: u64, event: E) {
        self.events.push(Reverse((time, event)));
    }

    /// After so many seconds.
    fn after(&mut self, seconds: f64, event: E) {
        self.at(self.now + nanoseconds(seconds), event);
    }

    fn next(&mut self) -> Option<E> {
        let Reverse((now, event)) = self.events.pop()?;
        self.now = now;
        self.outcome.seconds = now as f64 / 1e9;
        Some(event)
    }

    /// When a transfer that is asked for now is over.
    fn transfer(&mut self, bytes: f64) -> u64 {
        self.outcome.bytes += bytes;
        self.storage_free = self.storage_free.max(self.now) + nanoseconds(bytes / self.farm.storage);
        self.storage_free.max(self.now + nanoseconds(bytes / self.farm.network))
    }
}

impl Frames {
    /// Renders them all: whoever is free takes the next task.
    pub fn simulate(&self, farm: &Farm) -> Outcome {
        let length = |frame: usize| self.seconds * (0.5 + unit(frame));
        // At a worker's event this frame has been rendered, or none yet: then it is free.
        let mut clock = Clock::new(farm);
        (0..farm.workers).for_each(|worker| clock.at(0, (worker, None)));
        let mut next = 0;
        while let Some((worker, done)) = clock.next() {
            let follower = match done {
                None => {
                    let first = next;
                    next = (next + self.chunk).min(self.count);
                    (first < self.count).then(|| (clock.now + nanoseconds(farm.start), first))
                }
                Some(frame) => {
                    let sent = clock.transfer(self.bytes);
                    let is_last = (frame + 1) % self.chunk == 0 || frame + 1 == self.count;
                    if is_last {
                        clock.at(sent, (worker, None));
                    }
                    (!is_last).then_some((sent, frame + 1))
                }
            };
            if let Some((from, frame)) = follower {
                clock.outcome.useful += length(frame);
                clock.at(from + nanoseconds(length(frame)), (worker, Some(frame)));
            }
        }
        clock.outcome
    }
}

/// What happens to a film: number `.1` of those that took `.0` rounds of merging.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Event {
    /// It has been made.
    Made(usize, usize),
    /// It lies in the storage.
    Sent(usize, usize),
    /// So many of the films that it is made of are in it.
    Merged(usize, usize, usize),
}

impl Seeds {
    /// Renders a film a worker and merges them, each merge as soon as all of its films are there.
    pub fn simulate(&self, farm: &Farm) -> Outcome {
        let mut clock = Clock::new(farm);
        for worker in 0..farm.workers {
            let length = self.seconds / farm.workers as f64 * (0.95 + 0.1 * unit(worker));
            clock.outcome.useful += length;
            clock.after(farm.start + length, Event::Made(0, worker));
        }
        // Films that each round of merging has, and those that the merges still wait for.
        let rounds: Vec<usize> =
            std::iter::successors(Some(farm.workers), |n| (*n > 1).then(|| n.div_ceil(self.fan))).collect();
        let parts = |round: usize, film: usize| (rounds[round - 1] - film * self.fan).min(self.fan);
        let mut awaited: Vec<Vec<usize>> = (1..rounds.len())
            .map(|round| (0..rounds[round]).map(|film| parts(round, film)).collect())
            .collect();
        while let Some(event) = clock.next() {
            match event {
                Event::Made(round, film) => {
                    let sent = clock.transfer(self.film);
                    clock.at(sent, Event::Sent(round, film));
                }
                Event::Sent(round, film) if round + 1 < rounds.len() => {
                    let whole = film / self.fan;
                    let left = &mut awaited[round][whole];
                    *left -= 1;
                    if *left == 0 {
                        clock.after(farm.start, Event::Merged(round + 1, whole, 0));
                    }
                }
                Event::Sent(..) => {}
                Event::Merged(round, film, count) if count < parts(round, film) => {
                    let read = clock.transfer(self.film);
                    clock.at(read + nanoseconds(self.merge), Event::Merged(round, film, count + 1));
                }
                Event::Merged(round, film, _) => clock.after(self.write, Event::Made(round, film)),
            }
        }
        clock.outcome
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FARM: Farm = Farm { workers: 1, start: 2.0, network: 10.0, storage: 40.0 };

    #[test]
    fn one_worker_does_one_thing_after_the_other() {
        let frames = Frames { count: 5, chunk: 2, seconds: 8.0, bytes: 30.0 };
        let outcome = frames.simulate(&FARM);
        // Three tasks, five files of three seconds.
        assert!((outcome.seconds - outcome.useful - 3.0 * 2.0 - 5.0 * 3.0).abs() < 1e-6, "{outcome:?}");
        assert_eq!(outcome.bytes, 150.0);
        let seeds = Seeds { seconds: 8.0, film: 30.0, merge: 1.0, write: 1.0, fan: 4 };
        let outcome = seeds.simulate(&FARM);
        assert!((outcome.seconds - outcome.useful - 5.0).abs() < 1e-6, "nothing is merged: {outcome:?}");
    }

    #[test]
    fn a_tree_merges_every_film_once() {
        let farm = Farm { workers: 37, ..FARM };
        let seeds = |fan: usize| Seeds { seconds: 37.0, film: 30.0, merge: 1.0, write: 1.0, fan };
        // 37 films are sent and read, then 10, 3 and 1; the last is sent alone.
        assert_eq!(seeds(4).simulate(&farm).bytes, 30.0 * (2.0 * (37.0 + 10.0 + 3.0) + 1.0));
        let by_one = seeds(usize::MAX).simulate(&farm);
        assert_eq!(by_one.bytes, 30.0 * (2.0 * 37.0 + 1.0));
        // After the last film is there: a start, 37 films of 3 + 1 seconds, writing and sending.
        let merging = 2.0 + 37.0 * 4.0 + 1.0 + 3.0;
        // All films want to be sent at about the same time, and the storage takes 0.75 s for each.
        assert!((by_one.seconds - merging - (2.0 + 1.0 + 37.0 * 0.75)).abs() < 3.0, "{by_one:?}");
        assert!(seeds(4).simulate(&farm).seconds < by_one.seconds);
    }

    #[test]
    fn a_slow_storage_is_the_limit() {
        let farm = Farm { workers: 1000, start: 0.0, network: 1e9, storage: 100.0 };
        let frames = Frames { count: 4000, chunk: 1, seconds: 1.0, bytes: 10.0 };
        let outcome = frames.simulate(&farm);
        assert!((outcome.seconds - 400.0).abs() < 2.0, "{outcome:?}");
    }
}
