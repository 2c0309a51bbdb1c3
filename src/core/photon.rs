//! Photons in a k-d tree, and what is asked of them: the nearest, the k nearest, the light they bring.
//!
//! The tree is a perfect binary one in implicit (heap) order whose leaves hold up to eight records as a packet, so
//! that a query tests eight at once. [`build`] orders the records in place and writes splits and leaves into lent
//! memory; [`Tree::new`] checks the three slices once and borrows them. Queries use a fixed stack.
//!
//! A record counts for a query only if its surface faces much the same way, and distances along the query's normal
//! count threefold (a flattened ball, as Jensen, *Realistic Image Synthesis Using Photon Mapping*, 2001, section
//! 7.2.2): light on one wall of a corner says nothing about the other.
//!
//! Light is estimated with Silverman's kernel 2(1 − d²/r²)/(πr²) over the k nearest photons, r the distance of the
//! k-th (Silverman, *Density Estimation*, 1986). The k-th itself gets no weight, which makes the estimate
//! unbiased where photons are even. Where light ends (at an edge, at a shadow) it is smeared over r.

use crate::vec3;
use bytemuck::{Pod, Zeroable};
use wide::f32x8;

/// Light that arrived on a surface.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Photon {
    /// Where, in scene units.
    pub position: [f32; 3],
    /// Unit geometric normal there, on the side it arrived at.
    pub normal: [f32; 3],
    /// Its share of the lights' flux (radiance times area times solid angle), linear Rec. 709.
    pub power: [f32; 3],
    /// Unit direction it came from, away from the surface.
    pub from: [f32; 3],
}

/// A surface point whose irradiance is known.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Irradiance {
    /// Where, in scene units.
    pub position: [f32; 3],
    /// Unit geometric normal, on the lit side.
    pub normal: [f32; 3],
    /// Irradiance, linear Rec. 709.
    pub value: [f32; 3],
    /// Radius over which it was averaged, in scene units.
    pub radius: f32,
}

/// A record on a surface, as the tree sees it.
pub trait Site {
    /// Where it is, in scene units.
    fn position(&self) -> [f32; 3];
    /// Unit normal of the surface.
    fn normal(&self) -> [f32; 3];
}

impl Site for Photon {
    #[inline]
    fn position(&self) -> [f32; 3] {
        self.position
    }
    #[inline]
    fn normal(&self) -> [f32; 3] {
        self.normal
    }
}

impl Site for Irradiance {
    #[inline]
    fn position(&self) -> [f32; 3] {
        self.position
    }
    #[inline]
    fn normal(&self) -> [f32; 3] {
        self.normal
    }
}

/// An inner node: what lies below `at` on `axis` is in the left half.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Split {
    /// 0, 1 or 2.
    pub axis: u32,
    /// Coordinate of the plane.
    pub at: f32,
}

/// Up to eight records side by side.
#[repr(align(32))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf {
    position: [[f32; 8]; 3],
    normal: [[f32; 8]; 3],
    /// Index of the first record.
    first: u32,
}

impl Default for Leaf {
    /// Without records: all infinitely far.
    fn default() -> Self {
        Leaf { position: [[f32::INFINITY; 8]; 3], normal: [[0.0; 8]; 3], first: 0 }
    }
}

/// Why memory is too short or lent slices are not a tree.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// There must be [`leaves`] leaves for the records, and one split less.
    Length,
    /// More than 2³² − 8 records.
    TooMany,
    /// The split of this index has no such axis.
    Split(usize),
    /// The leaf of this index reaches beyond the records.
    Leaf(usize),
}

impl core::fmt::Display for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Error::Length => f.write_str("the numbers of leaves and splits do not fit the records"),
            Error::TooMany => f.write_str("there are too many records for one tree"),
            Error::Split(i) => write!(f, "split {i} has no such axis"),
            Error::Leaf(i) => write!(f, "leaf {i} reaches beyond the records"),
        }
    }
}

impl core::error::Error for Error {}

