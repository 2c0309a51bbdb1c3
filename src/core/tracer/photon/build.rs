//! Builds the tree: medians along the widest axis, in place.

use super::record::{self, Error, Leaf, Site, Split};

/// Orders `sites` and writes the tree over them. The same records in the same order give the same tree.
///
/// # Errors
/// [`Error::Length`] unless there are [`leaves`](super::leaves)`(sites.len())` leaves and one split less.
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

pub(super) fn check_lengths(sites: usize, splits: &[Split], leaves: &[Leaf]) -> Result<(), Error> {
    if sites > u32::MAX as usize - 8 {
        return Err(Error::TooMany);
    }
    let fits = leaves.len() == record::leaves(sites) && splits.len() + 1 == leaves.len();
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
pub(super) fn extent<T: Site>(sites: &[T]) -> [f32; 3] {
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for site in sites {
        let p = site.position();
        low = [0, 1, 2].map(|i| low[i].min(p[i]));
        high = [0, 1, 2].map(|i| high[i].max(p[i]));
    }
    [0, 1, 2].map(|i| (high[i] - low[i]).max(0.0))
}
