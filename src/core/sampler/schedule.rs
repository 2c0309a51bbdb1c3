//! How a budget of samples is divided over iterations.

/// Sample counts of the iterations of a frame; they sum to the budget exactly.
///
/// The first iteration is the uniform pilot, the others share the rest equally, up to a sample.
///
/// ```
/// use pmcip_core::sampler::Schedule;
/// assert!(Schedule::new(100, 16, 2, 8).eq([200; 8]));
/// assert!(Schedule::new(100, 16, 4, 3).eq([400, 600, 600])); // the paper's 4 + 6 + 6
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    pilot: u64,
    rest: u64,
    parts: u64,
    next: u64,
}

impl Schedule {
    /// Divides `spp` samples a pixel over `iterations`, `pilot_spp` of them for the first.
    ///
    /// One iteration takes the whole budget. Iterations that would be left without a sample are left out.
    pub fn new(pixels: u64, spp: u32, pilot_spp: u32, iterations: u32) -> Schedule {
        let total = pixels.saturating_mul(u64::from(spp));
        let pilot =
            if iterations < 2 { total } else { pixels.saturating_mul(u64::from(pilot_spp)).min(total) };
        let rest = total - pilot;
        Schedule { pilot, rest, parts: u64::from(iterations.max(1) - 1).min(rest), next: 0 }
    }

    /// The first `k` of the equal parts together.
    fn share(&self, k: u64) -> u64 {
        (u128::from(self.rest) * u128::from(k) / u128::from(self.parts.max(1))) as u64
    }
}

impl Iterator for Schedule {
    type Item = u64;

    fn next(&mut self) -> Option<u64> {
        let k = self.next;
        self.next += 1;
        match k {
            0 if self.pilot > 0 => Some(self.pilot),
            0 => self.next(),
            k if k <= self.parts => Some(self.share(k) - self.share(k - 1)),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_sum_to_the_budget() {
        for pixels in [0, 1, 7, 1_000_003, 1 << 28] {
            for (spp, pilot, iterations) in [
                (0, 2, 8),
                (1, 2, 8),
                (2, 2, 2),
                (3, 2, 8),
                (16, 2, 8),
                (17, 4, 3),
                (64, 2, 1),
                (5, 0, 3),
                (9, 1, 0),
            ] {
                let schedule = Schedule::new(pixels, spp, pilot, iterations);
                assert_eq!(schedule.sum::<u64>(), pixels * u64::from(spp));
                assert!(schedule.count() as u32 <= iterations.max(1));
                assert!(schedule.into_iter().all(|n| n > 0));
            }
        }
    }
}
