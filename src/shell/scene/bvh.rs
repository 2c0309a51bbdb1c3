//! Builds the core's eight-wide hierarchy: obvhs makes a binary tree, this collapses it.

use glam::Vec3A;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::{BvhBuildParams, triangle::Triangle as BuildTriangle};
use pmcip_core::scene::{Node8, Triangle};
use std::time::Duration;

/// A hierarchy and the triangle order its leaves expect.
pub struct Bvh {
    /// Nodes, the root first, parents before children.
    pub nodes: Vec<Node8>,
    /// `order[i]` is the original index of the `i`-th triangle in leaf order.
    pub order: Vec<u32>,
}

/// Most triangles in a leaf: a packet tests them one by one.
const MAX_LEAF: u32 = 4;

/// Boxes grow by this fraction of the largest coordinate, a few rounding errors of the intersection tests, so
/// that no ray slips between a box and the triangle on its face.
const PADDING: f32 = 1.0 / (1 << 20) as f32;

/// Builds the hierarchy over `triangles`. An empty slice gives an empty one.
pub fn build(triangles: &[Triangle]) -> Bvh {
    if triangles.is_empty() {
        return Bvh { nodes: Vec::new(), order: Vec::new() };
    }
    let input: Vec<BuildTriangle> = triangles
        .iter()
        .map(|t| {
            let [v0, v1, v2] = t.corners.map(Vec3A::from_array);
            BuildTriangle { v0, v1, v2 }
        })
        .collect();
    let mut params = BvhBuildParams::medium_build();
    params.max_prims_per_leaf = MAX_LEAF;
    let tree = build_bvh2_from_tris(&input, params, &mut Duration::default());
    let coordinates = triangles.iter().flat_map(|t| t.corners.as_flattened());
    let padding = PADDING * coordinates.fold(0.0f32, |m, v| m.max(v.abs()));
    let mut collapse = Collapse { tree: &tree, padding, nodes: Vec::new() };
    collapse.node(0);
    Bvh { nodes: collapse.nodes, order: tree.primitive_indices }
}

struct Collapse<'a> {
    tree: &'a Bvh2,
    padding: f32,
    nodes: Vec<Node8>,
}

impl Collapse<'_> {
    /// Appends the node that stands for binary node `root` and what is below it; returns its index.
    fn node(&mut self, root: usize) -> u32 {
        let index = self.nodes.len();
        self.nodes.push(Node8::EMPTY);
        for (slot, child) in self.children(root).into_iter().enumerate() {
            let node = &self.tree.nodes[child];
            let (lower, upper) = (node.aabb().min - self.padding, node.aabb().max + self.padding);
            let (first, count) =
                if node.is_leaf() { (node.first_index, node.prim_count) } else { (self.node(child), 0) };
            let out = &mut self.nodes[index];
            for axis in 0..3 {
                out.lower[axis][slot] = lower[axis];
                out.upper[axis][slot] = upper[axis];
            }
            out.child[slot] = first;
            out.count[slot] = count;
        }
        index as u32
    }

    /// Up to eight binary nodes that cover `root`: the largest inner one is opened until they are eight.
    fn children(&self, root: usize) -> Vec<usize> {
        let node = |i: usize| &self.tree.nodes[i];
        let mut open = vec![root];
        while open.len() < 8 {
            let inner = open.iter().enumerate().filter(|&(_, &i)| !node(i).is_leaf());
            let area = |i: usize| node(i).aabb().half_area();
            let Some((slot, _)) = inner.max_by(|a, b| area(*a.1).total_cmp(&area(*b.1))) else { break };
            let first = node(open[slot]).first_index as usize;
            open[slot] = first;
            open.push(first + 1);
        }
        open
    }
}
