//! Photon mapping: final gathering over a map of irradiance, caustics straight from theirs.
//!
//! The second pass of photon mapping (Jensen 2001), after [`shoot`](super::shoot). At the first rough surface that
//! an eye path meets, through mirrors and glass or not, light is put together from
//!
//! * lamps, by next-event estimation with multiple importance sampling, as in [`path`];
//! * caustics: the density of the nearest photons of the caustic map, each through the scattering function;
//! * the rest, by one *gather ray* drawn from the scattering function. Where it meets a surface, the irradiance
//!   that was computed beforehand for the nearest of the points there (Christensen, *Faster Photon Map Global
//!   Illumination*, JGT 4(3), 1999) is reflected by the surface's diffuse part, and the path ends; its gloss, if it
//!   has any, is followed on.
//!
//! Where the map is no help, the surface is treated like the first one, with lamps, caustics and a gather ray of
//! its own: if the gather ray is shorter than the radius of the estimate (in corners, where the estimate's blur
//! would show), and if there is no point near (in the dark).
//!
//! **Bias.** The method is consistent, not unbiased: its bias goes away as photons grow, not as samples do. An
//! estimate averages over a disc, so light is smeared over its radius (caustics look softer than they are) and
//! darkened where the surface ends within it. Over a picture this costs `cornell` 0.8 % of its energy with 50,000
//! photon paths, 0.4 % with 200,000 and 0.2 % with 800,000. The number of photons in an estimate is fixed, so
//! that its noise, about 15 %, stays while its disc shrinks: gather rays average over many, but a caustic shows it as
//! mottle that gets finer, not fainter, with more photons.
//! One map serves all samples of a frame: its noise does not average out, and no sampler sees it. A narrow lobe
//! that reflects a caustic finds few photons to see it by; there the picture is uneven.

use super::direct::arrive;
use super::hit::SurfacePoints;
use super::path::{self, PathTracer, Traffic, Wavefront};
use super::queue::{Packet, Paths};
use super::rough::Rough;
use super::shadow::accumulate;
use super::shoot::survive;
use super::vertex::{self, Frame, ROULETTE_DEPTH, SETS, scatter_specular, survivors};
use crate::maths::sobol;
use crate::maths::vec3::{self, Vec3x8};
use crate::sampler::batch::{Batch8, Integrand, Rgb8};
use crate::tracer::camera::Camera;
use crate::tracer::photon::{Irradiance, Neighbours, Photon, Query, Tree};
use crate::tracer::scene::{Scattering, Scene};
use core::f32::consts::FRAC_1_PI;
use wide::f32x8;

/// Photons that a caustic is averaged over.
const NEIGHBOURS: usize = 64;

/// Points of known irradiance are looked for within this many times their even spacing.
const LOOK_UP_REACH: f32 = 8.0;

/// The trees of a frame.
#[derive(Clone, Copy, Debug)]
pub struct Maps<'a> {
    /// Points whose irradiance [`estimate`](crate::tracer::photon::estimate) has computed from the global map.
    pub irradiance: Tree<'a, Irradiance>,
    /// The caustic map.
    pub caustic: Tree<'a, Photon>,
}

/// The photon-mapping integrator. Implements [`Integrand`].
pub struct Gather<'a> {
    /// Traces, aims at lights and holds the queues.
    paths: PathTracer<'a>,
    maps: Maps<'a>,
    found: Neighbours<NEIGHBOURS>,
}

impl<'a> Gather<'a> {
    /// Photon mapping in `scene` seen through `camera`, with maps shot for the same `max_depth`.
    ///
    /// Paths from the eye have up to `max_depth` segments. With those of the photons they end on they usually have as
    /// many in all; more where the eye's part had more than two (through mirrors and glass, after gloss, in corners).
    ///
    /// `memory` is scratch: [`PathTracer::required`] says how much, and what happens with less.
    pub fn new(
        scene: Scene<'a>,
        camera: Camera,
        max_depth: u32,
        maps: Maps<'a>,
        memory: &'a mut [Packet],
    ) -> Self {
        let paths = PathTracer::new(scene, camera, max_depth, memory);
        Gather { paths, maps, found: Neighbours::default() }
    }

    /// What has been traced so far, without the photons.
    pub fn traffic(&self) -> Traffic {
        self.paths.traffic()
    }

