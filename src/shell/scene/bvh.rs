//! Builds the core's eight-wide hierarchy: obvhs makes a binary tree, this collapses it.

use glam::Vec3A;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::{BvhBuildParams, triangle::Triangle as BuildTriangle};
use pmcip_core::tracer::scene::{Leaf8, Node8, Triangle};
use std::time::Duration;

/// A hierarchy and the triangle order its leaves expect.
pub struct Bvh {
    /// Nodes, the root first, parents before children.
    pub nodes: Vec<Node8>,
    /// Leaves of the nodes.
    pub leaves: Vec<Leaf8>,
    /// `order[i]` is the original index of the `i`-th triangle in leaf order.
    pub order: Vec<u32>,
}

/// Most triangles in a leaf.
const MAX_LEAF: u32 = 8;

/// Cost of a triangle in a leaf, in wide nodes, measured: where rays part they meet a leaf's triangles at once, ...
const TRIANGLE_COST: f32 = 0.07;

/// ... while packets, which stay together in scenes of up to [`FEW`] triangles, meet them one by one.
const TRIANGLE_COST_OF_FEW: f32 = 0.35;

/// Triangles of a scene that the core walks in packets whatever the rays' directions.
const FEW: usize = 256;

/// Boxes grow by this fraction of the largest coordinate, a few rounding errors of the intersection tests, so
/// that no ray slips between a box and the triangle on its face.
const PADDING: f32 = 1.0 / (1 << 20) as f32;

/// Builds the hierarchy over `triangles`. An empty slice gives an empty one.
pub fn build(triangles: &[Triangle]) -> Bvh {
    if triangles.is_empty() {
        return Bvh { nodes: Vec::new(), leaves: Vec::new(), order: Vec::new() };
    }
    let input: Vec<BuildTriangle> = triangles
        .iter()
        .map(|t| {
            let [v0, v1, v2] = t.corners.map(Vec3A::from_array);
            BuildTriangle { v0, v1, v2 }
        })
        .collect();
    let mut params = BvhBuildParams::medium_build();
    params.max_prims_per_leaf = 1;
    let tree = build_bvh2_from_tris(&input, params, &mut Duration::default());
    let coordinates = triangles.iter().flat_map(|t| t.corners.as_flattened());
    let padding = PADDING * coordinates.fold(0.0f32, |m, v| m.max(v.abs()));
    let triangle_cost = if triangles.len() <= FEW { TRIANGLE_COST_OF_FEW } else { TRIANGLE_COST };
    let plans = plans(&tree, triangle_cost);
    let mut collapse = Collapse {
        tree: &tree,
        triangles,
        plans,
        padding,
        nodes: Vec::new(),
        leaves: Vec::new(),
        order: Vec::new(),
    };
    collapse.node(0);
    Bvh { nodes: collapse.nodes, leaves: collapse.leaves, order: collapse.order }
}

/// What it costs to make a binary node into up to `i + 1` children of a wide one, and how.
#[derive(Clone, Copy, Default)]
struct Plan {
    /// Expected cost of a ray that meets the scene, up to a factor.
    cost: [f32; 7],
    /// How many of the children the first half gets; `split[0]` is for the eight children that the node has as a
    /// wide one itself, 0 where it becomes a leaf.
    split: [u8; 7],
    /// Triangles below.
    count: u32,
}

/// The plans of least surface-area cost for all binary nodes (Ylitie, Karras and Laine, *Efficient incoherent ray
/// traversal on GPUs through compressed wide BVHs*, HPG 2017, section 3.1).
fn plans(tree: &Bvh2, triangle_cost: f32) -> Vec<Plan> {
    let mut order = vec![0];
    let mut next = 0;
    while let Some(&index) = order.get(next) {
        let node = &tree.nodes[index];
        if !node.is_leaf() {
            order.extend([node.first_index as usize, node.first_index as usize + 1]);
        }
        next += 1;
    }
    let mut plans = vec![Plan::default(); tree.nodes.len()];
    for index in order.into_iter().rev() {
        let node = &tree.nodes[index];
        let area = node.aabb().half_area();
        let first = node.first_index as usize;
        plans[index] = if node.is_leaf() {
            leaf(area * triangle_cost, node.prim_count)
        } else {
            join(area, triangle_cost, &plans[first], &plans[first + 1])
        };
    }
    plans
}

