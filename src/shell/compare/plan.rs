//! What to render, how often, and with which seeds.

use super::reference;
use super::variant::Variant;
use crate::frame::settings::{Method, Settings};
use crate::picture::frame_io::Picture;

/// What to render.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The methods; the first is the baseline of all ratios.
    pub variants: Vec<Variant>,
    /// Samples a pixel, rising.
    pub spp: Vec<u32>,
    /// Renders of each method at each sample count.
    pub runs: u32,
    /// Size, integrator, depth, camera and first seed of all renders; the rest is the variants' own.
    pub base: Settings,
    /// Threads, or all there are.
    pub threads: Option<usize>,
}

impl Plan {
    /// A plan that has the baseline, uniform sampling, first, and every method and sample count once.
    pub fn new(methods: &[Variant], spp: &[u32], runs: u32, base: Settings, threads: Option<usize>) -> Plan {
        let mut variants = vec![Variant::from(Method::Uniform)];
        for variant in methods {
            if !variants.contains(variant) {
                variants.push(variant.clone());
            }
        }
        let mut spp = spp.to_vec();
        spp.sort_unstable();
        spp.dedup();
        Plan { variants, spp, runs, base, threads }
    }

    /// Samples a pixel of all renders of so many frames together.
    pub fn total_spp(&self, frames: usize) -> u64 {
        let once: u64 = self.spp.iter().map(|spp| u64::from(*spp)).sum();
        once * self.variants.len() as u64 * u64::from(self.runs) * frames as u64 + self.warm_up_spp()
    }

    /// Samples a pixel of the render that is not counted.
    fn warm_up_spp(&self) -> u64 {
        self.spp.first().map_or(0, |spp| u64::from(*spp))
    }

    /// Seeds of the renders in their order: one each, and never the reference's.
    pub(super) fn seeds(&self, reference: &Picture) -> impl Iterator<Item = u32> + use<> {
        let taken = reference::seeds(reference);
        let free = move |seed: &u32| taken.as_ref().is_none_or(|taken| !taken.contains(seed));
        let first = self.base.sampler.seed;
        (0..=u32::MAX).map(move |k| first.wrapping_add(k)).filter(free)
    }
}
