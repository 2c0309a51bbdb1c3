//! A scene of which single fields are changed to anything, and what must hold of it if it is accepted all the same: rays
//! end, without a panic, and meet the same whether they go together or alone. Shared with the fuzz target `scene`.

use pmcip_core::maths::vec3::Vec3x8;
use pmcip_core::sampler::batch::{Batch8, Integrand};
use pmcip_core::tracer::camera::Camera;
use pmcip_core::tracer::scene::light;
use pmcip_core::tracer::scene::{
    Light, Material, Node8, Scene, SceneData, Surface, Triangle, fill_leaves, leaves_len,
};
use pmcip_core::tracer::shade::path::{Packet, PathTracer};
use pmcip_core::tracer::trace::{Hits8, Rays8, Tracer};
use wide::{f32x8, u32x8};

/// Levels of the tree, eight children each; two triangles a leaf. More nodes than the tracer walks with packets alone.
const LEVELS: u32 = 3;
const TRIANGLES: u32 = 2;

/// Random bits.
#[derive(Clone, Copy)]
pub struct Random(pub u32);

impl Random {
    pub fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = (self.0 >> (self.0 >> 28 & 15) ^ self.0).wrapping_mul(277_803_737);
        word >> 22 ^ word
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / 16_777_216.0
    }
}

/// A change of one number: what it is in, which one, and its new bits.
#[derive(Clone, Copy, Debug)]
pub struct Change {
    pub target: u8,
    pub at: u16,
    pub field: u8,
    pub bits: u32,
}

/// A scene's arrays.
#[derive(Clone)]
pub struct View {
    nodes: Vec<Node8>,
    leaves: Vec<f32>,
    triangles: Vec<Triangle>,
    surfaces: Vec<Surface>,
    materials: Vec<Material>,
    lights: Vec<Light>,
}

impl View {
    /// A sound scene of small triangles in a cube from 0 to 1.
    pub fn new(seed: u32) -> View {
        let mut view = View {
            nodes: vec![],
            leaves: vec![],
            triangles: vec![],
            surfaces: vec![],
            materials: vec![Material::default(), Material { emission: [1.0; 3], ..Material::default() }],
            lights: vec![],
        };
        view.grow(&mut Random(seed), 1);
        view.leaves = vec![0.0; leaves_len(view.triangles.len())];
        fill_leaves(&view.nodes, &view.triangles, &mut view.leaves);
        let material = |i: usize| u32::from(i.is_multiple_of(97));
        view.surfaces = (0..view.triangles.len())
            .map(|i| Surface { material: material(i), ..Surface::default() })
            .collect();
        view.lights = vec![Light::default(); light::count(&view.surfaces, &view.materials)];
        let used = light::build(&view.triangles, &view.surfaces, &view.materials, &mut view.lights);
        view.lights.truncate(used);
        view
    }

    /// Adds a node and what is below it; returns its bounds.
    fn grow(&mut self, random: &mut Random, level: u32) -> [[f32; 3]; 2] {
        let index = self.nodes.len();
        self.nodes.push(Node8::EMPTY);
        let mut around = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        for child in 0..8 {
            let (first, count, bounds) = if level < LEVELS {
                let first = self.nodes.len();
                (first, 0, self.grow(random, level + 1))
            } else {
                (self.triangles.len(), TRIANGLES, self.leaf(random))
            };
            let node = &mut self.nodes[index];
            (node.child[child], node.count[child]) = (first as u32, count);
            for axis in 0..3 {
                (node.lower[axis][child], node.upper[axis][child]) = (bounds[0][axis], bounds[1][axis]);
                around[0][axis] = around[0][axis].min(bounds[0][axis]);
                around[1][axis] = around[1][axis].max(bounds[1][axis]);
            }
        }
        around
    }

    fn leaf(&mut self, random: &mut Random) -> [[f32; 3]; 2] {
        let first = self.triangles.len();
        let centre = [0; 3].map(|_| random.unit());
        for _ in 0..TRIANGLES {
            let corner = |_| centre.map(|x| x + 0.2 * random.unit());
            self.triangles.push(Triangle { corners: [0; 3].map(corner) });
        }
        let corners = || self.triangles[first..].iter().flat_map(|t| t.corners);
        let bound = |axis: usize, f: fn(f32, f32) -> f32| corners().map(|c| c[axis]).reduce(f).unwrap_or(0.0);
        [[0, 1, 2].map(|axis| bound(axis, f32::min)), [0, 1, 2].map(|axis| bound(axis, f32::max))]
    }

