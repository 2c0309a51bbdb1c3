//! Any arrays as a scene: nodes with any children and boxes, leaves of any triangles, still or moving, lights and textures anywhere. They are
//! refused, or rays end in them, the same together and alone.

use super::bytes::{Bytes, Cycle};
use super::view::{Random, probe};
use pmcip_core::tracer::scene::light;
use pmcip_core::tracer::scene::{
    Lamp, Light, Material, Motion, NO_TEXTURE, Node8, Scene, SceneData, Surface, Texture, Triangle,
    fill_leaves, leaves_len,
};

/// Nodes are fewer than this: more than levels are allowed.
const NODES: usize = 40;

/// A head, triangles, leaves, then nodes from the last to the first.
pub fn check(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let (kind, seed) = (bytes.byte(), bytes.word());
    let tame = kind & 1 == 1;
    let [triangles, leaves, nodes] = [24, 20, NODES].map(|end| bytes.below(end));
    let mut coordinates = bytes.cycle(72, tame);
    let mut list = || (0..triangles).map(|_| triangle(&mut coordinates, tame)).collect::<Vec<Triangle>>();
    let open = list();
    let closing = if kind & 8 == 8 { list() } else { open.clone() };
    let leaves: Vec<Leaf> = (0..leaves).map(|_| leaf(&mut bytes, triangles)).collect();
    let firsts: Vec<usize> = leaves.iter().map(|leaf| leaf.first).collect();
    let mut after = Vec::new();
    for index in (0..nodes).rev() {
        let node = node(&mut bytes, (index, nodes), &after, &firsts, [&open, &closing]);
        after.push(node);
    }
    after.reverse();
    let [leaves, closing_leaves] = [&open, &closing].map(|triangles| rows(&after, triangles, &leaves));
    let normals = vec![[[0.0; 3]; 3]; triangles];
    let motion = Motion { triangles: &closing, leaves: &closing_leaves, normals: &normals };
    let triangles = open;
    let texture = if kind & 2 == 0 { NO_TEXTURE } else { u32::from(bytes.byte() % 3) };
    let textures = [0; 2].map(|_| texture_of(&mut bytes));
    let texels = vec![[0.5; 3]; bytes.below(40)];
    let materials = [
        Material { texture, opacity_texture: texture, ..Material::default() },
        Material { emission: [1.0; 3], emission_texture: texture, ..Material::default() },
    ];
    let dark = usize::from(kind >> 4) + 1;
    let surface = |i: usize| Surface { material: u32::from(i.is_multiple_of(dark)), ..Surface::default() };
    let surfaces: Vec<Surface> = (0..triangles.len()).map(surface).collect();
    let mut lights = vec![Light::default(); light::count(&surfaces, &materials)];
    let used = light::build(&triangles, &surfaces, &materials, &mut lights);
    lights.truncate(used);
    if let (true, Some(light)) = (kind & 4 == 4, lights.first_mut()) {
        let (triangle, cumulative) = (u32::from(bytes.byte()), bytes.float(tame));
        let there = triangles.get(triangle as usize).copied().unwrap_or_default();
        let lamp = Lamp::new(&there, &materials[1]);
        *light = Light { lamp, triangle, cumulative, path: bytes.word() };
    }
    let data = SceneData {
        nodes: &after,
        leaves: &leaves,
        triangles: &triangles,
        surfaces: &surfaces,
        materials: &materials,
        textures: &textures,
        texels: &texels,
        lights: &lights,
        normal_maps: if kind & 128 == 0 { &[] } else { &[texture; 2] },
        motion: (kind & 8 == 8).then_some(motion),
        ..SceneData::default()
    };
    match Scene::new(data) {
        Ok(scene) => probe(scene, &mut Random(seed)),
        Err(error) => assert!(!error.to_string().contains('\n')),
    }
}

fn triangle(any: &mut Cycle, tame: bool) -> Triangle {
    let near = |v: f32| if tame { 0.5 + v / 64.0 } else { v };
    Triangle { corners: [0; 3].map(|_| any.rgb().map(near)) }
}

fn texture_of(bytes: &mut Bytes) -> Texture {
    let [width, height, first] = [0; 3].map(|_| u32::from(bytes.byte()) % 9);
    Texture { width, height, first, clamp: bytes.bit(), scale: [bytes.level(), 1.0], ..Texture::EMPTY }
}

/// The first triangle of a leaf, and one of its numbers that is another if `other` is above 240.
struct Leaf {
    first: usize,
    number: usize,
    other: u8,
}

fn leaf(bytes: &mut Bytes, triangles: usize) -> Leaf {
    Leaf { first: bytes.below(triangles + 1), number: bytes.below(10), other: bytes.byte() }
}

