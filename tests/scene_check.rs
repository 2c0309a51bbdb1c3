//! `Scene::new` refuses what would lead a ray astray, and names it; the light table follows power.

use pmcip_core::tracer::scene::light;
use pmcip_core::tracer::scene::{
    Error, Lamp, Light, LightNode8, MAX_DEPTH, MIN_ROUGHNESS, Material, Motion, NO_TEXTURE, Node8, Scene,
    SceneData, Surface, Texture, Triangle, fill_leaves, leaves_len,
};

/// A valid scene of one lit triangle, changed by `change` before it is checked.
fn checked(change: impl FnOnce(&mut Parts)) -> Result<(), Error> {
    let mut parts = Parts::new();
    change(&mut parts);
    let data = SceneData {
        nodes: &parts.nodes,
        leaves: &parts.leaves,
        triangles: &parts.triangles,
        surfaces: &parts.surfaces,
        colours: &parts.colours,
        materials: &parts.materials,
        normal_maps: &[],
        textures: &parts.textures,
        texels: &parts.texels,
        lights: &parts.lights,
        light_nodes: &parts.light_nodes,
        sky: None,
        motion: parts.closing.as_ref().map(|triangle| Motion {
            triangles: std::slice::from_ref(triangle),
            leaves: &parts.closing_leaves,
            normals: &parts.closing_normals,
        }),
    };
    Scene::new(data).map(|_| ())
}

struct Parts {
    nodes: Vec<Node8>,
    leaves: Vec<f32>,
    triangles: Vec<Triangle>,
    surfaces: Vec<Surface>,
    colours: Vec<[[f32; 3]; 3]>,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    texels: Vec<[f32; 3]>,
    lights: Vec<Light>,
    light_nodes: Vec<LightNode8>,
    closing: Option<Triangle>,
    closing_leaves: Vec<f32>,
    closing_normals: Vec<[[f32; 3]; 3]>,
}

impl Parts {
    fn new() -> Parts {
        let triangle = Triangle { corners: [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] };
        let material = Material { emission: [1.0; 3], texture: 0, ..Material::default() };
        Parts {
            nodes: vec![node(0, 1)],
            leaves: leaf_of(&triangle),
            triangles: vec![triangle],
            surfaces: vec![Surface::default()],
            colours: vec![],
            materials: vec![material],
            textures: vec![Texture { width: 2, height: 1, first: 0, ..Texture::EMPTY }],
            texels: vec![[1.0; 3]; 2],
            lights: vec![Light {
                lamp: Lamp::new(&triangle, &material),
                triangle: 0,
                cumulative: 1.0,
                path: 0,
            }],
            light_nodes: vec![],
            closing: None,
            closing_leaves: vec![],
            closing_normals: vec![],
        }
    }

    /// The triangle moves to `closing` while the shutter is open.
    fn move_to(&mut self, closing: Triangle) {
        self.closing = Some(closing);
        self.closing_leaves = leaf_of(&closing);
        self.closing_normals = vec![[[0.0; 3]; 3]];
    }
}

/// The leaf of one triangle.
fn leaf_of(triangle: &Triangle) -> Vec<f32> {
    let mut leaves = vec![0.0; leaves_len(1)];
    fill_leaves(&[node(0, 1)], std::slice::from_ref(triangle), &mut leaves);
    leaves
}

/// A node with one child: the leaf of `count` triangles of which the first is number `child`, or the inner node `child` if that is 0.
fn node(child: u32, count: u32) -> Node8 {
    let mut node = Node8::EMPTY;
    for axis in 0..3 {
        (node.lower[axis][0], node.upper[axis][0]) = (0.0, 1.0);
    }
    (node.child[0], node.count[0]) = (child, count);
    node
}