    /// Changes one number.
    pub fn change(&mut self, change: Change) {
        let Change { target, at, field, bits } = change;
        let (at, field, value) = (usize::from(at), usize::from(field), f32::from_bits(bits));
        match target % 8 {
            0 | 1 => {
                let i = at % self.nodes.len();
                let words: &mut [u32; 64] = bytemuck::cast_mut(&mut self.nodes[i]);
                words[field % 64] = bits;
            }
            2 => {
                let i = at % self.nodes.len();
                let (from, to) = (field % 8, field / 8 % 8);
                self.nodes[i].child[to] = self.nodes[i].child[from];
                self.nodes[i].count[to] = bits % 10;
            }
            3 => {
                let i = at % self.leaves.len();
                self.leaves[i] = value;
            }
            4 => {
                let i = at % self.triangles.len();
                self.triangles[i].corners[field % 3][field / 3 % 3] = value;
            }
            5 => {
                let i = at % self.surfaces.len();
                let words: &mut [u32; 16] = bytemuck::cast_mut(&mut self.surfaces[i]);
                words[field % 16] = bits;
            }
            6 => {
                let i = at % self.lights.len();
                self.lights[i] = Light { triangle: bits % 2048, ..self.lights[i] };
            }
            _ => {
                let material = &mut self.materials[at % 2];
                match field % 4 {
                    0 => material.roughness = value,
                    1 => material.diffuse[field / 4 % 3] = value,
                    2 => material.emission[field / 4 % 3] = value,
                    _ => material.specular[field / 4 % 3] = value,
                }
            }
        }
    }

    /// The scene, if it is one.
    pub fn scene(&self) -> Option<Scene<'_>> {
        let data = SceneData {
            nodes: &self.nodes,
            leaves: &self.leaves,
            triangles: &self.triangles,
            surfaces: &self.surfaces,
            materials: &self.materials,
            lights: &self.lights,
            ..SceneData::default()
        };
        Scene::new(data).ok()
    }
}

/// Coordinates up to which rays together and alone are compared: beyond, rounding is larger than what rays see of the scene.
const TAME: f32 = 1e3;

/// Sends rays through a scene, together and alone.
pub fn probe(scene: Scene<'_>, random: &mut Random) {
    let mut tracer = Tracer::new(scene);
    let mut corners = scene.data().triangles.iter().flat_map(|t| t.corners).flatten();
    let tame = corners.all(|v| v.abs() <= TAME);
    for _ in 0..4 {
        let rays = rays(random);
        let together = tracer.closest(&rays);
        let blocked = tracer.occluded(&rays);
        for lane in 0..8 {
            let alone = Rays8 { t_max: only(lane, rays.t_max), ..rays };
            let (hit, occluded) = (tracer.closest(&alone), tracer.occluded(&alone));
            if tame {
                agree(&together, &hit, lane);
                assert_eq!(blocked >> lane & 1, occluded >> lane & 1, "blocked together and alone");
            }
        }
    }
    let mut packets = [Packet::default(); PathTracer::required(8)];
    let Ok(camera) = Camera::new([0.5, 0.5, 3.0], [0.5; 3], [0.0, 1.0, 0.0], 40.0, 4, 4) else { return };
    let mut paths = PathTracer::new(scene, camera, 6, &mut packets);
    let batch = Batch8 { lanes: 8, x: f32x8::splat(2.0), y: f32x8::splat(2.0), index: lanes(), key: lanes() };
    paths.radiance(&batch);
}

/// Eight rays from around the cube, some together, some not.
fn rays(random: &mut Random) -> Rays8 {
    let wide = if random.bits() & 1 == 0 { 1.0 } else { 0.01 };
    let mut number =
        |centre: f32, wide: f32| f32x8::from([0; 8].map(|_| centre + wide * (random.unit() - 0.5)));
    let origin = Vec3x8::new(number(0.5, 2.0), number(0.5, 2.0), number(0.5, 2.0));
    let direction = Vec3x8::new(number(0.3, 2.0 * wide), number(-0.2, 2.0 * wide), number(0.7, 2.0 * wide));
    let time = number(0.5, 0.9);
    Rays8 { origin, direction: direction.normalized(), t_max: f32x8::splat(10.0), time }
}

/// `t_max` in one lane, idle in the others.
fn only(lane: usize, t_max: f32x8) -> f32x8 {
    let mut t = [-1.0; 8];
    t[lane] = t_max.to_array()[lane];
    f32x8::from(t)
}

fn lanes() -> u32x8 {
    u32x8::new([0, 1, 2, 3, 4, 5, 6, 7])
}

/// A lane hits the same triangle, or another one just as far away.
fn agree(together: &Hits8, alone: &Hits8, lane: usize) {
    let (a, b) = (together.t.to_array()[lane], alone.t.to_array()[lane]);
    let (hit, other) = (together.triangle.to_array()[lane], alone.triangle.to_array()[lane]);
    assert!(a.to_bits() == b.to_bits(), "lane {lane}: {a} together, {b} alone ({hit}, {other})");
}
