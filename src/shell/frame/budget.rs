//! Whether there is enough memory for a frame.

use super::layers;
use super::settings::{Layer, Settings};
use crate::error::Error;
use crate::machine::{free_memory, giga};
use pmcip_core::sampler::estimate::Estimator;

/// Bytes that a frame takes at most at once, without the scene and the files' buffers; `judged` if its Err is estimated.
fn needed(settings: &Settings, judged: bool) -> u64 {
    /// The film, a frame's planes, what one more of them takes, and what filtering takes, a pixel.
    const FILM: u64 = 44;
    const FRAME: u64 = 24;
    const PLANE: u64 = 4;
    const FEATURES: u64 = 28;
    const FILTER: u64 = 116;
    /// What the judge keeps, and what it takes while it looks.
    const JUDGE: u64 = 56 + 24;
    let guided = settings.sampler.estimator == Estimator::Guided;
    let planes: usize = settings.layers.iter().map(|layer: Layer| layer.channels().len()).sum();
    let mut pixel = FILM + FRAME + PLANE * planes as u64;
    if guided || layers::need_features(settings.layers) {
        pixel += FEATURES;
    }
    if guided {
        pixel += FILTER;
    }
    if judged {
        pixel += JUDGE;
    }
    settings.pixels().saturating_mul(pixel)
}

/// Refuses a frame for which there is not enough memory, which systems that promise more than they have would not: they
/// end the program in the middle of its work.
///
/// # Errors
/// [`Error::Work`] that says how much is needed and how much there is.
pub(crate) fn require(settings: &Settings, judged: bool) -> Result<(), Error> {
    match free_memory() {
        Some(available) => enough(settings, needed(settings, judged), available),
        None => Ok(()),
    }
}

fn enough(settings: &Settings, needed: u64, available: u64) -> Result<(), Error> {
    if needed <= available {
        return Ok(());
    }
    let (width, height) = (settings.sampler.width, settings.sampler.height);
    Err(Error::Work(format!(
        "not enough memory: {width}×{height} pixels need {}, {} are free",
        giga(needed),
        giga(available)
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::settings::Method;
    use crate::scene::Animation;
    use std::path::Path;

    #[test]
    fn what_is_needed_is_said() {
        let cornell = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
        let cornell = Animation::open(&cornell, &Default::default()).unwrap();
        let mut settings = Settings::new(cornell.scene(), Method::Pmc, None, Some((16384, 16384)));
        // Film and picture, and the three planes that every file has by default.
        assert_eq!(needed(&settings, false), (1 << 28) * (44 + 24 + 12));
        assert_eq!(needed(&settings, true), (1 << 28) * (44 + 24 + 12 + 80));
        settings.set_estimator(Estimator::Guided);
        assert_eq!(needed(&settings, false), (1 << 28) * (44 + 24 + 12 + 28 + 116));
        assert!(enough(&settings, needed(&settings, false), u64::MAX).is_ok());
        let refusal = enough(&settings, needed(&settings, false), 8_000_000_000).unwrap_err().to_string();
        assert_eq!(refusal, "not enough memory: 16384×16384 pixels need 60.1 GB, 8.0 GB are free");
    }
}