#[test]
fn what_moves_must_be_held_all_along() {
    let there = Triangle { corners: [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]] };
    let beyond = Triangle { corners: [[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 1.0, 2.0]] };
    let moved = |change: fn(&mut Parts), to: Triangle| {
        checked(|parts| {
            parts.move_to(to);
            change(parts);
        })
    };
    assert_eq!(moved(|_| (), there), Ok(()));
    assert_eq!(moved(|_| (), beyond), Err(Error::Bounds(0)));
    assert_eq!(moved(|p| p.closing_leaves = p.leaves.clone(), there), Err(Error::Leaf(0)));
    assert_eq!(moved(|p| p.closing_leaves.clear(), there), Err(Error::Leaf(0)));
    assert_eq!(moved(|p| p.closing_normals.clear(), there), Err(Error::Motion));
    assert_eq!(moved(|p| p.closing_normals[0][1][2] = f32::NAN, there), Err(Error::Motion));
}

/// The same child in slot 1, with nothing in slot 0.
fn behind_a_hole(node: Node8) -> Node8 {
    let mut moved = Node8::EMPTY;
    for axis in 0..3 {
        (moved.lower[axis][1], moved.upper[axis][1]) = (node.lower[axis][0], node.upper[axis][0]);
    }
    (moved.child[1], moved.count[1]) = (node.child[0], node.count[0]);
    moved
}

#[test]
fn a_sound_scene_is_accepted() {
    assert_eq!(checked(|_| ()), Ok(()));
    assert!(Scene::new(SceneData::default()).is_ok());
}

/// The first box reaches higher.
fn too_high(mut node: Node8) -> Node8 {
    node.upper[1][0] = 2.0;
    node
}

#[test]
fn every_fault_is_named() {
    let fault = |change: fn(&mut Parts)| checked(change).unwrap_err();
    assert_eq!(fault(|p| p.surfaces.clear()), Error::SurfaceCount);
    assert_eq!(fault(|p| p.nodes[0] = node(0, 2)), Error::Node(0), "leaf beyond the triangles");
    assert_eq!(fault(|p| p.nodes[0] = node(1, 1)), Error::Node(0), "no such leaf");
    assert_eq!(fault(|p| p.nodes[0] = node(u32::MAX, 1)), Error::Node(0), "nor that one");
    let nine = |p: &mut Parts| {
        (p.triangles, p.surfaces) = (vec![p.triangles[0]; 9], vec![p.surfaces[0]; 9]);
        p.nodes[0] = node(0, 9);
    };
    assert_eq!(fault(nine), Error::Node(0), "more triangles than a leaf has room for");
    assert_eq!(fault(|p| p.nodes[0] = node(0, 0)), Error::Node(0), "a node that contains itself");
    assert_eq!(fault(|p| p.nodes[0] = node(7, 0)), Error::Node(0), "no such node");
    assert_eq!(fault(|p| p.nodes[0].upper[1][0] = f32::NAN), Error::Node(0), "a box that is none");
    assert_eq!(fault(|p| p.nodes[0].lower[2][0] = f32::NEG_INFINITY), Error::Node(0), "a box without end");
    assert_eq!(fault(|p| p.nodes[0].lower[1][0] = 2.0), Error::Node(0), "a box inside out");
    assert_eq!(fault(|p| p.nodes[0].upper[0][0] = 0.5), Error::Bounds(0), "a box too small for its triangle");
    assert_eq!(
        fault(|p| p.nodes = vec![node(1, 0), too_high(node(0, 1))]),
        Error::Bounds(0),
        "a box too small"
    );
    assert_eq!(fault(|p| p.nodes[0] = behind_a_hole(node(0, 1))), Error::Node(0), "a child behind a hole");
    assert_eq!(fault(|p| p.nodes[0].lower[1][5] = 0.0), Error::Node(0), "half an empty box");
    assert_eq!(fault(|p| p.nodes[0].count[7] = 1), Error::Node(0), "triangles of nobody");
    let [t, other] =
        [1.0, 2.0].map(|size| Triangle { corners: [[0.0; 3], [size, 0.0, 0.0], [0.0, 1.0, 0.0]] });
    let leaf = |leaves: Vec<f32>| checked(|p| p.leaves = leaves);
    assert_eq!(leaf(leaf_of(&t)), Ok(()));
    assert_eq!(leaf(leaf_of(&other)), Err(Error::Leaf(0)), "another triangle than the scene's");
    assert_eq!(leaf(vec![0.0; leaves_len(1)]), Err(Error::Leaf(0)), "a triangle is missing");
    assert_eq!(
        leaf(leaf_of(&t)[..leaves_len(1) - 1].to_vec()),
        Err(Error::Leaf(0)),
        "a walk would read beyond"
    );
    assert_eq!(fault(|p| p.surfaces[0].material = 1), Error::Surface(0));
    assert_eq!(fault(|p| p.materials[0].diffuse[1] = 1.5), Error::Material(0));
    assert_eq!(fault(|p| p.materials[0].emission[0] = f32::NAN), Error::Material(0));
    assert_eq!(fault(|p| p.materials[0].roughness = 0.0), Error::Material(0));
    assert_eq!(fault(|p| p.materials[0].roughness = 0.9 * MIN_ROUGHNESS), Error::Material(0));
    assert_eq!(fault(|p| p.materials[0].texture = 1), Error::Material(0));
    assert_eq!(fault(|p| p.materials[0].opacity = 1.5), Error::Material(0));
    assert_eq!(fault(|p| p.materials[0].opacity_texture = 1), Error::Material(0));
    assert_eq!(fault(|p| p.materials[0].emission_texture = 1), Error::Material(0));
    assert_eq!(fault(|p| p.colours = vec![[[1.0; 3]; 3]; 2]), Error::Colours(1), "colours of no triangle");
    assert_eq!(fault(|p| p.colours = vec![[[1.0, 2.0, 0.0]; 3]]), Error::Colours(0));
    assert_eq!(fault(|p| p.textures[0].width = 3), Error::Texture(0));
    assert_eq!(fault(|p| p.textures[0].height = 0), Error::Texture(0));
    assert_eq!(fault(|p| p.lights[0].triangle = 1), Error::Light(0));
    assert_eq!(fault(|p| p.lights[0].cumulative = 0.5), Error::Light(0));
    assert_eq!(fault(|p| p.lights[0].lamp.edges[1][2] = 0.5), Error::Light(0));
    assert_eq!(fault(|p| p.lights[0].lamp.emission[0] = 2.0), Error::Light(0));
    assert_eq!(fault(|p| p.lights[0].lamp.inverse_area = 1.0), Error::Light(0));
}

