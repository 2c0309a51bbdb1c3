//! The features of largest response, as many as fit.

use super::feature::Feature;

/// A heap on lent memory: once it is full, the weakest is on top.
pub(super) struct Strongest<'a> {
    slots: &'a mut [Feature],
    len: usize,
}

impl<'a> Strongest<'a> {
    pub fn new(slots: &'a mut [Feature]) -> Self {
        Strongest { slots, len: 0 }
    }

    /// Features kept.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether a feature of this response would be kept.
    pub fn wants(&self, response: f32) -> bool {
        self.len < self.slots.len()
            || self.slots.first().is_some_and(|weakest| weakest.response.abs() < response.abs())
    }

    /// Keeps a feature if there is room or a weaker one.
    pub fn push(&mut self, feature: Feature) {
        if self.len < self.slots.len() {
            self.slots[self.len] = feature;
            self.len += 1;
            if self.len == self.slots.len() {
                (0..self.len / 2).rev().for_each(|i| self.sift(i));
            }
        } else if self.wants(feature.response) {
            self.slots[0] = feature;
            self.sift(0);
        }
    }

    /// Moves a feature down until none below it is weaker.
    fn sift(&mut self, mut i: usize) {
        let strength = |f: &Feature| f.response.abs();
        loop {
            let children = [2 * i + 1, 2 * i + 2].into_iter().filter(|child| *child < self.len);
            let weaker =
                |a: &usize, b: &usize| strength(&self.slots[*a]).total_cmp(&strength(&self.slots[*b]));
            match children.min_by(weaker) {
                Some(child) if strength(&self.slots[child]) < strength(&self.slots[i]) => {
                    self.slots.swap(i, child);
                    i = child;
                }
                _ => return,
            }
        }
    }
}