/// Leaves that a tree over `records` records has: a power of two. It has one split less.
pub const fn leaves(records: usize) -> usize {
    records.div_ceil(8).next_power_of_two()
}

/// Orders `sites` and writes the tree over them. The same records in the same order give the same tree.
///
/// # Errors
/// [`Error::Length`] unless there are [`leaves`]`(sites.len())` leaves and one split less.
pub fn build<T: Site>(sites: &mut [T], splits: &mut [Split], leaves: &mut [Leaf]) -> Result<(), Error> {
    check_lengths(sites.len(), splits, leaves)?;
    divide(sites, 0, sites.len(), 0, splits);
    let (n, count) = (sites.len() as u64, leaves.len() as u64);
    for (i, leaf) in leaves.iter_mut().enumerate() {
        let bound = |i: u64| (n * i / count) as usize;
        let (first, end) = (bound(i as u64), bound(i as u64 + 1));
        *leaf = Leaf { first: first as u32, ..Leaf::default() };
        for (lane, site) in sites[first..end].iter().enumerate() {
            for axis in 0..3 {
                leaf.position[axis][lane & 7] = site.position()[axis];
                leaf.normal[axis][lane & 7] = site.normal()[axis];
            }
        }
    }
    Ok(())
}

fn check_lengths(sites: usize, splits: &[Split], leaves: &[Leaf]) -> Result<(), Error> {
    if sites > u32::MAX as usize - 8 {
        return Err(Error::TooMany);
    }
    let fits = leaves.len() == self::leaves(sites) && splits.len() + 1 == leaves.len();
    if fits { Ok(()) } else { Err(Error::Length) }
}

/// Divides the records of `node`, which are `sites`, at their median along their widest axis.
///
/// A node of level l, j-th of its level, holds the records from ⌊n·j/2ˡ⌋ on, so that leaves fill evenly.
fn divide<T: Site>(sites: &mut [T], node: usize, n: usize, level: u32, splits: &mut [Split]) {
    if node >= splits.len() {
        return;
    }
    let j = (node + 1 - (1 << level)) as u64;
    let first = ((n as u64 * j) >> level) as usize;
    let middle = ((n as u64 * (2 * j + 1)) >> (level + 1)) as usize - first;
    let axis = widest(sites);
    let order = |a: &T, b: &T| a.position()[axis].total_cmp(&b.position()[axis]);
    let mut at = 0.0;
    if middle < sites.len() {
        at = sites.select_nth_unstable_by(middle, order).1.position()[axis];
    }
    splits[node] = Split { axis: axis as u32, at };
    let (left, right) = sites.split_at_mut(middle);
    divide(left, 2 * node + 1, n, level + 1, splits);
    divide(right, 2 * node + 2, n, level + 1, splits);
}

/// The axis along which the records are spread most.
fn widest<T: Site>(sites: &[T]) -> usize {
    let size = extent(sites);
    let wider = |a: usize, b: usize| if size[b] > size[a] { b } else { a };
    wider(wider(0, 1), 2)
}

/// Edges of the records' bounding box.
fn extent<T: Site>(sites: &[T]) -> [f32; 3] {
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for site in sites {
        let p = site.position();
        low = [0, 1, 2].map(|i| low[i].min(p[i]));
        high = [0, 1, 2].map(|i| high[i].max(p[i]));
    }
    [0, 1, 2].map(|i| (high[i] - low[i]).max(0.0))
}

/// Cosine between a record's normal and the query's from which on they go together.
const COMPATIBLE: f32 = 0.8;

/// Squared distances along the normal count this much more: threefold distances.
const FLATTENED: f32 = 8.0;

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
    /// Checks what [`build`] wrote and borrows it.
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

/// The K nearest records found so far, a heap with the farthest on top once it is full.
#[derive(Clone, Debug)]
pub struct Neighbours<const K: usize> {
    entries: [(f32, u32); K],
    len: usize,
    radius2: f32,
}

