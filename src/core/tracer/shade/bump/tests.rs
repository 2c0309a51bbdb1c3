use super::super::hit::SurfacePoints;
use crate::maths::vec3::{self, Vec3x8};
use crate::tracer::scene::{Material, NO_TEXTURE, Scattering, Scene, SceneData, Surface, Texture, Triangle};
use crate::tracer::trace::{Hits8, Rays8};
use wide::{f32x8, u32x8};

/// The triangle x, y above 0, z = 0, front up, of coordinates u along `u` and v along `v` of its plane, all of which has the
/// normal `texel`, looked at along `direction`: the shading normal.
fn bent(
    texel: [f32; 3],
    texture: Texture,
    uv: [[f32; 2]; 3],
    direction: [f32; 3],
    kind: Scattering,
) -> [f32; 3] {
    let triangles = [Triangle { corners: [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] }];
    let surfaces = [Surface { normals: [[0.0, 0.0, 1.0]; 3], uv, material: 0 }];
    let materials = [Material { scattering: kind, ..Material::default() }];
    let (texels, textures) = ([texel], [texture]);
    let scene = Scene::new(SceneData {
        triangles: &triangles,
        surfaces: &surfaces,
        materials: &materials,
        normal_maps: &[0],
        textures: &textures,
        texels: &texels,
        ..SceneData::default()
    })
    .unwrap();
    let direction = vec3::normalized(direction).unwrap();
    let rays = Rays8 { direction: Vec3x8::splat(direction), ..Rays8::default() };
    let third = f32x8::splat(1.0 / 3.0);
    let hits = Hits8 { t: f32x8::ONE, u: third, v: third, triangle: u32x8::ZERO };
    let n = SurfacePoints::at(&scene, &rays, &hits).normal;
    [n.x, n.y, n.z].map(|row| row.to_array()[3])
}

fn near(a: [f32; 3], b: [f32; 3]) -> bool {
    (0..3).all(|c| (a[c] - b[c]).abs() < 1e-5)
}

const ONE: Texture = Texture { width: 1, height: 1, ..Texture::EMPTY };
const UPRIGHT: [[f32; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
const DOWN: [f32; 3] = [0.0, 0.0, -1.0];
const ROUGH: Scattering = Scattering::Rough;

#[test]
fn normals_lean_along_the_coordinates() {
    let lean = [0.6, 0.0, 0.8];
    assert!(near(bent(lean, ONE, UPRIGHT, DOWN, ROUGH), lean));
    assert!(near(bent([0.0, 0.6, 0.8], ONE, UPRIGHT, DOWN, ROUGH), [0.0, 0.6, 0.8]));
    // Any length will do.
    assert!(near(bent([0.0, 1.8, 2.4], ONE, UPRIGHT, DOWN, ROUGH), [0.0, 0.6, 0.8]));
    // u along y, v along −x; then u along y and v along x: mirrored.
    let turned = [[0.0, 0.0], [0.0, -1.0], [1.0, 0.0]];
    assert!(near(bent(lean, ONE, turned, DOWN, ROUGH), [0.0, 0.6, 0.8]));
    assert!(near(bent([0.0, 0.6, 0.8], ONE, turned, DOWN, ROUGH), [-0.6, 0.0, 0.8]));
    let mirrored = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]];
    assert!(near(bent(lean, ONE, mirrored, DOWN, ROUGH), [0.0, 0.6, 0.8]));
    assert!(near(bent([0.0, 0.6, 0.8], ONE, mirrored, DOWN, ROUGH), [0.6, 0.0, 0.8]));
    // A texture that lies backwards.
    let backwards = Texture { scale: [-2.0, 1.0], ..ONE };
    assert!(near(bent(lean, backwards, UPRIGHT, DOWN, ROUGH), [-0.6, 0.0, 0.8]));
}

#[test]
fn behind_a_surface_its_normals_are_turned_round() {
    assert!(near(bent([0.6, 0.0, 0.8], ONE, UPRIGHT, [0.0, 0.0, 1.0], ROUGH), [-0.6, 0.0, -0.8]));
}

#[test]
fn normals_that_look_away_are_raised() {
    // Seen along −x nearly in the plane, a normal that leans to −x.
    let normal = bent([-0.8, 0.0, 0.6], ONE, UPRIGHT, [-0.995, 0.0, -0.1], ROUGH);
    let eye = vec3::normalized([0.995, 0.0, 0.1]).unwrap();
    assert!((vec3::dot(normal, eye) - super::LEAST_COSINE).abs() < 1e-5, "{normal:?}");
    assert!(normal[2] > 0.9 && (vec3::dot(normal, normal) - 1.0).abs() < 1e-5);
}

#[test]
fn what_has_no_map_no_coordinates_or_no_direction_stays() {
    let up = [0.0, 0.0, 1.0];
    assert!(near(bent([0.6, 0.0, 0.8], ONE, [[0.5; 2]; 3], DOWN, ROUGH), up));
    assert!(near(bent([0.6, 0.0, 0.8], ONE, [[f32::NAN; 2]; 3], DOWN, ROUGH), up));
    assert!(near(bent([0.0; 3], ONE, UPRIGHT, DOWN, ROUGH), up));
    assert!(near(bent([0.6, 0.0, 0.8], ONE, UPRIGHT, DOWN, Scattering::Mirror), up));
    let known = |maps| {
        let materials = [Material::default(); 2];
        let textures = [ONE];
        let texels = [[0.0; 3]];
        let data =
            SceneData { materials: &materials, textures: &textures, texels: &texels, ..SceneData::default() };
        Scene::new(SceneData { normal_maps: maps, ..data }).is_ok()
    };
    assert!(known(&[NO_TEXTURE, 0]) && known(&[]) && !known(&[0]) && !known(&[0, 1]));
}
