//! The generator of the statue and the room: sound meshes, the promised sizes, a cache that notices changes.

use glam::{IVec3, Vec3, vec3};
use pmcip::scene::{LoadedScene, load};
use scenes::mesh::Mesh;
use scenes::shapes::{ball, block, drum, lathe, tube};
use scenes::{Outcome, Scene, make, polygonise, room, statue};
use std::collections::{BTreeMap, HashMap};

/// Makes sure that every edge of a mesh is passed as often in one direction as in the other (vertices closer than
/// 0.1 mm are one), that no triangle is without area, that normals are unit and on the front.
fn assert_sound(name: &str, mesh: &Mesh) {
    let place = |i: u32| (mesh.positions[i as usize] * 1e4).round().as_ivec3();
    let mut passes: HashMap<(IVec3, IVec3), i32> = HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        assert!(mesh.area_normal([a, b, c]).length() > 1e-12, "{name}: a triangle without area");
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (from, to) = (place(from), place(to));
            *passes.entry((from, to)).or_default() += 1;
            *passes.entry((to, from)).or_default() -= 1;
        }
    }
    assert!(passes.values().all(|balance| *balance == 0), "{name}: an open edge");
    assert!(mesh.normals.iter().all(|n| n.is_normalized()), "{name}: a normal is not unit");
    assert_eq!(mesh.backward_triangles().count(), 0, "{name}");
    assert_eq!([mesh.normals.len(), mesh.uvs.len()], [mesh.positions.len(); 2], "{name}");
}

/// The volume inside a closed mesh whose front is outside.
fn volume(mesh: &Mesh) -> f32 {
    let corner = |i: u32| mesh.positions[i as usize];
    mesh.triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))) / 6.0).sum()
}

#[test]
fn primitives_are_closed_and_have_their_volume() {
    use std::f32::consts::PI;
    let cone = [(0.0, 0.0), (0.3, 0.0), (0.0, 0.9)];
    let shapes = [
        ("block", block(vec3(0.2, 0.3, 0.4), 1e-3, 2), 8.0 * 0.2 * 0.3 * 0.4),
        ("round block", block(Vec3::splat(0.2), 0.1999, 16), 4.0 / 3.0 * PI * 0.2f32.powi(3)),
        ("ball", ball(0.2, 64), 4.0 / 3.0 * PI * 0.2f32.powi(3)),
        ("drum", drum(0.2, -0.1, 0.4, 64), PI * 0.04 * 0.5),
        ("cone", lathe(&cone, 64), PI * 0.09 * 0.3),
        ("tube", tube(&[(Vec3::ZERO, 0.1), (Vec3::Y, 0.1)], 64), PI * 0.01),
    ];
    for (name, mesh, expected) in shapes {
        assert_sound(name, &mesh);
        // Chords of 64 sides, broken edges: all less than two hundredths.
        assert!((volume(&mesh) / expected - 1.0).abs() < 0.02, "{name}: {} not {expected}", volume(&mesh));
    }
}

#[test]
fn surfaces_of_fields_are_closed_and_where_the_field_is_zero() {
    const STEP: f32 = 0.03;
    let field = |p: Vec3| (p - vec3(0.01, 0.02, 0.03)).length() - 0.4;
    let mesh = polygonise::surface(field, Vec3::splat(-0.5), Vec3::splat(0.5), STEP);
    assert_sound("sphere", &mesh);
    // Vertices keep a twentieth of a cell from its faces: the diagonal of that is 0.087 cells.
    assert!(mesh.positions.iter().all(|p| field(*p).abs() < 0.09 * STEP));
    let outwards = |(p, n): (&Vec3, &Vec3)| (*p - vec3(0.01, 0.02, 0.03)).normalize().dot(*n) > 0.999;
    assert!(mesh.positions.iter().zip(&mesh.normals).all(outwards));
}

#[test]
fn the_statue_is_a_closed_surface_of_the_promised_size() {
    const DETAIL: f32 = 0.2;
    let mesh = statue::mesh(DETAIL);
    assert_sound("statue", &mesh);
    // Cells that the surface passes, and so triangles, go with the square of the detail.
    let at_full_detail = mesh.triangles.len() as f32 / (DETAIL * DETAIL);
    assert!(at_full_detail > 300_000.0, "{at_full_detail}");
    // Plinth, throne and figure fill about a third of the box around them.
    let (low, high) = bounds(&mesh);
    let share = volume(&mesh) / (high - low).element_product();
    assert!((0.2..0.5).contains(&share), "{share}");
    assert!(low.y.abs() < 0.03 && high.y > 1.7, "from {low} to {high}");
}

fn bounds(mesh: &Mesh) -> (Vec3, Vec3) {
    let all = || mesh.positions.iter().copied();
    (all().fold(Vec3::INFINITY, Vec3::min), all().fold(Vec3::NEG_INFINITY, Vec3::max))
}

#[test]
fn the_room_has_the_promised_size() {
    let triangles = room::files(1.0).unwrap().triangles();
    assert!(triangles > 300_000, "{triangles}");
}

/// Makes a small version of a scene and loads it.
fn made(scene: Scene) -> LoadedScene {
    let folder = tempfile::tempdir().unwrap();
    let outcome = make(scene, 0.12, folder.path()).unwrap();
    let loaded = load(&folder.path().join(scene.name()).with_extension("toml")).unwrap();
    assert!(matches!(outcome, Outcome::Made(triangles) if triangles > 5_000));
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    loaded
}

#[test]
fn the_statue_has_one_lamp() {
    let scene = made(Scene::Statue);
    assert_eq!((scene.width, scene.height, scene.lights.len()), (256, 512, 2));
}

#[test]
fn the_room_has_many_lamps_of_very_different_power() {
    let scene = made(Scene::Room);
    assert_eq!(scene.textures.len(), 7);
    let mut powers: BTreeMap<u32, f32> = BTreeMap::new();
    for light in &scene.lights {
        let i = light.triangle as usize;
        let [a, b, c] = scene.triangles[i].corners.map(Vec3::from);
        let material = scene.surfaces[i].material;
        let [red, green, blue] = scene.materials[material as usize].emission;
        *powers.entry(material).or_default() += (b - a).cross(c - a).length() * (red + green + blue);
    }
    // Lamps of one kind share a material, so there are at least as many lamps.
    assert!(powers.len() >= 8, "{powers:?}");
    let (least, most) = powers.values().fold((f32::MAX, 0f32), |(l, m), p| (l.min(*p), m.max(*p)));
    assert!(most > 100.0 * least, "{least} to {most}");
}

#[test]
fn the_cache_notices_what_changed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let file = path.join("cache/statue/statue.obj");
    let build = |detail| make(Scene::Statue, detail, path).unwrap();
    let bytes = || std::fs::read(&file).unwrap();
    let is_made = |outcome| matches!(outcome, Outcome::Made(_));
    assert!(is_made(build(0.08)));
    let first = bytes();
    assert_eq!(build(0.08), Outcome::Kept);
    // Spoiled, it is made again, and to the same bytes.
    std::fs::write(&file, "v 0 0 0\n").unwrap();
    assert!(is_made(build(0.08)));
    assert!(bytes() == first);
    // So it is when it is missing, or asked for in another detail.
    std::fs::remove_file(&file).unwrap();
    assert!(is_made(build(0.08)));
    assert!(is_made(build(0.09)));
    assert!(bytes() != first);
}

#[test]
fn a_scene_file_that_is_there_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("statue.toml");
    std::fs::write(&file, "# mine\n").unwrap();
    make(Scene::Statue, 0.05, folder.path()).unwrap();
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "# mine\n");
}