#[test]
fn the_tree_may_be_as_deep_as_the_stack_and_no_deeper() {
    let chain = |depth: usize| {
        let inner = (1..depth).map(|next| node(next as u32, 0));
        inner.chain([node(0, 1)]).collect::<Vec<_>>()
    };
    assert_eq!(checked(|p| p.nodes = chain(MAX_DEPTH)), Ok(()));
    assert_eq!(checked(|p| p.nodes = chain(MAX_DEPTH + 1)), Err(Error::TooDeep));
    // Two parents share a child: not a tree, and walking it as one could take for ever.
    let mut shared = node(1, 0);
    (shared.lower[0][1], shared.upper[0][1], shared.child[1]) = (0.0, 1.0, 1);
    assert!(matches!(checked(|p| p.nodes = vec![shared, node(0, 1)]), Err(Error::Node(_))));
}

#[test]
fn lights_are_picked_by_power() {
    let triangle = |size: f32| Triangle { corners: [[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0]] };
    let lamp =
        |radiance: f32| Material { emission: [radiance; 3], texture: NO_TEXTURE, ..Material::default() };
    let triangles = [triangle(1.0), triangle(2.0), triangle(3.0), triangle(0.0)];
    let materials = [lamp(8.0), lamp(0.0), lamp(1.0)];
    let surfaces = [0, 0, 1, 2].map(|material| Surface { material, ..Surface::default() });
    assert_eq!(
        light::count(&surfaces, &materials),
        3,
        "the lamp without area emits, as far as its material knows"
    );
    let mut lights = [Light::default(); 3];
    let used = light::build(&triangles, &surfaces, &materials, &mut lights);
    let table: Vec<_> = lights[..used].iter().map(|l| (l.triangle, l.cumulative)).collect();
    assert_eq!(
        table,
        [(0, 0.2), (1, 1.0)],
        "areas 1 : 4 at equal radiance; no share without area or radiance"
    );
}
