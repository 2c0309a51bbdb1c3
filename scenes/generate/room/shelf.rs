//! The bookcase: boards, books, and small things between them.

use super::super::mesh::Mesh;
use super::super::noise::{between, hash};
use super::super::shapes::{at, ball, block, lathe};
use super::set::Set;
use glam::{Affine3A, Quat, Vec2, Vec3, vec2, vec3};

/// Half its width, its height and half its depth.
const SIZE: (f32, f32, f32) = (0.88, 2.05, 0.16);
const SHELVES: u32 = 5;
/// Kinds of book in the texture.
pub const BOOKS: u32 = 16;

/// A bookcase that looks along +z, on the floor at the origin.
pub fn build() -> Set {
    let (half, height, depth) = SIZE;
    let mut set = Set::default();
    for x in [-half, 0.0, half] {
        set.place("walnut", &block(vec3(0.012, 0.5 * height, depth), 0.003, 1), at(x, 0.5 * height, 0.0));
    }
    set.place("walnut", &block(vec3(half, 0.5 * height, 0.006), 0.002, 1), at(0.0, 0.5 * height, -depth));
    let pitch = (height - 0.10) / SHELVES as f32;
    for i in 0..=SHELVES {
        let y = 0.08 + pitch * i as f32;
        set.place("walnut", &block(vec3(half, 0.011, depth), 0.003, 1), at(0.0, y, 0.0));
        if i == SHELVES {
            continue;
        }
        for (side, x) in [(0, -half + 0.02), (1, 0.02)] {
            fill(&mut set, i * 2 + side, vec3(x, y + 0.011, 0.0), half - 0.04, pitch - 0.03);
        }
    }
    set
}

/// Fills a compartment from its lower left corner: books, then perhaps something else in what is left.
fn fill(set: &mut Set, key: u32, corner: Vec3, width: f32, height: f32) {
    let books_end = width * [1.0, 0.55, 0.72, 1.0, 0.62][(key % 5) as usize];
    let (mut x, mut i) = (0.0, key * 64);
    loop {
        i += 1;
        let half = vec3(
            between(i, 0.009, 0.024),
            between(i + 1000, 0.33, 0.46) * height,
            between(i + 2000, 0.08, 0.115),
        );
        if x + 2.0 * half.x > books_end {
            break;
        }
        let lean = if hash(i + 3000) > 0.93 { 0.06 } else { 0.0 };
        let place = Affine3A::from_rotation_translation(
            Quat::from_rotation_z(lean),
            corner
                + vec3(
                    x + half.x + lean * half.y,
                    half.y,
                    0.03 + half.z - 0.11 + between(i + 4000, 0.0, 0.02),
                ),
        );
        set.place("book", &book(half, i), place);
        set.place(
            "paper",
            &block(half - vec3(0.003, 0.004, 0.003), 0.001, 1),
            place * at(0.0, 0.003, -0.004),
        );
        x += 2.0 * half.x + 0.001 + 2.2 * lean * half.y;
    }
    let left = width - books_end;
    let middle = corner + vec3(books_end + 0.5 * left, 0.0, 0.02);
    if left > 0.15 {
        thing(set, key, middle, 0.38 * left);
    }
}

/// Covers and spine with the texture of one kind of book.
fn book(half: Vec3, key: u32) -> Mesh {
    let kind = (hash(key + 5000) * BOOKS as f32).floor();
    let mut mesh = block(half, 0.0035f32.min(0.4 * half.x), 2);
    for (uv, (p, n)) in mesh.uvs.iter_mut().zip(mesh.positions.iter().zip(&mesh.normals)) {
        let across = if n.z > 0.5 { 0.5 + 0.4 * p.x / half.x } else { 0.02 };
        let up = if n.z > 0.5 { 0.5 + 0.48 * p.y / half.y } else { 0.5 };
        *uv = (vec2(kind, 0.0) + Vec2::new(across.clamp(0.02, 0.98), 0.0)) / vec2(BOOKS as f32, 1.0)
            + vec2(0.0, up);
    }
    mesh
}

/// A vase, a bowl or a ball on a stand, of about the given radius.
fn thing(set: &mut Set, key: u32, base: Vec3, radius: f32) {
    let r = radius.min(0.085);
    let place = Affine3A::from_translation(base);
    match key % 3 {
        0 => set.place("celadon", &vase(r, 3.0 * r, 0.45), place),
        1 => set.place("copper", &ball(r, 48), place * at(0.0, r, 0.0)),
        _ => set.place("porcelain", &vase(r, 2.2 * r, 0.6), place),
    }
}

/// A vase with an open neck of `neck` times its radius.
pub fn vase(radius: f32, height: f32, neck: f32) -> Mesh {
    const STEPS: usize = 40;
    let outline = |t: f32| {
        let belly = (std::f32::consts::PI * (0.12 + 0.80 * t.powf(0.8))).sin().powf(0.8);
        let lip = neck * ((t - 0.86) / 0.14).max(0.0).powi(2) * 0.35;
        radius * (belly * (1.0 - 0.25 * t) + neck * t * t * 0.55 + lip).min(1.1)
    };
    let wall = 0.05 * radius + 0.001;
    let outer = (0..=STEPS).map(|i| i as f32 / STEPS as f32).map(|t| (outline(t), height * t));
    let inner = (2..=STEPS)
        .rev()
        .map(|i| i as f32 / STEPS as f32)
        .map(|t| (outline(t) - wall, height * t - 0.3 * wall));
    let bottom = inner.clone().next_back().map_or(wall, |(_, y)| y);
    let profile: Vec<_> =
        std::iter::once((0.0, 0.0)).chain(outer).chain(inner).chain(std::iter::once((0.0, bottom))).collect();
    lathe(&profile, 64)
}
