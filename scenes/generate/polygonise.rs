//! Triangles from a field: naive surface nets (Gibson 1998), one vertex a cell, pulled onto the surface.
//!
//! Blocks of cells that the surface cannot reach are skipped, which needs a field that does not overstate the
//! distance by much. Work is shared among threads layer by layer; the mesh does not depend on their number.

use super::mesh::Mesh;
use glam::{UVec3, Vec2, Vec3};
use rayon::prelude::*;

/// Cells along the side of a block that is skipped or sampled as a whole.
const BLOCK: u32 = 8;
/// How much the field may overstate a distance, as a factor and in metres.
const SLACK: (f32, f32) = (1.3, 0.02);
const NONE: u32 = u32::MAX;

/// A solid's signed distance at a point, negative inside.
pub trait Field: Fn(Vec3) -> f32 + Sync {}
impl<F: Fn(Vec3) -> f32 + Sync> Field for F {}

/// Cells of a box in space.
struct Grid {
    low: Vec3,
    step: f32,
    /// Cells along each axis, a multiple of [`BLOCK`].
    cells: UVec3,
}

impl Grid {
    fn new(low: Vec3, high: Vec3, step: f32) -> Grid {
        let blocks = ((high - low) / (step * BLOCK as f32)).ceil().as_uvec3();
        Grid { low, step, cells: blocks.max(UVec3::ONE) * BLOCK }
    }

    fn position(&self, corner: UVec3) -> Vec3 {
        self.low + self.step * corner.as_vec3()
    }

    /// Corners of cells along each axis.
    fn corners(&self) -> UVec3 {
        self.cells + 1
    }

    fn index(&self, corner: UVec3) -> usize {
        let n = self.corners().as_usizevec3();
        let c = corner.as_usizevec3();
        (c.z * n.y + c.y) * n.x + c.x
    }

    /// The corners of one layer.
    fn layer(&self, z: u32) -> impl Iterator<Item = UVec3> + use<> {
        let n = self.corners();
        (0..n.y).flat_map(move |y| (0..n.x).map(move |x| UVec3::new(x, y, z)))
    }

    /// The field at every corner; where no surface is near, a value of the right sign.
    fn sample(&self, field: &impl Field) -> Vec<f32> {
        let blocks = self.cells / BLOCK;
        let (side, reach) = (self.step * BLOCK as f32, 0.5 * 3f32.sqrt() * self.step * BLOCK as f32);
        let count = (blocks.x * blocks.y * blocks.z) as usize;
        let centre = |i: usize| {
            let i = i as u32;
            let block = UVec3::new(i % blocks.x, i / blocks.x % blocks.y, i / blocks.x / blocks.y);
            self.low + side * (block.as_vec3() + 0.5)
        };
        let centres: Vec<f32> = (0..count).into_par_iter().map(|i| field(centre(i))).collect();
        let block_of = |b: UVec3| centres[((b.z * blocks.y + b.y) * blocks.x + b.x) as usize];
        let far = |d: f32| d.abs() > SLACK.0 * reach + SLACK.1;
        let value = |corner: UVec3| {
            let (after, before) =
                ((corner / BLOCK).min(blocks - 1), corner.saturating_sub(UVec3::ONE) / BLOCK);
            let around = [before, after];
            let touched = (0..8).map(|i| UVec3::new(around[i & 1].x, around[i >> 1 & 1].y, around[i >> 2].z));
            if touched.into_iter().all(|b| far(block_of(b))) {
                block_of(after)
            } else {
                field(self.position(corner))
            }
        };
        let layers = (0..self.corners().z).into_par_iter();
        layers.flat_map_iter(|z| self.layer(z).map(value).collect::<Vec<_>>()).collect()
    }
}

/// The surface of `field` inside the box from `low` to `high`, in cells of side `step`, its normals outwards.
pub fn surface(field: impl Field, low: Vec3, high: Vec3, step: f32) -> Mesh {
    let grid = Grid::new(low, high, step);
    let values = grid.sample(&field);
    let crossed = crossed_cells(&grid, &values);
    let mut vertex_of = vec![NONE; values.len()];
    for (i, cell) in crossed.iter().enumerate() {
        vertex_of[grid.index(*cell)] = i as u32;
    }
    let mut mesh = Mesh {
        positions: crossed.par_iter().map(|cell| vertex(&grid, &values, &field, *cell)).collect(),
        normals: vec![Vec3::Y; crossed.len()],
        uvs: vec![Vec2::ZERO; crossed.len()],
        triangles: Vec::new(),
    };
    for cell in &crossed {
        add_faces(&mut mesh, &grid, &values, &vertex_of, *cell);
    }
    unfold(&mut mesh, |i| crossing(&grid, &values, crossed[i]), |p| gradient(&field, p, 0.5 * step));
    mesh
}

