//! Builds the core's eight-wide hierarchy: obvhs makes a binary tree, this collapses it.

mod parts;

use glam::Vec3A;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::{BvhBuildParams, triangle::Triangle as BuildTriangle};
use pmcip_core::tracer::scene::{MAX_DEPTH, Node8, Triangle, fill_leaves, leaves_len};
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};
use std::time::Duration;

/// A hierarchy and the triangle order its leaves expect.
#[derive(Default)]
pub struct Bvh {
    /// Nodes, the root first, parents before children.
    pub nodes: Vec<Node8>,
    /// `order[i]` is the original index of the `i`-th triangle in leaf order.
    pub order: Vec<u32>,
}

/// What the core wants of triangles in the order of the leaves of `nodes`.
pub fn leaves(nodes: &[Node8], triangles: &[Triangle]) -> Vec<f32> {
    let mut leaves = vec![0.0; leaves_len(triangles.len())];
    fill_leaves(nodes, triangles, &mut leaves);
    leaves
}

/// From this number of triangles on they are divided into parts first: what is lost by their coarse borders is little then.
const MANY: usize = 500_000;

/// Most triangles in a leaf.
const MAX_LEAF: u32 = 8;

/// Cost of a triangle in a leaf, in wide nodes, measured: where rays part they meet a leaf's triangles at once, ...
const TRIANGLE_COST: f32 = 0.07;

/// ... while packets, which stay together in scenes of up to [`FEW`] triangles, meet them one by one.
const TRIANGLE_COST_OF_FEW: f32 = 0.35;

/// Triangles of a scene that the core walks in packets whatever the rays' directions.
const FEW: usize = 256;

/// Level from which on triangles are divided by their number: no scene whose boxes tell them apart gets there, and below it
/// eight children each leave room for all that an index can count.
const BY_COUNT: usize = MAX_DEPTH - 11;

/// Boxes grow by this fraction of the largest coordinate, a few rounding errors of the intersection tests, so
/// that no ray slips between a box and the triangle on its face.
const PADDING: f32 = 1.0 / (1 << 20) as f32;

/// Triangles as the shutter opens and, unless they stand still, as it closes.
#[derive(Clone, Copy)]
struct Triangles<'a> {
    open: &'a [Triangle],
    closing: &'a [Triangle],
}

impl Triangles<'_> {
    /// All corners of a triangle.
    fn corners(&self, i: u32) -> impl Iterator<Item = Vec3A> {
        let closing = self.closing.get(i as usize);
        let triangles = [&self.open[i as usize]].into_iter().chain(closing);
        triangles.flat_map(|triangle| triangle.corners).map(Vec3A::from_array)
    }

    /// The box around a triangle on all of its way.
    fn bounds(&self, i: u32) -> (Vec3A, Vec3A) {
        hull(self.corners(i))
    }

    /// What the tree is made of: the triangle, or if it may move one that is as wide as all of its way.
    fn input(&self, i: u32) -> BuildTriangle {
        if self.closing.is_empty() {
            let [v0, v1, v2] = self.open[i as usize].corners.map(Vec3A::from_array);
            return BuildTriangle { v0, v1, v2 };
        }
        let (v0, v1) = self.bounds(i);
        BuildTriangle { v0, v1, v2: v0 }
    }
}

/// The box around points.
fn hull(points: impl Iterator<Item = Vec3A>) -> (Vec3A, Vec3A) {
    points.fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}

/// Builds the hierarchy over `triangles`, which are where `closing` says as the shutter closes; that is empty if they stand
/// still. Without triangles it is empty. Half a million of them are made of parts on all threads, the same for any number
/// of them.
pub fn build(triangles: &[Triangle], closing: &[Triangle]) -> Bvh {
    let triangles = Triangles { open: triangles, closing };
    let all: Vec<u32> = (0..triangles.open.len() as u32).collect();
    let coordinates = triangles.open.iter().chain(closing).flat_map(|t| t.corners.as_flattened());
    let padding = PADDING * coordinates.fold(0.0f32, |m, v| m.max(v.abs()));
    match all.len() {
        0 => Bvh::default(),
        few if few < MANY => Collapse::of(triangles, &all, padding, 0, 0),
        _ => join(triangles, parts::divide(&|i| triangles.bounds(i), all, 8), padding),
    }
}

