//! Primitives: rounded boxes, turned profiles, tubes, sheets. Lengths in metres; outside is the front.

use super::mesh::Mesh;
use glam::{Affine3A, Quat, Vec2, Vec3, vec2, vec3};
use std::f32::consts::{FRAC_PI_4, TAU};

/// A translation.
pub fn at(x: f32, y: f32, z: f32) -> Affine3A {
    Affine3A::from_translation(vec3(x, y, z))
}

/// A turn about the y axis by `degrees`, then a translation.
pub fn turned_at(degrees: f32, x: f32, y: f32, z: f32) -> Affine3A {
    Affine3A::from_rotation_translation(Quat::from_rotation_y(degrees.to_radians()), vec3(x, y, z))
}

/// A box about the origin whose edges are rounded by `round` in `steps` steps to either side of the diagonal.
/// Texture coordinates are lengths along the faces.
pub fn block(half: Vec3, round: f32, steps: u32) -> Mesh {
    let inner = half - round;
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let (n, u) = (Vec3::AXES[axis] * sign, Vec3::AXES[(axis + 1) % 3]);
            let v = n.cross(u);
            let (us, vs) = (lines(half.dot(u), round, steps), lines(half.dot(v.abs()), round, steps));
            add_sheet(&mut mesh, us.len(), vs.len(), |i, j| {
                let on_face = half.dot(n.abs()) * n + us[i] * u + vs[j] * v;
                let core = on_face.clamp(-inner, inner);
                let normal = (on_face - core).normalize_or(n);
                (core + round * normal, normal, vec2(us[i], vs[j]))
            });
        }
    }
    mesh
}

/// Coordinates of the grid lines over a face of half size `half`, such that the rounding is even.
fn lines(half: f32, round: f32, steps: u32) -> Vec<f32> {
    let offset = |i: u32| half - round + round * (FRAC_PI_4 * i as f32 / steps as f32).tan();
    let rising = (0..=steps).map(offset);
    (0..=steps).rev().map(|i| -offset(i)).chain(rising).collect()
}

/// Adds a grid of `columns` × `rows` vertices and the quads between them; counter-clockwise is from column to row.
pub fn add_sheet(
    mesh: &mut Mesh,
    columns: usize,
    rows: usize,
    vertex: impl Fn(usize, usize) -> (Vec3, Vec3, Vec2),
) {
    let first = mesh.positions.len() as u32;
    for j in 0..rows {
        for i in 0..columns {
            let (position, normal, uv) = vertex(i, j);
            mesh.add_vertex(position, normal, uv);
        }
    }
    let index = |i: usize, j: usize| first + (j * columns + i) as u32;
    for j in 1..rows {
        for i in 1..columns {
            mesh.add_quad([index(i - 1, j - 1), index(i, j - 1), index(i, j), index(i - 1, j)]);
        }
    }
}

/// A sheet given by a map from the unit square, its normal along ∂u × ∂v.
pub fn sheet(columns: usize, rows: usize, map: impl Fn(f32, f32) -> Vec3) -> Mesh {
    const STEP: f32 = 1e-3;
    let mut mesh = Mesh::default();
    add_sheet(&mut mesh, columns + 1, rows + 1, |i, j| {
        let (u, v) = (i as f32 / columns as f32, j as f32 / rows as f32);
        let along = map(u + STEP, v) - map(u - STEP, v);
        let across = map(u, v + STEP) - map(u, v - STEP);
        (map(u, v), along.cross(across).normalize_or(Vec3::Y), vec2(u, v))
    });
    mesh.flatten_backward();
    mesh
}

/// The rectangle with half edges `u` and `v`, its front along `u` × `v`; texture coordinates run from 0 to 1.
pub fn panel(centre: Vec3, u: Vec3, v: Vec3) -> Mesh {
    sheet(1, 1, |s, t| centre + (2.0 * s - 1.0) * u + (2.0 * t - 1.0) * v)
}

/// A solid of revolution about the y axis: `profile` is radius and height, listed so that the outside is on its
/// right (upwards on the outer side); it is closed where it begins and ends on the axis. Corners of more than about
/// 50° stay sharp.
pub fn lathe(profile: &[(f32, f32)], sides: usize) -> Mesh {
    const SHARP: f32 = 0.65;
    let points: Vec<Vec2> = profile.iter().map(|&(r, y)| vec2(r, y)).collect();
    let normal = |a: Vec2, b: Vec2| (b - a).perp().normalize_or_zero() * -1.0;
    let normals: Vec<Vec2> = points.windows(2).map(|w| normal(w[0], w[1])).collect();
    let blend = |i: usize, j: usize| {
        let (own, other) = (normals[i], normals.get(j).copied().unwrap_or(normals[i]));
        if own.dot(other) > SHARP { (own + other).normalize() } else { own }
    };
    let lengths: f32 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
    let (mut mesh, mut along) = (Mesh::default(), 0.0);
    for i in 0..normals.len() {
        let (a, b) = (points[i], points[i + 1]);
        let (na, nb) = (blend(i, i.wrapping_sub(1)), blend(i, i + 1));
        let (va, vb) = (along / lengths, (along + a.distance(b)) / lengths);
        along += a.distance(b);
        add_band(&mut mesh, sides, [(a, na, va), (b, nb, vb)]);
    }
    mesh
}

