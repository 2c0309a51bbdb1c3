//! Photons from the lights: the first pass of photon mapping (Jensen, *Realistic Image Synthesis Using Photon
//! Mapping*, 2001).
//!
//! A photon path starts at a point of a light, picked by power, in a direction of cosine density, and is scattered
//! like a path from the eye. One from the sky starts at a disc outside of the scene, as wide as what it is aimed at: all of
//! the scene, or the mirrors and glass in it. Two maps keep what arrives at rough surfaces: the *global* map everything, the
//! *caustic* map only what came through mirrors and glass alone. By chance a photon is absorbed rather than scattered,
//! so that those that go on keep about their power.
//!
//! Photons carry flux, paths from the eye radiance: refraction does not squeeze flux (Veach 1997, section 5.2), and
//! shading normals weigh the other way round (section 5.3).
//!
//! Path number i is always the same (it has its own Sobol sets, keyed by seed and frame), so paths may be shot in
//! parts, anywhere. Caustic paths that miss the box around all mirrors and glass are not even traced.

use super::cutout;
use super::hit::SurfacePoints;
use super::queue::{Packet, Paths, Queue};
use super::rough::Rough;
use super::source::{Bounds, Source};
use super::vertex::{Frame, SETS, scatter_specular};
use crate::maths::sobol;
use crate::maths::vec3::Vec3x8;
use crate::tracer::photon::Photon;
use crate::tracer::scene::{Scattering, Scene};
use crate::tracer::trace::Tracer;
use wide::{f32x8, u32x8};

/// What a map keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Map {
    /// All light on surfaces with a diffuse part.
    Global,
    /// Light that came from the lights through mirrors and glass only, on rough surfaces.
    Caustic,
}

/// Photon paths of one map of one frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shots {
    /// What is kept.
    pub map: Map,
    /// Paths in all; each carries this part of the lights' power. At least 1.
    pub paths: u32,
    /// Random seed.
    pub seed: u32,
    /// Number of the frame.
    pub frame: u32,
}

/// Shoots photons into a scene.
pub struct Shooter<'a> {
    tracer: Tracer<'a>,
    queue: Queue<'a>,
    max_depth: u32,
    /// Around all that there is.
    all: Option<Bounds>,
    specular: Option<Bounds>,
}

impl<'a> Shooter<'a> {
    /// Packets of memory needed to follow `paths` paths at once.
    pub const fn required(paths: usize) -> usize {
        Queue::required(paths)
    }

    /// Photons that `paths` paths can leave in `map` at most.
    pub const fn most(map: Map, paths: usize, max_depth: u32) -> usize {
        paths.saturating_mul(segments(map, max_depth) as usize)
    }

    /// A shooter whose photons complete eye paths of up to `max_depth` segments in all; that counts one segment from
    /// the eye for the caustic map and two for the global one.
    ///
    /// `memory` is scratch: [`required`](Self::required) says how much.
    pub fn new(scene: Scene<'a>, max_depth: u32, memory: &'a mut [Packet]) -> Self {
        Shooter {
            all: Bounds::of(&scene, |_| true),
            specular: Bounds::of(&scene, |scattering| scattering != Scattering::Rough),
            tracer: Tracer::new(scene),
            queue: Queue::new(memory, &scene),
            max_depth,
        }
    }

    /// Shoots `count` of the paths from number `first` on. Returns how many photons it wrote to the front of `out`.
    ///
    /// With less memory than [`required`](Self::required) or a shorter `out` than [`most`](Self::most) asks for,
    /// the paths that do not fit are not shot.
    pub fn shoot(&mut self, shots: &Shots, first: u32, count: u32, out: &mut [Photon]) -> usize {
        let segments = segments(shots.map, self.max_depth);
        let lit = self.tracer.scene().is_lit();
        let target = match shots.map {
            Map::Global => self.all,
            Map::Caustic => self.specular,
        };
        let (Some(target), Some(all), true) = (target, self.all, lit && segments > 0) else { return 0 };
        let source = Source::new(self.tracer.scene(), target, all);
        let room = (8 * self.queue.capacity()).min(out.len() / segments as usize) / 8 * 8;
        let count = (count as usize).min(room) as u32;
        self.start(&source, shots, first, count);
        let mut used = 0;
        for depth in 1..=segments {
            for i in 0..self.queue.len() {
                let paths = self.queue.packet(i);
                used += self.bounce(shots.map, &paths, depth, depth == segments, &mut out[used..]);
            }
            self.queue.turn();
        }
        used
    }

    /// Fills the queue with `count` emitted photons.
    fn start(&mut self, source: &Source, shots: &Shots, first: u32, count: u32) {
        self.queue.clear();
        let frame = sobol::frame_key(shots.seed, shots.frame);
        let key = u32x8::splat(sobol::hash(frame ^ (shots.map as u32) << 16 ^ KEY));
        for start in (0..count).step_by(8) {
            let lane = u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
            let index = u32x8::splat(first.wrapping_add(start)) + lane;
            let paths = source.emit(self.tracer.scene(), shots.paths, index, key);
            let mut wanted = (1u32 << (count - start).min(8)) - 1;
            wanted &= paths.throughput.max_component().simd_gt(f32x8::ZERO).to_bitmask();
            if let (Map::Caustic, Some(bounds)) = (shots.map, &self.specular) {
                wanted &= bounds.meets(&paths);
            }
            self.queue.push(&paths, wanted);
        }
        self.queue.turn();
    }

