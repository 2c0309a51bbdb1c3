//! The bounding volume hierarchy that rays walk, and whether a walk through it is safe.

use super::surface::Triangle;
use bytemuck::{Pod, Zeroable};

/// Levels of nodes a hierarchy may have: what the traversal's stack is made for.
pub const MAX_DEPTH: usize = 32;

/// Entries a depth-first walk needs: at each level up to seven siblings wait while one is followed.
pub(crate) const STACK: usize = 7 * MAX_DEPTH + 1;

/// Eight boxes and what is in them: a node of the bounding volume hierarchy, four cache lines.
///
/// Children that are there come first and have finite boxes that enclose what is below them; the others have the boxes of
/// [`EMPTY`](Self::EMPTY).
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Node8 {
    /// Lower corners of the children's boxes, by axis and child. An unused child has `+∞`.
    pub lower: [[f32; 8]; 3],
    /// Upper corners. An unused child has `−∞`.
    pub upper: [[f32; 8]; 3],
    /// For an inner child the index of its node, which is above this node's own; else that of the leaf's first triangle.
    pub child: [u32; 8],
    /// Number of triangles of a leaf, 1 to 8; 0 for an inner or unused child.
    pub count: [u32; 8],
}

impl Node8 {
    /// A node without children.
    pub const EMPTY: Node8 = Node8 {
        lower: [[f32::INFINITY; 8]; 3],
        upper: [[f32::NEG_INFINITY; 8]; 3],
        child: [0; 8],
        count: [0; 8],
    };

    /// Whether child `i` (0 to 7) is there: unused ones have empty boxes.
    #[inline(always)]
    pub fn is_used(&self, i: usize) -> bool {
        self.lower[0][i] <= self.upper[0][i]
    }

    /// The box around all children: its lower and its upper corner.
    pub fn hull(&self) -> ([f32; 3], [f32; 3]) {
        let lower = self.lower.map(|row| row.into_iter().fold(f32::INFINITY, f32::min));
        let upper = self.upper.map(|row| row.into_iter().fold(f32::NEG_INFINITY, f32::max));
        (lower, upper)
    }

    /// How many children there are, if those that are not there come last and every box is finite or empty. A walk over a
    /// packet stops at the first empty box, that of a single ray looks at all eight: both must see the same.
    pub(super) fn children(&self) -> Option<usize> {
        let used = (0..8).take_while(|&child| self.is_used(child)).count();
        let finite = |child: usize| {
            (0..3).all(|axis| {
                let (lower, upper) = (self.lower[axis][child], self.upper[axis][child]);
                lower <= upper && lower.is_finite() && upper.is_finite()
            })
        };
        let empty = |child: usize| {
            let boxed = |rows: &[[f32; 8]; 3], bound: f32| rows.iter().all(|row| row[child] == bound);
            boxed(&self.lower, f32::INFINITY)
                && boxed(&self.upper, f32::NEG_INFINITY)
                && self.count[child] == 0
        };
        ((0..used).all(finite) && (used..8).all(empty)).then_some(used)
    }

    /// Whether the box of `child` encloses another.
    pub(super) fn encloses(&self, child: usize, lower: [f32; 3], upper: [f32; 3]) -> bool {
        (0..3).all(|k| self.lower[k][child] <= lower[k] && upper[k] <= self.upper[k][child])
    }

    /// Whether the box of `child` encloses all of a node's boxes.
    pub(super) fn encloses_node(&self, child: usize, node: &Node8) -> bool {
        let corner = |rows: &[[f32; 8]; 3], i: usize| rows.map(|row| row[i]);
        (0..8)
            .filter(|&i| node.is_used(i))
            .all(|i| self.encloses(child, corner(&node.lower, i), corner(&node.upper, i)))
    }
}

/// Numbers that there must be from the beginning of a leaf on. A walk reads eight of every row, however many triangles the
/// leaf has, the last at 64 at most; with eight more than a power of two that needs no check.
pub(crate) const LEAF: usize = 136;

/// Zeros after the last leaf's numbers.
const TAIL: usize = LEAF - 9;

/// How many numbers [`SceneData::leaves`](crate::tracer::scene::SceneData::leaves) has for so many triangles.
pub const fn leaves_len(triangles: usize) -> usize {
    9 * triangles + TAIL
}

/// Fills [`SceneData::leaves`](crate::tracer::scene::SceneData::leaves): the coordinates of `triangles`, those of each leaf of
/// `nodes` by corner, axis and triangle, so that one ray meets all of them at once. `out` should be as long as
/// [`leaves_len`] says. Leaves that do not fit are left out.
pub fn fill_leaves(nodes: &[Node8], triangles: &[Triangle], out: &mut [f32]) {
    out.fill(0.0);
    for (node, child) in nodes.iter().flat_map(|node| (0..8).map(move |child| (node, child))) {
        let (first, count) = (node.child[child] as usize, node.count[child] as usize);
        let Some(held) = triangles.get(first..first.saturating_add(count)) else { continue };
        let rows = out.get_mut(9 * first..9 * (first + count)).into_iter().flatten();
        rows.zip(by_rows(held)).for_each(|(number, coordinate)| *number = coordinate);
    }
}

/// The coordinates of a leaf's triangles by corner, axis and triangle.
pub(super) fn by_rows(triangles: &[Triangle]) -> impl Iterator<Item = f32> {
    (0..9).flat_map(|row| triangles.iter().map(move |triangle| triangle.corners[row / 3][row % 3]))
}