/// A ring of quads between two circles, or of triangles where one is a point.
fn add_band(mesh: &mut Mesh, sides: usize, ends: [(Vec2, Vec2, f32); 2]) {
    let first = mesh.positions.len() as u32;
    for i in 0..=sides {
        let angle = TAU * (i % sides) as f32 / sides as f32;
        let turn = |p: Vec2| vec3(p.x * angle.sin(), p.y, p.x * angle.cos());
        for (p, n, v) in ends {
            mesh.add_vertex(turn(p), turn(n), vec2(i as f32 / sides as f32, v));
        }
    }
    for i in 0..sides as u32 {
        let [a, b, c, d] = [0, 2, 3, 1].map(|k| first + 2 * i + k);
        match (ends[0].0.x == 0.0, ends[1].0.x == 0.0) {
            (true, true) => {}
            (true, false) => mesh.triangles.push([a, c, d]),
            (false, true) => mesh.triangles.push([a, b, c]),
            (false, false) => mesh.add_quad([a, b, c, d]),
        }
    }
}

/// A ball.
pub fn ball(radius: f32, sides: usize) -> Mesh {
    let rings = sides / 2;
    let angle = |i: usize| TAU * i as f32 / (2 * rings) as f32;
    let point = |i: usize| if i == 0 || i == rings { 0.0 } else { radius * angle(i).sin() };
    let profile: Vec<_> = (0..=rings).map(|i| (point(i), -radius * angle(i).cos())).collect();
    lathe(&profile, sides)
}

/// An upright cylinder from `low` to `high` with slightly broken edges.
pub fn drum(radius: f32, low: f32, high: f32, sides: usize) -> Mesh {
    let chamfer = (0.1 * radius).min(0.004).min(0.3 * (high - low));
    let profile = [
        (0.0, low),
        (radius - chamfer, low),
        (radius, low + chamfer),
        (radius, high - chamfer),
        (radius - chamfer, high),
        (0.0, high),
    ];
    lathe(&profile, sides)
}

/// A tube through points, each with its radius, closed by flat ends.
pub fn tube(path: &[(Vec3, f32)], sides: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let direction = |i: usize| {
        let (before, after) = (path[i.saturating_sub(1)].0, path[(i + 1).min(path.len() - 1)].0);
        (after - before).normalize()
    };
    let mut side = direction(0).any_orthonormal_vector();
    let mut frames = Vec::new();
    for i in 0..path.len() {
        let along = direction(i);
        side = side.reject_from(along).normalize();
        frames.push((along, side, along.cross(side)));
    }
    let around = |i: usize, k: usize| {
        let angle = TAU * (k % sides) as f32 / sides as f32;
        frames[i].1 * angle.cos() + frames[i].2 * angle.sin()
    };
    add_sheet(&mut mesh, sides + 1, path.len(), |k, i| {
        let out = around(i, k);
        (path[i].0 + path[i].1 * out, out, vec2(k as f32 / sides as f32, i as f32))
    });
    for (i, sign) in [(0, -1.0), (path.len() - 1, 1.0)] {
        let normal = frames[i].0 * sign;
        let centre = mesh.add_vertex(path[i].0, normal, Vec2::ZERO);
        let rim: Vec<u32> = (0..sides)
            .map(|k| mesh.add_vertex(path[i].0 + path[i].1 * around(i, k), normal, Vec2::ZERO))
            .collect();
        for k in 0..sides {
            let (a, b) = (rim[k], rim[(k + 1) % sides]);
            mesh.triangles.push(if sign > 0.0 { [centre, a, b] } else { [centre, b, a] });
        }
    }
    mesh
}

/// The mesh with texture coordinates along the two axes that each triangle faces least, `scale` to a metre.
pub fn with_box_uv(mesh: &Mesh, scale: f32) -> Mesh {
    let mut out = Mesh::default();
    let mut copies = vec![[u32::MAX; 3]; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let facing = mesh.area_normal(*triangle).abs();
        let axis = (0..3).max_by(|a, b| facing[*a].total_cmp(&facing[*b])).unwrap_or(0);
        let triangle = triangle.map(|i| {
            let copy = &mut copies[i as usize][axis];
            if *copy == u32::MAX {
                let p = mesh.positions[i as usize];
                let uv = [vec2(p.z, p.y), vec2(p.x, p.z), vec2(p.x, p.y)][axis];
                *copy = out.add_vertex(p, mesh.normals[i as usize], uv * scale);
            }
            *copy
        });
        out.triangles.push(triangle);
    }
    out
}
