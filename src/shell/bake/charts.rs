//! Charts: connected pieces of surfaces that are laid flat by a projection.
//!
//! A chart grows from a triangle over shared edges as long as normals stay within 45° of the first one's, along which it is
//! projected: areas shrink by at most 1.42. What mirrors or refracts has no irradiance to keep and is left out, as are
//! triangles without area.

use crate::scene::LoadedScene;
use glam::Vec3;
use pmcip_core::tracer::scene::{Scattering, Triangle};
use std::collections::HashMap;

/// Least cosine between the normals of a chart's triangles and that of its first.
const LEAST_COSINE: f32 = core::f32::consts::FRAC_1_SQRT_2;

/// A piece of surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Triangles, by their index in the scene, in the order in which they were reached.
    pub triangles: Vec<u32>,
    /// Directions in which columns and rows of the lightmap run.
    pub axes: [Vec3; 2],
    /// Least coordinates along the axes, in scene units.
    pub origin: [f32; 2],
    /// Extents along the axes.
    pub extent: [f32; 2],
}

impl Chart {
    fn new(scene: &LoadedScene, triangles: Vec<u32>, normal: Vec3) -> Chart {
        let (u, v) = normal.any_orthonormal_pair();
        let (mut least, mut most) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        for corner in triangles.iter().flat_map(|i| scene.triangles[*i as usize].corners) {
            for (k, axis) in [u, v].into_iter().enumerate() {
                let at = axis.dot(corner.into());
                (least[k], most[k]) = (least[k].min(at), most[k].max(at));
            }
        }
        let extent = [most[0] - least[0], most[1] - least[1]];
        Chart { triangles, axes: [u, v], origin: least, extent }
    }

    /// Where a point lies, in scene units from the chart's corner.
    pub fn flat(&self, point: [f32; 3]) -> [f32; 2] {
        [0, 1].map(|k| self.axes[k].dot(point.into()) - self.origin[k])
    }

    /// Two charts of half the triangles each: for one that lies on itself.
    pub(super) fn halves(&self, scene: &LoadedScene) -> [Chart; 2] {
        let normal = self.axes[0].cross(self.axes[1]);
        let (first, second) = self.triangles.split_at(self.triangles.len() / 2);
        [first, second].map(|triangles| Chart::new(scene, triangles.to_vec(), normal))
    }
}

/// The charts of all surfaces that have an irradiance.
pub fn charts(scene: &LoadedScene) -> Vec<Chart> {
    let normals: Vec<Option<Vec3>> = (0..scene.triangles.len()).map(|i| normal(scene, i)).collect();
    let edges = edges(&scene.triangles);
    let mut taken: Vec<bool> = normals.iter().map(Option::is_none).collect();
    let mut charts = Vec::new();
    for first in 0..taken.len() {
        let (false, Some(axis)) = (taken[first], normals[first]) else { continue };
        taken[first] = true;
        let mut triangles = vec![first as u32];
        let mut next = 0;
        while let Some(&from) = triangles.get(next) {
            next += 1;
            let sides = sides(&scene.triangles[from as usize]);
            for &to in sides.iter().filter_map(|side| edges.get(side)).flatten() {
                let fits = normals[to as usize].is_some_and(|normal| normal.dot(axis) > LEAST_COSINE);
                if fits && !taken[to as usize] && scene.objects[to as usize] == scene.objects[first] {
                    taken[to as usize] = true;
                    triangles.push(to);
                }
            }
        }
        charts.push(Chart::new(scene, triangles, axis));
    }
    charts
}

/// The normal of a triangle that has an irradiance.
pub(super) fn normal(scene: &LoadedScene, i: usize) -> Option<Vec3> {
    let material = &scene.materials[scene.surfaces[i].material as usize];
    let [a, b, c] = scene.triangles[i].corners.map(Vec3::from);
    (material.scattering == Scattering::Rough).then(|| (b - a).cross(c - a).try_normalize()).flatten()
}

/// An edge by its ends, in either direction.
type Side = [[u32; 3]; 2];

/// The triangles at each edge.
fn edges(triangles: &[Triangle]) -> HashMap<Side, Vec<u32>> {
    let mut edges: HashMap<Side, Vec<u32>> = HashMap::new();
    for (i, triangle) in (0..).zip(triangles) {
        for side in sides(triangle) {
            edges.entry(side).or_default().push(i);
        }
    }
    edges
}

fn sides(triangle: &Triangle) -> [Side; 3] {
    // A zero is a zero, whatever its sign.
    let key = |k: usize| triangle.corners[k].map(|x| (x + 0.0).to_bits());
    [(0, 1), (1, 2), (2, 0)].map(|(a, b)| {
        let mut side = [key(a), key(b)];
        side.sort_unstable();
        side
    })
}
