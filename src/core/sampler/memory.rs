//! How much memory a film takes, and that memory, lent.

use super::film::{FLOATS, WORDS};

/// Memory lent to a sampler for its film. What it holds before does not matter.
#[derive(Debug)]
pub struct Memory<'a> {
    /// At least as long as [`Required::floats`].
    pub floats: &'a mut [f32],
    /// At least as long as [`Required::words`].
    pub words: &'a mut [u32],
}

/// How much memory a sampler needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Required {
    /// Length of [`Memory::floats`].
    pub floats: usize,
    /// Length of [`Memory::words`].
    pub words: usize,
}

impl Required {
    /// Of a film of this size, whose pixels have labels or not.
    pub(super) fn of(width: u32, height: u32, labelled: bool) -> Required {
        let pixels = (width as usize).saturating_mul(height as usize);
        let words = WORDS + usize::from(labelled);
        Required { floats: FLOATS.saturating_mul(pixels), words: words.saturating_mul(pixels) }
    }
}