    /// Adds the light that `surface` reflects diffusely, where the map knows it, and takes the diffuse part away.
    /// Returns the lanes in which it did.
    fn look_up(
        &self,
        paths: &Paths,
        surface: &mut SurfacePoints,
        lanes: f32x8,
        radiance: &mut [Rgb8],
    ) -> f32x8 {
        let map = &self.maps.irradiance;
        let radius = LOOK_UP_REACH * map.spacing();
        let points = Points::new(surface);
        let length = (surface.position - paths.origin).length().to_array();
        let (mut value, mut known) = ([[0.0f32; 8]; 3], [0.0f32; 8]);
        let mut wanted = (lanes & surface.diffuse.max_component().simd_gt(f32x8::ZERO)).to_bitmask();
        while wanted != 0 {
            let lane = wanted.trailing_zeros() as usize & 7;
            wanted &= wanted - 1;
            let Some((index, distance2)) = map.nearest(&points.query(lane, radius)) else { continue };
            let point = &map.sites()[index];
            if distance2 < point.radius * point.radius && length[lane] > point.radius {
                known[lane] = 1.0;
                for (row, irradiance) in value.iter_mut().zip(point.value) {
                    row[lane] = irradiance * FRAC_1_PI;
                }
            }
        }
        let known = f32x8::from(known).simd_gt(f32x8::ZERO);
        let value = Vec3x8::new(value[0].into(), value[1].into(), value[2].into());
        let value = paths.throughput.scaled(surface.diffuse).scaled(value);
        accumulate(radiance, paths.slot, value, known.to_bitmask());
        surface.diffuse = Vec3x8::select(known, Vec3x8::default(), surface.diffuse);
        known
    }

    /// Adds the light of the caustic map in the lanes of `rough`.
    fn add_caustics(&mut self, paths: &Paths, surface: &SurfacePoints, rough: f32x8, radiance: &mut [Rgb8]) {
        let map = self.maps.caustic;
        if map.sites().is_empty() {
            return;
        }
        let radius = map.spacing() * libm::sqrtf(NEIGHBOURS as f32);
        let points = Points::new(surface);
        let frame = Frame::new(surface.normal);
        let bsdf = Rough::new(surface, frame.to_local(-paths.direction));
        let mut value = [[0.0f32; 8]; 3];
        let wanted = (rough & reflectance(surface).simd_gt(f32x8::ZERO)).to_bitmask();
        let mut lit = 0;
        for lane in (0..8).filter(|lane| wanted >> lane & 1 == 1) {
            map.k_nearest(&points.query(lane, radius), &mut self.found);
            if self.found.entries().is_empty() {
                continue;
            }
            lit |= 1 << lane;
            let sum = reflect(&map, &self.found, &frame.lane(lane), &bsdf.lane(lane));
            for (row, sum) in value.iter_mut().zip(sum) {
                row[lane] = sum;
            }
        }
        let value = Vec3x8::new(value[0].into(), value[1].into(), value[2].into());
        accumulate(radiance, paths.slot, paths.throughput.scaled(value), lit);
    }
}

/// The paths as they see lamps. Those that come from a rough surface through mirrors and glass, which a density of
/// zero marks, do not: that light is in the caustic map.
#[inline(always)]
fn seeing(paths: &Paths) -> Paths {
    let blind = paths.density.simd_eq(f32x8::ZERO);
    let throughput = Vec3x8::select(blind, Vec3x8::default(), paths.throughput);
    Paths { throughput, density: blind.select(f32x8::splat(f32::INFINITY), paths.density), ..*paths }
}

/// Ends paths in the lanes of `gloss` by chance, where little is left to follow after a look-up, before the roulette
/// of all paths begins; returns those that go on.
fn thin_out(next: &mut Paths, before: &Paths, gloss: f32x8, depth: u32) -> f32x8 {
    if depth >= ROULETTE_DEPTH || !gloss.any() {
        return gloss;
    }
    let mut thinned = *next;
    let stays = survive(&mut thinned, before, depth);
    next.throughput = Vec3x8::select(gloss, thinned.throughput, next.throughput);
    gloss & stays
}