impl<const K: usize> Default for Neighbours<K> {
    fn default() -> Self {
        Neighbours { entries: [(0.0, 0); K], len: 0, radius2: 0.0 }
    }
}

impl<const K: usize> Neighbours<K> {
    fn clear(&mut self) {
        self.len = 0;
    }

    /// Squared distances and indices of the records, in no order.
    pub fn entries(&self) -> &[(f32, u32)] {
        &self.entries[..self.len]
    }

    /// Squared distance up to which all records were found: that of the farthest if there are K, else of the query's
    /// radius, unless patience ended before.
    pub fn radius2(&self) -> f32 {
        self.radius2
    }

    /// Ends a search that was complete up to `radius2`.
    fn end(&mut self, radius2: f32) {
        self.radius2 = radius2;
        let mut kept = 0;
        for i in 0..self.len {
            if self.entries[i].0 <= radius2 {
                self.entries[kept] = self.entries[i];
                kept += 1;
            }
        }
        self.len = kept;
    }

    /// Takes in a record nearer than `limit`; returns the new limit.
    #[inline]
    fn insert(&mut self, distance: f32, index: u32, limit: f32) -> f32 {
        if distance >= limit {
            return limit;
        }
        if self.len < K {
            self.entries[self.len] = (distance, index);
            self.len += 1;
            if self.len < K {
                return limit;
            }
            (0..K / 2).rev().for_each(|i| self.sink(i));
        } else {
            self.entries[0] = (distance, index);
            self.sink(0);
        }
        self.entries[0].0
    }

    /// Lets the entry at `i` sink below farther ones.
    #[inline]
    fn sink(&mut self, mut i: usize) {
        let entry = self.entries[i];
        loop {
            let mut child = 2 * i + 1;
            if child >= K {
                break;
            }
            if child + 1 < K && self.entries[child + 1].0 > self.entries[child].0 {
                child += 1;
            }
            if self.entries[child].0 <= entry.0 {
                break;
            }
            self.entries[i] = self.entries[child];
            i = child;
        }
        self.entries[i] = entry;
    }

    /// Silverman's kernel at a squared distance, per area; zero where nothing was searched.
    #[inline(always)]
    pub fn kernel(&self, distance2: f32) -> f32 {
        if self.radius2 > 0.0 {
            let inverse = 1.0 / self.radius2;
            2.0 * core::f32::consts::FRAC_1_PI * inverse * (1.0 - distance2 * inverse)
        } else {
            0.0
        }
    }
}

/// Photons an estimate of irradiance averages over.
const NEIGHBOURS: usize = 64;

/// Estimates reach no farther than this many times the radius of [`NEIGHBOURS`] evenly spread photons: where there
/// are fewer photons, fewer are averaged over.
const REACH: f32 = 4.0;

/// Every how many photons one is made a point of known irradiance (Christensen 1999, section 4).
pub const STRIDE: usize = 4;

/// Radius within which the irradiance from `photons` is estimated, in scene units.
fn reach(photons: &Tree<'_, Photon>) -> f32 {
    REACH * photons.spacing() * libm::sqrtf(NEIGHBOURS as f32)
}

/// Computes value and radius of each of `points`, whose positions and normals are given, from `photons`.
///
/// That a point coincides with a photon makes up for the photons that are missing around a place whose nearest
/// point it is: looked up from anywhere, the estimate is right on average.
pub fn estimate(photons: &Tree<'_, Photon>, points: &mut [Irradiance]) {
    let mut found = Neighbours::<NEIGHBOURS>::default();
    let radius = reach(photons);
    for point in points {
        photons.k_nearest(&Query { position: point.position, normal: point.normal, radius }, &mut found);
        point.value = [0.0; 3];
        for (distance2, index) in found.entries() {
            let power = vec3::scale(photons.sites()[*index as usize].power, found.kernel(*distance2));
            point.value = [0, 1, 2].map(|c| point.value[c] + power[c]);
        }
        point.radius = libm::sqrtf(found.radius2());
    }
}

#[cfg(test)]
mod tests;
