//! A tree over many lights: groups with bounded position and direction, eight to a node.
//!
//! [`build`] makes it and writes each light's path; how it is walked is the affair of [`shade`](crate::tracer::shade).

mod build;

pub use build::{build, required};

use super::{Error, SceneData};
use crate::maths::vec3;
use bytemuck::{Pod, Zeroable};

/// Eight groups of lights: a node of the light tree.
///
/// A group is bounded by a sphere around its triangles and by a cone around their normals. Children that are there
/// come first.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LightNode8 {
    /// Centres of the spheres, by axis and child.
    pub centre: [[f32; 8]; 3],
    /// Radii of the spheres.
    pub radius: [f32; 8],
    /// Unit axes of the cones, by axis and child.
    pub axis: [[f32; 8]; 3],
    /// Cosines of the cones' half angles.
    pub cosine: [f32; 8],
    /// Shares of the power (luminance times area) of all lights, above 0. 0: the child is not there.
    pub power: [f32; 8],
    /// For a group of one light [`LIGHT_LEAF`] plus its index in [`SceneData::lights`]; else the index of the
    /// group's node, which is above this node's own.
    pub child: [u32; 8],
}

/// What tells a single light from a group in [`LightNode8::child`].
pub const LIGHT_LEAF: u32 = 1 << 31;

/// Levels of nodes a light tree may have: [`Light::path`] has room for no more.
pub const MAX_LIGHT_DEPTH: u32 = 10;

/// Which child a path takes at a level.
#[inline(always)]
pub(crate) fn slot(path: u32, level: u32) -> usize {
    (path >> (3 * level)) as usize & 7
}

/// Checks that the tree, if there is one, leads to every light, and that every group holds its lights.
pub(crate) fn check(data: &SceneData<'_>) -> Result<(), Error> {
    if data.light_nodes.is_empty() {
        return Ok(());
    }
    for (i, node) in data.light_nodes.iter().enumerate() {
        if !node_is_valid(data, i, node) {
            return Err(Error::LightNode(i));
        }
    }
    if !has_one_place_each(data) {
        return Err(Error::LightTree);
    }
    let rises = |i: usize| i == 0 || data.lights[i - 1].triangle < data.lights[i].triangle;
    match (0..data.lights.len()).find(|&i| !(rises(i) && is_held(data, i))) {
        Some(i) => Err(Error::LightPath(i)),
        None => Ok(()),
    }
}

fn node_is_valid(data: &SceneData<'_>, index: usize, node: &LightNode8) -> bool {
    let used = node.power.iter().take_while(|power| **power > 0.0).count();
    let child_is_valid = |child: u32| match child & LIGHT_LEAF {
        0 => child as usize > index && (child as usize) < data.light_nodes.len(),
        _ => ((child & !LIGHT_LEAF) as usize) < data.lights.len(),
    };
    used > 0
        && node.power[..used].iter().all(|power| *power <= 1.0)
        && node.power[used..].iter().all(|power| *power == 0.0)
        && node.child[..used].iter().all(|&child| child_is_valid(child))
}

/// Whether as many children are lights as there are lights, and as many groups as there are nodes below the root. Together
/// with a path to every light: there is no other way into the tree than to a light by its path.
fn has_one_place_each(data: &SceneData<'_>) -> bool {
    let used = |node: &LightNode8| node.power.iter().filter(|power| **power > 0.0).count();
    let lights =
        |node: &LightNode8| node.child[..used(node)].iter().filter(|child| **child & LIGHT_LEAF != 0).count();
    let all: usize = data.light_nodes.iter().map(used).sum();
    let leaves: usize = data.light_nodes.iter().map(lights).sum();
    leaves == data.lights.len() && all - leaves == data.light_nodes.len() - 1
}

/// Whether the path of light `index` leads to it through groups that hold it.
fn is_held(data: &SceneData<'_>, index: usize) -> bool {
    let light = &data.lights[index];
    let mut at = 0;
    for level in 0..MAX_LIGHT_DEPTH {
        let (node, slot) = (&data.light_nodes[at], slot(light.path, level));
        if !(node.power[slot] > 0.0 && group_holds(data, node, slot, light.triangle)) {
            return false;
        }
        if node.child[slot] & LIGHT_LEAF != 0 {
            return (node.child[slot] & !LIGHT_LEAF) as usize == index;
        }
        at = node.child[slot] as usize;
    }
    false
}

/// Whether the bounds of a group hold a triangle, up to rounding.
fn group_holds(data: &SceneData<'_>, node: &LightNode8, slot: usize, triangle: u32) -> bool {
    const SLACK: f32 = 1e-4;
    let [a, b, c] = data.triangles[triangle as usize].corners;
    let column = |rows: &[[f32; 8]; 3]| [0, 1, 2].map(|axis| rows[axis][slot]);
    let (centre, axis, radius) = (column(&node.centre), column(&node.axis), node.radius[slot]);
    let near = |corner: [f32; 3]| {
        let away = vec3::sub(corner, centre);
        vec3::dot(away, away) <= radius * radius * (1.0 + SLACK)
    };
    let normal = vec3::normalized(vec3::cross(vec3::sub(b, a), vec3::sub(c, a)));
    let within = normal.is_some_and(|normal| vec3::dot(normal, axis) >= node.cosine[slot] - SLACK);
    near(a) && near(b) && near(c) && within && node.cosine[slot] >= -1.0 && node.cosine[slot] <= 1.0
}