/// The plan for a leaf of `count` triangles, of which each costs `cost`.
fn leaf(cost: f32, count: u32) -> Plan {
    Plan { cost: [cost * count as f32; 7], split: [0; 7], count }
}

/// The plan for a node of two halves.
fn join(area: f32, triangle_cost: f32, a: &Plan, b: &Plan) -> Plan {
    let best = |children: usize| {
        (children.saturating_sub(7).max(1)..children.min(8))
            .map(|k| (a.cost[k - 1] + b.cost[children - k - 1], k as u8))
            .min_by(|x, y| x.0.total_cmp(&y.0))
            .expect("there is a way to divide two or more children")
    };
    let mut plan = leaf(area * triangle_cost, a.count + b.count);
    let (below, share) = best(8);
    let inner = below + area;
    if plan.count > MAX_LEAF || inner < plan.cost[0] {
        (plan.cost[0], plan.split[0]) = (inner, share);
    }
    for children in 2..=7 {
        let (cost, share) = best(children);
        plan.split[children - 1] = share;
        plan.cost[children - 1] = cost.min(plan.cost[children - 2]);
    }
    plan
}

struct Collapse<'a> {
    tree: &'a Bvh2,
    triangles: &'a [Triangle],
    plans: Vec<Plan>,
    padding: f32,
    nodes: Vec<Node8>,
    leaves: Vec<Leaf8>,
    order: Vec<u32>,
}

impl Collapse<'_> {
    /// Appends the wide node that stands for binary node `root` and what is below it; returns its index.
    fn node(&mut self, root: usize) -> u32 {
        let index = self.nodes.len();
        self.nodes.push(Node8::EMPTY);
        let mut children = Vec::new();
        if self.tree.nodes[root].is_leaf() || self.plans[root].split[0] == 0 {
            children.push(root);
        } else {
            self.divide(root, 8, self.plans[root].split[0], &mut children);
        }
        for (slot, child) in children.into_iter().enumerate() {
            let aabb = *self.tree.nodes[child].aabb();
            let (lower, upper) = (aabb.min - self.padding, aabb.max + self.padding);
            let (first, count) = if self.plans[child].split[0] == 0 {
                (self.leaves.len() as u32, self.leaf(child))
            } else {
                (self.node(child), 0)
            };
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

    /// The children of a wide node that come from the halves of `root`, `share` of `children` from the first.
    fn divide(&self, root: usize, children: usize, share: u8, out: &mut Vec<usize>) {
        let first = self.tree.nodes[root].first_index as usize;
        self.children(first, usize::from(share), out);
        self.children(first + 1, children - usize::from(share), out);
    }

    /// The children that `root` becomes if it may become `most`.
    fn children(&self, root: usize, most: usize, out: &mut Vec<usize>) {
        let plan = &self.plans[root];
        // Where more do not cost less, fewer will do.
        let enough = (1..=most).find(|i| plan.cost[i - 1] == plan.cost[most - 1]).unwrap_or(1);
        match enough {
            1 => out.push(root),
            children => self.divide(root, children, plan.split[children - 1], out),
        }
    }

    /// Appends the leaf that stands for binary node `root`; returns its number of triangles.
    fn leaf(&mut self, root: usize) -> u32 {
        let first = self.order.len();
        self.collect(root);
        let order = &self.order[first..];
        let triangles: Vec<Triangle> = order.iter().map(|i| self.triangles[*i as usize]).collect();
        self.leaves.push(Leaf8::new(first as u32, &triangles));
        triangles.len() as u32
    }

    /// Appends the triangles below `root`.
    fn collect(&mut self, root: usize) {
        let node = self.tree.nodes[root];
        let first = node.first_index as usize;
        if node.is_leaf() {
            self.order.extend(&self.tree.primitive_indices[first..first + node.prim_count as usize]);
        } else {
            self.collect(first);
            self.collect(first + 1);
        }
    }
}