/// Hierarchies of all parts, up to eight, below one root.
fn join(triangles: Triangles<'_>, parts: Vec<Vec<u32>>, padding: f32) -> Bvh {
    let mut next = 0;
    let seated: Vec<(u32, Vec<u32>)> = parts
        .into_iter()
        .map(|part| {
            let start = next;
            next += part.len() as u32;
            (start, part)
        })
        .collect();
    let of = |(start, part): (u32, Vec<u32>)| Collapse::of(triangles, &part, padding, start, 1);
    let built: Vec<Bvh> = seated.into_par_iter().map(of).collect();
    let mut whole = Bvh { nodes: vec![Node8::EMPTY], ..Bvh::default() };
    for (slot, part) in built.into_iter().enumerate() {
        let (lower, upper) = part.nodes[0].hull();
        let node = whole.nodes.len() as u32;
        let root = &mut whole.nodes[0];
        for axis in 0..3 {
            (root.lower[axis][slot], root.upper[axis][slot]) = (lower[axis], upper[axis]);
        }
        root.child[slot] = node;
        whole.nodes.extend(part.nodes.into_iter().map(|mut of_part| {
            for child in 0..8 {
                if of_part.is_used(child) && of_part.count[child] == 0 {
                    of_part.child[child] += node;
                }
            }
            of_part
        }));
        whole.order.extend(part.order);
    }
    whole
}

/// Triangles of which many have the same box: no tree tells them apart, and looking for one would take for ever.
struct Heaps {
    /// The triangles of which the tree is made, one for each heap.
    first: Vec<u32>,
    /// The others of each heap, by its first.
    others: HashMap<u32, Vec<u32>>,
}

/// Most triangles of one box that are left to the tree.
const HEAP: u32 = 64;

/// Finds heaps among `all` of some triangles: boxes are counted by a hash, and compared where that says they are many.
fn heaps(triangles: &Triangles<'_>, all: &[u32]) -> Heaps {
    const BUCKETS: usize = 1 << 20;
    let bucket = |triangle: u32| {
        let mix = |hash: u64, bits: u32| {
            (hash ^ u64::from(bits)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29)
        };
        bits(triangles.bounds(triangle)).into_iter().fold(0, mix) as usize % BUCKETS
    };
    let mut counts = vec![0u32; BUCKETS];
    all.iter().for_each(|triangle| counts[bucket(*triangle)] += 1);
    let many = HEAP + 4 * (all.len() / BUCKETS) as u32;
    let mut firsts: HashMap<[u32; 6], Vec<u32>> = HashMap::new();
    for &i in all.iter().filter(|i| counts[bucket(**i)] > many) {
        firsts.entry(bits(triangles.bounds(i))).or_default().push(i);
    }
    let mut others: HashMap<u32, Vec<u32>> = HashMap::new();
    let mut is_other: HashSet<u32> = HashSet::new();
    for heap in firsts.into_values().filter(|heap| heap.len() > HEAP as usize) {
        is_other.extend(&heap[1..]);
        others.insert(heap[0], heap[1..].to_vec());
    }
    let first = all.iter().copied().filter(|i| !is_other.contains(i)).collect();
    Heaps { first, others }
}

/// The bits of a box.
fn bits((low, high): (Vec3A, Vec3A)) -> [u32; 6] {
    [low[0], low[1], low[2], high[0], high[1], high[2]].map(f32::to_bits)
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
            divided(area, triangle_cost, &plans[first], &plans[first + 1])
        };
    }
    plans
}

/// The plan for a leaf of `count` triangles, of which each costs `cost`.
fn leaf(cost: f32, count: u32) -> Plan {
    Plan { cost: [cost * count as f32; 7], split: [0; 7], count }
}

/// The plan for a node of two halves.
fn divided(area: f32, triangle_cost: f32, a: &Plan, b: &Plan) -> Plan {
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
    triangles: Triangles<'a>,
    heaps: Heaps,
    plans: Vec<Plan>,
    padding: f32,
    nodes: Vec<Node8>,
    order: Vec<u32>,
    /// Place of the first triangle in the order of the whole hierarchy.
    start: u32,
}