    /// Takes one packet through one segment; returns how many photons it has written.
    fn bounce(&mut self, map: Map, paths: &Paths, depth: u32, is_last: bool, out: &mut [Photon]) -> usize {
        let rays = paths.rays(self.tracer.scene());
        let hits = cutout::closest(&mut self.tracer, &rays, paths.chance(depth));
        if !hits.any() {
            return 0;
        }
        let surface = SurfacePoints::at(self.tracer.scene(), &rays, &hits);
        let rough = surface.scatters(Scattering::Rough);
        let stored = store(map, paths, &surface, rough, depth, out);
        if is_last {
            return stored;
        }
        let mut next = *paths;
        let mut alive = surface.hit;
        if rough.any() {
            match map {
                Map::Global => scatter(&mut next, &surface, rough, depth),
                Map::Caustic => alive &= !rough,
            }
        }
        if (surface.hit & !rough).any() {
            let (choice, _) = sobol::point(paths.index, paths.key, SETS * depth);
            scatter_specular(&mut next, &surface, choice);
            // Flux is not squeezed.
            next.throughput = next.throughput * (f32x8::ONE / next.compression);
            next.compression = f32x8::ONE;
        }
        alive &= survive(&mut next, paths, depth);
        next.origin = surface.leave(next.direction);
        self.queue.push(&next, alive.to_bitmask());
        stored
    }
}

/// Most caustic paths for each photon that is wanted.
const MOST_PATHS: u64 = 64;

/// Paths to shoot so that about `wanted` photons are caustic, if `pilot` paths have left `found`.
///
/// Few lights aim at glass, and paths that miss it cost little: there may be up to 64 paths a photon.
pub fn caustic_paths(wanted: u32, pilot: u32, found: usize) -> u32 {
    let (wanted, pilot) = (u64::from(wanted), u64::from(pilot));
    let paths = wanted.saturating_mul(pilot) / (found as u64).max(1);
    paths.clamp(1, wanted.saturating_mul(MOST_PATHS).clamp(1, 1 << 30)) as u32
}

/// Tells photons' keys from those of pixels, whose coordinates are smaller.
const KEY: u32 = u32::MAX;

/// Longest photon paths: what the eye's part leaves.
const fn segments(map: Map, max_depth: u32) -> u32 {
    match map {
        Map::Global => max_depth.saturating_sub(2),
        Map::Caustic => max_depth.saturating_sub(1),
    }
}

/// Writes the photons that the map keeps to the front of `out`; returns their number.
fn store(
    map: Map,
    paths: &Paths,
    surface: &SurfacePoints,
    rough: f32x8,
    depth: u32,
    out: &mut [Photon],
) -> usize {
    let kept = match map {
        Map::Global => surface.diffuse.max_component(),
        Map::Caustic if depth == 1 => return 0,
        Map::Caustic => surface.diffuse.max_component().fast_max(surface.specular.max_component()),
    };
    let mut lanes = (rough & kept.simd_gt(f32x8::ZERO)).to_bitmask();
    if lanes == 0 {
        return 0;
    }
    // What falls on the surface is measured along its shading normal, as paths from the eye do.
    let tilt = -paths.direction.dot(surface.normal) / surface.cosine.abs();
    let (position, normal) = (rows(surface.position), rows(surface.facing));
    let (power, from) = (rows(paths.throughput * tilt), rows(-paths.direction));
    let mut used = 0;
    while lanes != 0 && used < out.len() {
        let lane = lanes.trailing_zeros() as usize & 7;
        lanes &= lanes - 1;
        let at = |rows: &[[f32; 8]; 3]| [0, 1, 2].map(|axis| rows[axis][lane]);
        let photon =
            Photon { position: at(&position), normal: at(&normal), power: at(&power), from: at(&from) };
        // At grazing angles the quotient of two cosines can overflow.
        if photon.power.iter().all(|c| c.is_finite()) {
            out[used] = photon;
            used += 1;
        }
    }
    used
}

fn rows(v: Vec3x8) -> [[f32; 8]; 3] {
    [v.x.to_array(), v.y.to_array(), v.z.to_array()]
}

/// Samples the next direction in the lanes of `rough`.
fn scatter(next: &mut Paths, surface: &SurfacePoints, rough: f32x8, depth: u32) {
    let frame = Frame::new(surface.normal);
    let arriving = frame.to_local(-next.direction);
    let bsdf = Rough::new(surface, arriving);
    let (u, v) = sobol::point(next.index, next.key, SETS * depth + 1);
    let part = || sobol::point(next.index, next.key, SETS * depth).0;
    let leaving = bsdf.sample(u, v, part);
    let (value, density) = bsdf.evaluate(leaving);
    let direction = frame.to_world(leaving);
    // Veach 1997, section 5.3.2: the adjoint of a scattering function under shading normals.
    let tilt = arriving.z * direction.dot(surface.facing).abs() / (surface.cosine.abs() * leaving.z);
    let weight = value * (tilt / density);
    let valid = density.simd_gt(f32x8::ZERO);
    let throughput = Vec3x8::select(valid, next.throughput.scaled(weight), Vec3x8::default());
    next.throughput = Vec3x8::select(rough, throughput, next.throughput);
    next.direction = Vec3x8::select(rough, direction, next.direction);
}

/// Absorbs photons with the probability that keeps the power of the others; returns those that go on.
pub(super) fn survive(next: &mut Paths, before: &Paths, depth: u32) -> f32x8 {
    let kept = next.throughput.max_component() / before.throughput.max_component();
    let survival = kept.fast_min(f32x8::ONE);
    let (_, chance) = sobol::point(next.index, next.key, SETS * depth);
    next.throughput = next.throughput * (f32x8::ONE / survival);
    chance.simd_lt(survival)
}

#[cfg(test)]
mod tests;
