//! A frame rendered on the stack with nothing but the core: a grey wall under a lamp and a sky, path traced, adaptive.

use pmcip_core::sampler::batch::{Batch8, Rgb8};
use pmcip_core::sampler::{Memory, Sampler, Schedule, Settings, Tally, Workspace};
use pmcip_core::tracer::camera::Camera;
use pmcip_core::tracer::scene::light;
use pmcip_core::tracer::scene::sky::{self, Sky, Sun};
use pmcip_core::tracer::scene::{
    Light, Material, Node8, Scene, SceneData, Surface, Triangle, fill_leaves, leaves_len,
};
use pmcip_core::tracer::shade::path::{Packet, PathTracer};

const WIDTH: u32 = 40;
const HEIGHT: u32 = 24;
const PIXELS: usize = (WIDTH * HEIGHT) as usize;
const SPP: u32 = 8;
const BATCHES: usize = 16;
const LAMP: f32 = 5.0;

/// Samples that the frame has.
pub const SAMPLES: u64 = PIXELS as u64 * SPP as u64;

/// Renders the frame; returns its tally and the largest value in it, or nothing if the core refused something.
pub fn render() -> Option<(Tally, f32)> {
    let triangles = [
        Triangle { corners: [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 2.0, 0.0]] },
        Triangle { corners: [[-1.0, 2.0, 0.5], [1.0, 2.0, 0.5], [0.0, 2.0, 2.0]] },
    ];
    let surfaces = [Surface::default(), Surface { material: 1, ..Surface::default() }];
    let materials = [Material::default(), Material { emission: [LAMP; 3], ..Material::default() }];
    let mut nodes = [Node8::EMPTY];
    let root = &mut nodes[0];
    for (axis, (low, high)) in [(-1.0, 1.0), (-1.0, 2.0), (0.0, 2.0)].into_iter().enumerate() {
        (root.lower[axis][0], root.upper[axis][0]) = (low, high);
    }
    root.count[0] = triangles.len() as u32;
    let mut leaves = [0.0; leaves_len(2)];
    fill_leaves(&nodes, &triangles, &mut leaves);
    let mut lights = [Light::default(); 2];
    let used = light::build(&triangles, &surfaces, &materials, &mut lights);
    let sun = Sun { direction: [0.0, 0.0, 1.0], radius: 0.01, radiance: [0.01; 3] };
    let (texels, mut rows, mut cells) = ([[0.01, 0.02, 0.03]; 8], [0; 3], [0; 8]);
    let power = sky::build((4, 2), &texels, Some(&sun), &mut rows, &mut cells);
    let sky = Sky {
        width: 4,
        height: 2,
        texels: &texels,
        rows: &rows,
        cells: &cells,
        axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        sun: Some(sun),
        power,
        visible: true,
    };
    let scene = Scene::new(SceneData {
        nodes: &nodes,
        leaves: &leaves,
        triangles: &triangles,
        surfaces: &surfaces,
        colours: &[],
        materials: &materials,
        normal_maps: &[],
        textures: &[],
        texels: &[],
        lights: &lights[..used],
        light_nodes: &[],
        sky: Some(sky),
        motion: None,
    });
    sample(scene.ok()?)
}

fn sample(scene: Scene<'_>) -> Option<(Tally, f32)> {
    let camera = Camera::new([0.0, 0.5, 4.0], [0.0, 0.5, 0.0], [0.0, 1.0, 0.0], 50.0, WIDTH, HEIGHT).ok()?;
    let mut packets = [Packet::default(); PathTracer::required(8 * BATCHES)];
    let mut tracer = PathTracer::new(scene, camera, 4, &mut packets);
    let (mut floats, mut words) = ([0.0; 8 * PIXELS], [0; 4 * PIXELS]);
    let memory = Memory { floats: &mut floats, words: &mut words };
    let mut sampler = Sampler::new(Settings::new(WIDTH, HEIGHT), memory).ok()?;
    let (mut batches, mut radiance) = ([Batch8::default(); BATCHES], [Rgb8::default(); BATCHES]);
    let mut work = Workspace::new(&mut batches, &mut radiance).ok()?;
    let mut tally = Tally::default();
    for samples in Schedule::new(PIXELS as u64, SPP, 2, 4) {
        sampler.begin(samples).ok()?;
        for mut job in sampler.jobs() {
            job.render(&mut tracer, &mut work);
        }
        tally = sampler.end().ok()?;
    }
    let (mut rgb, mut scratch) = ([0.0; 3 * PIXELS], [[0.0; 16]; PIXELS.div_ceil(16) + 5 * WIDTH as usize]);
    sampler.resolve(sampler.settings().estimator, &mut scratch, &mut rgb).ok()?;
    Some((tally, rgb.iter().copied().fold(0.0, f32::max)))
}