/// Radiance that one point reflects of the photons `found` around it.
fn reflect<const K: usize>(
    map: &Tree<'_, Photon>,
    found: &Neighbours<K>,
    frame: &Frame,
    bsdf: &Rough,
) -> [f32; 3] {
    let mut sum = Vec3x8::default();
    for entries in found.entries().chunks(8) {
        let mut rows = [[0.0f32; 8]; 6];
        for (lane, (distance2, index)) in entries.iter().enumerate() {
            let photon = &map.sites()[*index as usize];
            let power = vec3::scale(photon.power, found.kernel(*distance2));
            for axis in 0..3 {
                rows[axis][lane & 7] = photon.from[axis];
                rows[axis + 3][lane & 7] = power[axis];
            }
        }
        let [x, y, z, r, g, b] = rows.map(f32x8::from);
        let incoming = frame.to_local(Vec3x8::new(x, y, z));
        // The photons' density contains the cosine already.
        let cosine = incoming.z.fast_max(f32x8::splat(1e-4));
        let (value, _) = bsdf.evaluate(incoming);
        sum = sum + value.scaled(Vec3x8::new(r, g, b)) * (f32x8::ONE / cosine);
    }
    [sum.x, sum.y, sum.z].map(|channel| channel.to_array().iter().sum())
}

/// Largest part of the light that a rough surface could reflect.
fn reflectance(surface: &SurfacePoints) -> f32x8 {
    surface.diffuse.max_component().fast_max(surface.specular.max_component())
}

/// Positions and normals of eight surface points by lane.
struct Points {
    position: [[f32; 8]; 3],
    normal: [[f32; 8]; 3],
}

impl Points {
    fn new(surface: &SurfacePoints) -> Self {
        let rows = |v: Vec3x8| [v.x.to_array(), v.y.to_array(), v.z.to_array()];
        Points { position: rows(surface.position), normal: rows(surface.facing) }
    }

    fn query(&self, lane: usize, radius: f32) -> Query {
        let at = |rows: &[[f32; 8]; 3]| [0, 1, 2].map(|axis| rows[axis][lane & 7]);
        Query { position: at(&self.position), normal: at(&self.normal), radius }
    }
}

impl<'a> Wavefront<'a> for Gather<'a> {
    fn paths(&mut self) -> &mut PathTracer<'a> {
        &mut self.paths
    }

    /// Takes one packet through one segment.
    fn bounce(&mut self, paths: &Paths, depth: u32, radiance: &mut [Rgb8]) {
        let order = (depth, paths.chance(depth));
        let Some(mut surface) = arrive(&mut self.paths, &seeing(paths), order, radiance) else { return };
        if depth >= self.paths.max_depth {
            return;
        }
        let mut next = *paths;
        let mut rough = surface.scatters(Scattering::Rough);
        let specular = surface.hit & !rough;
        // The eye's own segments come with infinite density, gather rays do not.
        let gathering = paths.density.simd_lt(f32x8::splat(f32::INFINITY));
        let mut known = f32x8::ZERO;
        if (rough & gathering).any() {
            known = self.look_up(paths, &mut surface, rough & gathering, radiance);
            rough &= reflectance(&surface).simd_gt(f32x8::ZERO);
        }
        if rough.any() {
            self.add_caustics(paths, &surface, rough, radiance);
            self.paths.scatter_rough(&mut next, &surface, rough, depth, radiance);
        }
        if specular.any() {
            let (choice, _) = sobol::point(paths.index, paths.key, SETS * depth);
            scatter_specular(&mut next, &surface, choice);
            next.density = (specular & gathering).select(f32x8::ZERO, next.density);
        }
        // First: the roulettes leave what is not a number where they end a path.
        vertex::reject_nan(&next, rough | specular, radiance);
        rough &= !known | thin_out(&mut next, paths, rough & known, depth);
        let alive = survivors(&mut next, rough | specular, depth);
        next.origin = surface.leave(next.direction);
        self.paths.queue.push(&next, alive.to_bitmask());
    }
}

impl Integrand for Gather<'_> {
    fn radiance(&mut self, batch: &Batch8) -> Rgb8 {
        path::radiance(self, batch)
    }

    fn stream(&mut self, batches: &[Batch8], radiance: &mut [Rgb8]) {
        path::stream(self, batches, radiance);
    }
}
