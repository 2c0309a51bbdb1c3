//! Shoots the photon maps of a frame with all the processor's threads.
//!
//! Photon paths are shot in parts of fixed size, which any thread may take; what they leave is put together in the
//! order of the parts, so the maps have the same bits for any number of threads. Memory: about 400
//! bytes a photon path while they are shot, a third of that afterwards.

use super::memory::lock;
use crate::error::Error;
use pmcip_core::tracer::photon::{self, Irradiance, Leaf, Photon, STRIDE, Site, Split, Tree};
use pmcip_core::tracer::scene::Scene;
use pmcip_core::tracer::shade::gather::Maps;
use pmcip_core::tracer::shade::path::Packet;
use pmcip_core::tracer::shade::shoot::{Map, Shooter, Shots, caustic_paths};
use rayon::ThreadPool;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Photon paths a thread follows at once, at most.
const PART: usize = 4096;

/// Photons that a part may leave, if it need not be smaller than eight paths for that.
const PART_PHOTONS: usize = 1 << 15;

/// The pilot that finds out how many paths become caustic has this part of the photons asked for.
const PILOT: u32 = 16;

/// Points whose irradiance a thread estimates at once.
const POINTS: usize = 1024;

/// What the maps of a frame depend on, besides the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order {
    /// Photon paths of the global map. The caustic map gets about half as many photons, if there are caustics.
    pub photons: u32,
    /// Longest path in segments, from the eye to the light.
    pub max_depth: u32,
    /// Random seed.
    pub seed: u32,
    /// Number of the frame.
    pub frame: u32,
}

/// The photon maps of a frame.
#[derive(Debug)]
pub struct Photons {
    irradiance: Grown<Irradiance>,
    caustic: Grown<Photon>,
    shot: Shot,
}

/// What was shot, and how long it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// Photons in the global map.
    pub global: usize,
    /// Photons in the caustic map.
    pub caustic: usize,
    /// Wall time of shooting photons, building trees and estimating irradiance.
    pub seconds: f64,
}

impl Photons {
    /// Shoots photons and builds the maps, on the threads of `pool`, or on the caller's alone without one.
    ///
    /// # Errors
    /// [`Error::Work`] if there are too many photons for one map.
    pub fn shoot(scene: Scene<'_>, order: &Order, pool: Option<&ThreadPool>) -> Result<Photons, Error> {
        let start = Instant::now();
        let shots = |map, paths| Shots { map, paths, seed: order.seed, frame: order.frame };
        let all = |map, paths| shoot(scene, order.max_depth, &shots(map, paths), paths, pool);
        let pilot = (order.photons / PILOT).max(1);
        let found = all(Map::Caustic, pilot).len();
        let caustic = match found {
            0 => Vec::new(),
            found => all(Map::Caustic, caustic_paths(order.photons / 2, pilot, found)),
        };
        let global = all(Map::Global, order.photons);
        let points = global.iter().step_by(STRIDE).map(point).collect();
        let (global, points) = (Grown::new(global)?, Grown::new(points)?);
        let mut irradiance = points;
        let tree = global.tree()?;
        let estimate = |points: &mut [Irradiance]| photon::estimate(&tree, points);
        match pool {
            Some(pool) => pool.install(|| irradiance.sites.par_chunks_mut(POINTS).for_each(estimate)),
            None => irradiance.sites.chunks_mut(POINTS).for_each(estimate),
        }
        let caustic = Grown::new(caustic)?;
        let (global, found) = (global.sites.len(), caustic.sites.len());
        let shot = Shot { global, caustic: found, seconds: start.elapsed().as_secs_f64() };
        Ok(Photons { irradiance, caustic, shot })
    }

    /// The maps, borrowed and checked.
    ///
    /// # Errors
    /// None for maps that [`shoot`](Self::shoot) has made.
    pub fn maps(&self) -> Result<Maps<'_>, Error> {
        Ok(Maps { irradiance: self.irradiance.tree()?, caustic: self.caustic.tree()? })
    }

    /// What was shot.
    pub fn shot(&self) -> Shot {
        self.shot
    }
}

/// The photons that all paths of `shots` leave.
fn shoot(
    scene: Scene<'_>,
    max_depth: u32,
    shots: &Shots,
    paths: u32,
    pool: Option<&ThreadPool>,
) -> Vec<Photon> {
    let each = Shooter::most(shots.map, 1, max_depth);
    let part = (PART_PHOTONS / each.max(1)).clamp(8, PART) / 8 * 8;
    let (next, left) = (AtomicU32::new(0), Mutex::new(Vec::new()));
    let work = || {
        let mut packets = vec![Packet::default(); Shooter::required(part)];
        let mut out = vec![Photon::default(); Shooter::most(shots.map, part, max_depth)];
        let mut shooter = Shooter::new(scene, max_depth, &mut packets);
        loop {
            let first = next.fetch_add(1, Ordering::Relaxed) * part as u32;
            if first >= paths {
                break;
            }
            let used = shooter.shoot(shots, first, (paths - first).min(part as u32), &mut out);
            lock(&left).push((first, out[..used].to_vec()));
        }
    };
    match pool {
        Some(pool) => drop(pool.broadcast(|_| work())),
        None => work(),
    }
    let mut left = left.into_inner().unwrap_or_else(PoisonError::into_inner);
    left.sort_unstable_by_key(|part| part.0);
    left.into_iter().flat_map(|part| part.1).collect()
}

/// Where a photon has landed.
fn point(photon: &Photon) -> Irradiance {
    Irradiance { position: photon.position, normal: photon.normal, ..Irradiance::default() }
}

/// A tree and its records.
#[derive(Debug)]
struct Grown<T> {
    sites: Vec<T>,
    splits: Vec<Split>,
    leaves: Vec<Leaf>,
}

impl<T: Site> Grown<T> {
    fn new(mut sites: Vec<T>) -> Result<Self, Error> {
        let count = photon::leaves(sites.len());
        let (mut splits, mut leaves) = (vec![Split::default(); count - 1], vec![Leaf::default(); count]);
        photon::build(&mut sites, &mut splits, &mut leaves).map_err(Error::work)?;
        Ok(Grown { sites, splits, leaves })
    }

    fn tree(&self) -> Result<Tree<'_, T>, Error> {
        Tree::new(&self.sites, &self.splits, &self.leaves).map_err(Error::work)
    }
}
