//! A checked tree and its walk: the leaves near a point, nearest first.

use super::build::{check_lengths, extent};
use super::neighbours::Neighbours;
use super::record::{Error, Leaf, Site, Split};
use wide::f32x8;

/// Cosine between a record's normal and the query's from which on they go together.
pub(super) const COMPATIBLE: f32 = 0.8;

/// Squared distances along the normal count this much more: threefold distances.
pub(super) const FLATTENED: f32 = 8.0;

/// Levels of splits: more records than indices cannot be.
const STACK: usize = 32;

/// Leaves a query visits at most. Where records lie close whose normals all differ from the query's, it would
/// search the whole tree for nothing.
const PATIENCE: usize = 256;

/// A tree that has been checked, borrowed.
#[derive(Debug)]
pub struct Tree<'a, T> {
    splits: &'a [Split],
    leaves: &'a [Leaf],
    sites: &'a [T],
    spacing: f32,
}

impl<T> Clone for Tree<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Tree<'_, T> {}

/// A point asked about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Query {
    /// Where, in scene units.
    pub position: [f32; 3],
    /// Unit normal of the surface there.
    pub normal: [f32; 3],
    /// Distance up to which records count, in scene units.
    pub radius: f32,
}

impl<'a, T: Site> Tree<'a, T> {
    /// Checks what [`build`](super::build) wrote and borrows it.
    ///
    /// # Errors
    /// The first thing found wrong: see [`Error`].
    pub fn new(sites: &'a [T], splits: &'a [Split], leaves: &'a [Leaf]) -> Result<Self, Error> {
        check_lengths(sites.len(), splits, leaves)?;
        if let Some(i) = splits.iter().position(|s| s.axis > 2) {
            return Err(Error::Split(i));
        }
        let inside = |leaf: &Leaf| leaf.count().checked_add(leaf.first as usize) <= Some(sites.len());
        if let Some(i) = leaves.iter().position(|leaf| !inside(leaf)) {
            return Err(Error::Leaf(i));
        }
        let [x, y, z] = extent(sites);
        let area = 2.0 * (x * y + y * z + z * x);
        let spacing = libm::sqrtf(area / (core::f32::consts::PI * sites.len().max(1) as f32));
        Ok(Tree { splits, leaves, sites, spacing })
    }

    /// The records, in the tree's order.
    pub fn sites(&self) -> &'a [T] {
        self.sites
    }

    /// Radius of the disc that one record would have to itself, were all spread evenly over the faces of their
    /// bounding box: what search radii are measured in.
    pub fn spacing(&self) -> f32 {
        self.spacing
    }

    /// Index and squared distance of the nearest record that goes with the query; of one that is near if the
    /// query ran out of patience (256 leaves), or none.
    pub fn nearest(&self, query: &Query) -> Option<(usize, f32)> {
        let ask = Ask::new(query);
        let mut best = None;
        self.walk(query, |leaf, limit| {
            let distance = ask.distances(leaf);
            if !distance.simd_lt(f32x8::splat(limit)).any() {
                return limit;
            }
            let nearer = |a: (usize, f32), b: (usize, f32)| if b.1 < a.1 { b } else { a };
            let (lane, least) = distance.to_array().into_iter().enumerate().fold((0, f32::INFINITY), nearer);
            best = Some((leaf.first as usize + lane, least));
            least
        });
        best
    }

    /// Fills `found` with the records nearest to the query, all up to [`Neighbours::radius2`]. That is less than the
    /// query's radius if it ran out of patience (256 leaves).
    pub fn k_nearest<const K: usize>(&self, query: &Query, found: &mut Neighbours<K>) {
        let ask = Ask::new(query);
        found.clear();
        let end = self.walk(query, |leaf, mut limit| {
            let distance = ask.distances(leaf);
            let mut lanes = distance.simd_lt(f32x8::splat(limit)).to_bitmask();
            let distance = distance.to_array();
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize & 7;
                lanes &= lanes - 1;
                limit = found.insert(distance[lane], leaf.first + lane as u32, limit);
            }
            limit
        });
        found.end(end);
    }

    /// Visits leaves, near ones first, while they can hold records within the limit (squared), which `visit`
    /// returns anew. Returns the squared distance up to which no leaf was left out.
    #[inline(always)]
    fn walk(&self, query: &Query, mut visit: impl FnMut(&Leaf, f32) -> f32) -> f32 {
        let inner = self.splits.len();
        let mut waiting = [(0u32, 0.0f32); STACK];
        let mut top = 0;
        let mut limit = query.radius * query.radius;
        let mut node = 0;
        for _ in 0..PATIENCE {
            while let Some(split) = self.splits.get(node) {
                let beyond = query.position[split.axis as usize] - split.at;
                let right = usize::from(beyond >= 0.0);
                waiting[top & (STACK - 1)] = ((2 * node + 2 - right) as u32, beyond * beyond);
                top += 1;
                node = 2 * node + 1 + right;
            }
            limit = visit(&self.leaves[node - inner], limit);
            loop {
                if top == 0 {
                    return limit;
                }
                top -= 1;
                let (other, distance2) = waiting[top & (STACK - 1)];
                if distance2 < limit {
                    node = other as usize;
                    break;
                }
            }
        }
        // The subtree taken off last was not visited either.
        waiting[..(top + 1).min(STACK)].iter().fold(limit, |least, entry| least.min(entry.1))
    }
}

impl Leaf {
    /// Lanes up to the last that is used.
    fn count(&self) -> usize {
        self.position[0].iter().rposition(|x| *x != f32::INFINITY).map_or(0, |lane| lane + 1)
    }
}

/// A query in all lanes.
struct Ask {
    position: [f32x8; 3],
    normal: [f32x8; 3],
}

impl Ask {
    #[inline(always)]
    fn new(query: &Query) -> Self {
        Ask { position: query.position.map(f32x8::splat), normal: query.normal.map(f32x8::splat) }
    }

    /// Squared distances of a leaf's records, flattened; infinite where the normals do not go together.
    #[inline(always)]
    fn distances(&self, leaf: &Leaf) -> f32x8 {
        let d = [0, 1, 2].map(|i| f32x8::from(leaf.position[i]) - self.position[i]);
        let facing = [0, 1, 2].map(|i| f32x8::from(leaf.normal[i]) * self.normal[i]);
        let along = d[0] * self.normal[0] + d[1] * self.normal[1] + d[2] * self.normal[2];
        let flat = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        let distance = flat + along * along * f32x8::splat(FLATTENED);
        let with = (facing[0] + facing[1] + facing[2]).simd_gt(f32x8::splat(COMPATIBLE));
        with.select(distance, f32x8::splat(f32::INFINITY))
    }
}