/// The leaves' numbers, right as a rule.
fn rows(nodes: &[Node8], triangles: &[Triangle], leaves: &[Leaf]) -> Vec<f32> {
    let mut rows = vec![0.0; leaves_len(triangles.len())];
    fill_leaves(nodes, triangles, &mut rows);
    for leaf in leaves.iter().filter(|leaf| leaf.other > 240) {
        rows[9 * leaf.first + leaf.number] = f32::from(leaf.other);
    }
    if leaves.iter().any(|leaf| leaf.other == 240) {
        rows.pop();
    }
    rows
}

/// A node with any children, which are right as a rule, and boxes that fit as a rule.
fn node(
    bytes: &mut Bytes,
    (index, nodes): (usize, usize),
    after: &[Node8],
    leaves: &[usize],
    triangles: [&[Triangle]; 2],
) -> Node8 {
    let mut node = Node8::EMPTY;
    for child in 0..bytes.below(9) {
        let (kind, which) = (bytes.byte(), bytes.byte());
        let points: Vec<[f32; 3]> = if kind & 1 == 0 {
            // An inner child; nodes that are known come after this one.
            let below = index + 1 + usize::from(which) % (nodes - index);
            node.child[child] = if kind & 2 == 0 { below as u32 } else { u32::from(which) };
            let below = nodes.checked_sub(1 + node.child[child] as usize).and_then(|i| after.get(i));
            below.map_or(vec![], corners)
        } else {
            let leaf = leaves.get(usize::from(which) % leaves.len().max(1)).copied();
            let first = if kind & 2 == 2 { usize::from(which) } else { leaf.unwrap_or(0) };
            (node.child[child], node.count[child]) = (first as u32, 1 + u32::from(kind >> 4) % 9);
            let end = triangles[0].len().min(first + node.count[child] as usize);
            triangles
                .iter()
                .flat_map(|list| list.get(first..end).unwrap_or(&[]))
                .flat_map(|t| t.corners)
                .collect()
        };
        for axis in 0..3 {
            let around = |(l, u): (f32, f32), p: &[f32; 3]| (l.min(p[axis]), u.max(p[axis]));
            let (mut lower, mut upper) = points.iter().fold((f32::INFINITY, f32::NEG_INFINITY), around);
            if kind & 12 == 12 {
                (lower, upper) = (bytes.float(kind & 16 == 0), bytes.float(kind & 16 == 0));
            }
            (node.lower[axis][child], node.upper[axis][child]) = (lower, upper);
        }
    }
    node
}

/// Corners of the boxes of a node's children.
fn corners(node: &Node8) -> Vec<[f32; 3]> {
    let used = (0..8).filter(|child| node.is_used(*child));
    used.flat_map(|child| [node.lower.map(|row| row[child]), node.upper.map(|row| row[child])]).collect()
}

/// Nothing, a leaf, one that moves, a tree of two levels, a chain that is too deep, a circle.
pub fn seeds() -> Vec<Vec<u8>> {
    let coordinates: Vec<u8> = (0..36i16).flat_map(|i| ((i * 37) % 128).to_le_bytes()).collect();
    let head = |kind: u8, triangles: u8, leaves: u8, nodes: u8| {
        [&[kind, 7, 0, 0, 0, triangles, leaves, nodes], &coordinates[..]].concat()
    };
    let leaves: Vec<u8> = (0..8u8).flat_map(|i| [2 * i, 2, 0]).collect();
    // Two triangles each.
    let floor: Vec<u8> = [&[8][..], &(0..8u8).flat_map(|i| [1 | 1 << 4, i]).collect::<Vec<u8>>()].concat();
    let chain =
        |kind: u8, nodes: u8| [head(kind, 16, 8, nodes), leaves.clone(), floor.clone(), [1, 0, 0].repeat(39)];
    let tail = [3, 3, 0, 1, 0, 1, 4, 4, 2, 0, 0, 2, 39];
    vec![
        head(1, 0, 0, 0),
        [head(1, 16, 8, 1), leaves.clone(), floor.clone()].concat(),
        [head(9, 16, 8, 1), leaves.clone(), floor.clone()].concat(),
        [
            head(0x8b, 16, 8, 1),
            leaves.clone(),
            floor.clone(),
            vec![1, 3, 3, 0, 1, 0, 1, 4, 4, 0, 0, 0, 1, 39],
        ]
        .concat(),
        chain(1, 2).concat(),
        chain(1, 31).concat(),
        chain(0x31, 39).concat(),
        [head(3, 16, 8, 1), leaves.clone(), floor.clone(), tail.to_vec()].concat(),
        [head(1, 16, 8, 2), leaves, floor, vec![2, 2, 0, 2, 1]].concat(),
    ]
}
