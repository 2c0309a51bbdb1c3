//! What several test files share: random numbers and scenes made by hand.
#![allow(dead_code, reason = "each test file uses its own part")]

use pmcip::scene::bvh;
use pmcip_core::sampler::batch::{Batch8, Integrand, Rgb8};
use pmcip_core::sampler::{Memory, Sampler, Schedule, Settings, Workspace};
use pmcip_core::tracer::camera::Camera;
use pmcip_core::tracer::scene::{
    Light, LightNode8, Material, Motion, Node8, Scene, SceneData, Surface, Triangle,
};
use pmcip_core::tracer::scene::{light, light_tree};
use pmcip_core::tracer::shade::path::{Packet, PathTracer, Traffic};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Seeded uniform numbers.
pub struct Random(Xoshiro256PlusPlus);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    /// Uniform in `[0, 1)`.
    pub fn unit(&mut self) -> f32 {
        (self.0.next_u32() >> 8) as f32 / (1 << 24) as f32
    }

    /// Uniform in `[-1, 1)³`.
    pub fn cube(&mut self) -> [f32; 3] {
        [0; 3].map(|_| self.unit() * 2.0 - 1.0)
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> [f32; 3] {
        loop {
            let v = self.cube();
            let length2: f32 = v.iter().map(|x| x * x).sum();
            if (1e-3..=1.0).contains(&length2) {
                return v.map(|x| x / length2.sqrt());
            }
        }
    }
}

/// A scene that owns its arrays.
pub struct Owned {
    pub nodes: Vec<Node8>,
    pub leaves: Vec<f32>,
    pub triangles: Vec<Triangle>,
    pub surfaces: Vec<Surface>,
    pub materials: Vec<Material>,
    pub lights: Vec<Light>,
    pub light_nodes: Vec<LightNode8>,
    /// The triangles and the leaves as the shutter closes, and normals; empty where nothing moves.
    pub closing: Vec<Triangle>,
    pub closing_leaves: Vec<f32>,
    pub closing_normals: Vec<[[f32; 3]; 3]>,
}

impl Owned {
    /// Builds hierarchy and lights over triangles with their material's index.
    pub fn new(parts: &[(Triangle, u32)], materials: Vec<Material>) -> Self {
        Owned::moving(parts, &[], materials)
    }

    /// The same of triangles that are where `closing` says as the shutter closes.
    pub fn moving(parts: &[(Triangle, u32)], closing: &[Triangle], materials: Vec<Material>) -> Self {
        let unordered: Vec<Triangle> = parts.iter().map(|p| p.0).collect();
        let built = bvh::build(&unordered, closing);
        let closing: Vec<Triangle> =
            built.order.iter().filter_map(|&i| closing.get(i as usize)).copied().collect();
        let ordered = || built.order.iter().map(|&i| parts[i as usize]);
        let triangles: Vec<Triangle> = ordered().map(|p| p.0).collect();
        let surfaces: Vec<Surface> =
            ordered().map(|p| Surface { material: p.1, ..Surface::default() }).collect();
        let mut lights = vec![Light::default(); light::count(&surfaces, &materials)];
        let used = light::build(&triangles, &surfaces, &materials, &mut lights);
        lights.truncate(used);
        let mut light_nodes = vec![LightNode8::default(); light_tree::required(used)];
        let mut order = vec![0; used];
        let used = light_tree::build(
            &triangles,
            &closing,
            &surfaces,
            &materials,
            &mut lights,
            &mut order,
            &mut light_nodes,
        );
        light_nodes.truncate(used);
        Owned {
            leaves: bvh::leaves(&built.nodes, &triangles),
            closing_leaves: bvh::leaves(&built.nodes, &closing),
            nodes: built.nodes,
            triangles,
            surfaces,
            materials,
            lights,
            light_nodes,
            closing_normals: vec![[[0.0; 3]; 3]; closing.len()],
            closing,
        }
    }

    pub fn scene(&self) -> Scene<'_> {
        Scene::new(SceneData {
            nodes: &self.nodes,
            leaves: &self.leaves,
            triangles: &self.triangles,
            surfaces: &self.surfaces,
            materials: &self.materials,
            lights: &self.lights,
            light_nodes: &self.light_nodes,
            motion: (!self.closing.is_empty()).then_some(Motion {
                triangles: &self.closing,
                leaves: &self.closing_leaves,
                normals: &self.closing_normals,
            }),
            ..SceneData::default()
        })
        .unwrap()
    }
}

/// The twelve triangles of the box `lower..upper`, fronts inwards.
pub fn inward_box(lower: [f32; 3], upper: [f32; 3]) -> Vec<Triangle> {
    let corner = |i: usize| [0, 1, 2].map(|axis| if i >> axis & 1 == 0 { lower[axis] } else { upper[axis] });
    let faces = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
    let triangle = |f: [usize; 3]| Triangle { corners: f.map(corner) };
    faces.iter().flat_map(|&[a, b, c, d]| [triangle([a, b, c]), triangle([a, c, d])]).collect()
}

/// Samples that an integrand is handed at once.
const STREAM: usize = 2048;

/// Memory for an integrator that works on a stream.
pub fn packets() -> Vec<Packet> {
    vec![Packet::default(); PathTracer::required(STREAM)]
}

/// A path traced picture made on one thread with the core alone: interleaved RGB, and how full the packets were.
pub fn render(
    scene: Scene<'_>,
    camera: Camera,
    max_depth: u32,
    settings: Settings,
    schedule: Schedule,
) -> (Vec<f32>, Traffic) {
    let mut packets = packets();
    let mut tracer = PathTracer::new(scene, camera, max_depth, &mut packets);
    let rgb = render_with(&mut tracer, settings, schedule);
    (rgb, tracer.traffic())
}

/// A picture of any integrand, likewise.
pub fn render_with(integrand: &mut impl Integrand, settings: Settings, schedule: Schedule) -> Vec<f32> {
    let (width, height) = (settings.width, settings.height);
    let required = Sampler::required(width, height);
    let (mut floats, mut words) = (vec![0.0; required.floats], vec![0; required.words]);
    let mut sampler = Sampler::new(settings, Memory { floats: &mut floats, words: &mut words }).unwrap();
    let (mut batches, mut radiance) =
        (vec![Batch8::default(); STREAM / 8], vec![Rgb8::default(); STREAM / 8]);
    let mut work = Workspace::new(&mut batches, &mut radiance).unwrap();
    for samples in schedule {
        sampler.begin(samples).unwrap();
        for mut job in sampler.jobs() {
            job.render(integrand, &mut work);
        }
        assert_eq!(sampler.end().unwrap().rejected, 0);
    }
    let mut scratch = vec![Default::default(); Sampler::resolve_scratch(width, height)];
    let mut rgb = vec![0.0; 3 * (width * height) as usize];
    sampler.resolve(settings.estimator, &mut scratch, &mut rgb).unwrap();
    rgb
}

/// Mean and standard error of the mean.
pub fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let square = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
    (mean, (square / (n * (n - 1.0))).sqrt())
}