/// Sets the normals by the gradient. Where a furrow is narrower than a cell, vertices that were pulled to its walls
/// fold the surface over: those go back to where the cell's crossings are. What is still folded then becomes flat.
fn unfold(mesh: &mut Mesh, plain: impl Fn(usize) -> Vec3, gradient: impl Fn(Vec3) -> Vec3 + Sync) {
    const ROUNDS: u32 = 4;
    mesh.normals = mesh.positions.par_iter().map(|p| gradient(*p)).collect();
    for _ in 0..ROUNDS {
        mesh.steady_normals();
        let folded: Vec<usize> = mesh.backward_triangles().flat_map(|t| t.map(|i| i as usize)).collect();
        for i in folded {
            mesh.positions[i] = plain(i);
            mesh.normals[i] = Vec3::ZERO;
        }
    }
    mesh.steady_normals();
    mesh.flatten_backward();
}

fn is_inside(values: &[f32], grid: &Grid, corner: UVec3) -> bool {
    values[grid.index(corner)] < 0.0
}

/// The cells that have corners on both sides.
fn crossed_cells(grid: &Grid, values: &[f32]) -> Vec<UVec3> {
    let crossed = |cell: &UVec3| {
        let inside = corners(*cell).filter(|c| is_inside(values, grid, *c)).count();
        inside != 0 && inside != 8
    };
    let cells = |z| grid.layer(z).filter(|c| c.cmplt(grid.cells).all());
    (0..grid.cells.z)
        .into_par_iter()
        .flat_map_iter(|z| cells(z).filter(crossed).collect::<Vec<_>>())
        .collect()
}

fn corners(cell: UVec3) -> impl Iterator<Item = UVec3> {
    (0..8).map(move |i| cell + UVec3::new(i & 1, i >> 1 & 1, i >> 2))
}

/// The mean of the crossings of a cell's edges.
fn crossing(grid: &Grid, values: &[f32], cell: UVec3) -> Vec3 {
    let (mut sum, mut count) = (Vec3::ZERO, 0.0);
    for a in corners(cell) {
        for b in UVec3::AXES.map(|axis| a + axis).into_iter().filter(|b| b.cmple(cell + 1).all()) {
            let (va, vb) = (values[grid.index(a)], values[grid.index(b)]);
            if (va < 0.0) != (vb < 0.0) {
                sum += grid.position(a).lerp(grid.position(b), va / (va - vb));
                count += 1.0;
            }
        }
    }
    inside_cell(grid, cell, sum / count)
}

/// `p` moved into the cell and away from its faces, so that no two vertices can meet.
fn inside_cell(grid: &Grid, cell: UVec3, p: Vec3) -> Vec3 {
    let margin = 0.05 * grid.step;
    p.clamp(grid.position(cell) + margin, grid.position(cell + 1) - margin)
}

/// The crossing after two Newton steps towards the surface, without leaving the cell.
fn vertex(grid: &Grid, values: &[f32], field: &impl Field, cell: UVec3) -> Vec3 {
    let mut p = crossing(grid, values, cell);
    for _ in 0..2 {
        p = inside_cell(grid, cell, p - field(p) * gradient(field, p, 0.25 * grid.step));
    }
    p
}

/// The unit direction in which the field rises, by central differences over the corners of a tetrahedron.
fn gradient(field: &impl Field, p: Vec3, reach: f32) -> Vec3 {
    let arms =
        [Vec3::new(1.0, -1.0, -1.0), Vec3::new(-1.0, -1.0, 1.0), Vec3::new(-1.0, 1.0, -1.0), Vec3::ONE];
    arms.into_iter().map(|arm| arm * field(p + reach * arm)).sum::<Vec3>().normalize_or(Vec3::Y)
}

/// Two triangles for each of the three edges from the cell's low corner that the surface crosses.
fn add_faces(mesh: &mut Mesh, grid: &Grid, values: &[f32], vertex_of: &[u32], cell: UVec3) {
    let axes = UVec3::AXES;
    for i in 0..3 {
        let (along, u, v) = (axes[i], axes[(i + 1) % 3], axes[(i + 2) % 3]);
        let inside = is_inside(values, grid, cell);
        // An edge on the border of the grid lacks cells around it: the solid must lie within.
        let on_border = cell.dot(u) == 0 || cell.dot(v) == 0;
        if on_border || inside == is_inside(values, grid, cell + along) {
            continue;
        }
        let at = |c: UVec3| vertex_of[grid.index(c)];
        let mut quad = [at(cell - u - v), at(cell - v), at(cell), at(cell - u)];
        if !inside {
            quad.reverse();
        }
        mesh.add_quad(quad);
    }
}
