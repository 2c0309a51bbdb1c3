//! The statue: a seated sage on a lotus, on a carved plinth.

mod body;
mod head;
mod lotus;
mod plinth;
mod robe;

use super::mesh::Mesh;
use super::sdf::join;
use super::writer::Files;
use super::{noise, polygonise};
use glam::{Vec2, Vec3};

/// The sources that the statue depends on.
pub const SOURCES: &str = concat!(
    include_str!("mod.rs"),
    include_str!("body.rs"),
    include_str!("head.rs"),
    include_str!("lotus.rs"),
    include_str!("plinth.rs"),
    include_str!("robe.rs"),
);

/// Side of a cell in metres at detail 1: about 500,000 triangles.
const STEP: f32 = 0.007;
/// Half the side of the floor in metres, along x and z.
const FLOOR: (f32, f32) = (14.0, 14.0);

/// Height of the seat above the floor.
const SEAT: f32 = 0.72;
/// The height of the statue, with a margin.
const TOP: f32 = 2.05;
/// Half the width and half the depth of the box around the statue.
const HALF: (f32, f32) = (0.72, 0.62);

/// Sandstone, and a floor of a darker kind.
const MATERIALS: &str = "newmtl stone
Kd 0.62 0.57 0.50
Ks 0.04 0.04 0.04
Ns 14

newmtl floor
Kd 0.50 0.47 0.43
";

/// Statue and floor in OBJ files of their own.
pub fn files(detail: f32) -> Files {
    let mut files = Files::default();
    files.add_text("materials.mtl", MATERIALS);
    files.add_obj("statue", &[("stone", &mesh(detail))]);
    files.add_obj("floor", &[("floor", &floor())]);
    files
}

fn floor() -> Mesh {
    let mut mesh = Mesh::default();
    let corners = [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    let quad = corners
        .map(|(x, z)| mesh.add_vertex(Vec3::new(FLOOR.0 * x, 0.0, FLOOR.1 * z), Vec3::Y, Vec2::new(x, z)));
    mesh.add_quad(quad);
    mesh
}

/// The statue's surface; it stands on y = 0 and looks along +z.
pub fn mesh(detail: f32) -> Mesh {
    let low = Vec3::new(-HALF.0, -0.05, -HALF.1);
    let high = Vec3::new(HALF.0, TOP, HALF.1);
    polygonise::surface(solid, low, high, STEP / detail)
}

/// The whole statue; below the floor there is nothing.
fn solid(p: Vec3) -> f32 {
    let q = p - Vec3::Y * SEAT;
    let stone = join(figure(q), lotus::solid(q), 0.01).min(plinth::solid(q));
    let chisel = 0.0012 * noise::fractal(p * 45.0, 2);
    (stone + chisel).max(0.002 - p.y)
}

/// The figure, its seat at the origin.
fn figure(p: Vec3) -> f32 {
    let skin = join(body::bare(p), head::solid(p), 0.03);
    join(skin, robe::solid(p), 0.006).min(body::hands_and_foot(p))
}
