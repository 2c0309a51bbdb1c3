//! The k nearest records, kept in a heap, and the kernel that weighs them.

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
    pub(super) fn clear(&mut self) {
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
    pub(super) fn end(&mut self, radius2: f32) {
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
    pub(super) fn insert(&mut self, distance: f32, index: u32, limit: f32) -> f32 {
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