impl Collapse<'_> {
    /// The hierarchy over `all` of some triangles, whose order begins at `start` in that of a whole one and whose root is at
    /// `level` of it.
    fn of(triangles: Triangles<'_>, all: &[u32], padding: f32, start: u32, level: usize) -> Bvh {
        let heaps = heaps(&triangles, all);
        let input: Vec<BuildTriangle> = heaps.first.iter().map(|i| triangles.input(*i)).collect();
        // Slower builders make trees of the same expected cost within one percent.
        let mut params = BvhBuildParams::fast_build();
        params.max_prims_per_leaf = 1;
        let tree = build_bvh2_from_tris(&input, params, &mut Duration::default());
        drop(input);
        let triangle_cost = if all.len() <= FEW { TRIANGLE_COST_OF_FEW } else { TRIANGLE_COST };
        let plans = plans(&tree, triangle_cost);
        let mut collapse = Collapse {
            tree: &tree,
            triangles,
            heaps,
            plans,
            padding,
            nodes: Vec::new(),
            order: Vec::new(),
            start,
        };
        collapse.node(0, level);
        Bvh { nodes: collapse.nodes, order: collapse.order }
    }

    /// Appends the wide node at `level` that stands for binary node `root` and what is below it; returns its index.
    fn node(&mut self, root: usize, level: usize) -> u32 {
        if level >= BY_COUNT {
            let triangles = self.below(root);
            return self.node_by_count(&triangles);
        }
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
                self.leaf(child)
            } else {
                (self.node(child, level + 1), 0)
            };
            self.set(index, slot, (lower, upper), (first, count));
        }
        index as u32
    }

    /// Appends a node whose children have equal shares of `triangles`, and what is below it; returns its index.
    fn node_by_count(&mut self, triangles: &[u32]) -> u32 {
        let index = self.nodes.len();
        self.nodes.push(Node8::EMPTY);
        let share = triangles.len().div_ceil(8).max(1);
        for (slot, part) in triangles.chunks(share).enumerate() {
            let (low, high) = hull(part.iter().flat_map(|i| self.triangles.corners(*i)));
            let child = self.leaf_of(part);
            self.set(index, slot, (low - self.padding, high + self.padding), child);
        }
        index as u32
    }

    /// Writes a child into a node.
    fn set(&mut self, node: usize, slot: usize, (lower, upper): (Vec3A, Vec3A), (first, count): (u32, u32)) {
        let out = &mut self.nodes[node];
        for axis in 0..3 {
            out.lower[axis][slot] = lower[axis];
            out.upper[axis][slot] = upper[axis];
        }
        out.child[slot] = first;
        out.count[slot] = count;
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

    /// Appends what stands for binary node `root`, which is a leaf; returns it as a child.
    fn leaf(&mut self, root: usize) -> (u32, u32) {
        let below = self.below(root);
        self.leaf_of(&below)
    }

    /// Appends a leaf, or nodes above leaves where one has no room; returns it as a child.
    fn leaf_of(&mut self, order: &[u32]) -> (u32, u32) {
        if order.len() > MAX_LEAF as usize {
            return (self.node_by_count(order), 0);
        }
        let first = self.start + self.order.len() as u32;
        self.order.extend(order);
        (first, order.len() as u32)
    }

    /// The triangles below `root`, from left to right. The binary tree may be as deep as there are triangles.
    fn below(&self, root: usize) -> Vec<u32> {
        let (mut triangles, mut waiting) = (Vec::new(), vec![root]);
        while let Some(at) = waiting.pop() {
            let node = self.tree.nodes[at];
            let first = node.first_index as usize;
            if node.is_leaf() {
                for number in &self.tree.primitive_indices[first..first + node.prim_count as usize] {
                    let triangle = self.heaps.first[*number as usize];
                    triangles.push(triangle);
                    triangles.extend(self.heaps.others.get(&triangle).into_iter().flatten());
                }
            } else {
                waiting.extend([first + 1, first]);
            }
        }
        triangles
    }
}

#[cfg(test)]
mod tests;
