//! Layers of a frame's file beside the picture.

use clap::ValueEnum;
use pmcip_core::sampler::estimate::Estimator;

/// A layer of a frame's EXR file. Its channels have the suffixes by which programs know colours, vectors and depths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Layer {
    /// Coverage: the part of the pixel where a surface is seen, 0 to 1; R, G and B are premultiplied by it
    #[value(name = "A")]
    Coverage,
    /// The estimator `difference`: noisy, unbiased in every pixel; `pmcip guide` takes its energy from it
    Unbiased,
    /// The estimator `balanced`: what was sampled, not filtered
    Balanced,
    /// Part of the light that the first rough surface reflects, through mirrors and smooth glass; 1 where it shines
    Albedo,
    /// Shading normal of that surface, in the scene's axes
    Normal,
    /// Length of the way from the eye to that surface, in scene units; 1e10 where nothing is seen
    Depth,
    /// Pixels, to the right and downwards, by which what is seen has moved since the frame before; needs --frames
    Motion,
    /// Variance of the pixel's mean, luminance
    Variance,
    /// Samples of the pixel
    Count,
    /// Weights of the last iteration, which sum to 1
    Kernel,
}

impl Layer {
    /// The name by which it is asked for.
    pub fn name(self) -> &'static str {
        match self {
            Layer::Coverage => "A",
            Layer::Unbiased => "unbiased",
            Layer::Balanced => "balanced",
            Layer::Albedo => "albedo",
            Layer::Normal => "normal",
            Layer::Depth => "depth",
            Layer::Motion => "motion",
            Layer::Variance => "variance",
            Layer::Count => "count",
            Layer::Kernel => "kernel",
        }
    }

    /// Its channels in the file.
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Layer::Coverage => &["A"],
            Layer::Unbiased => &["unbiased.R", "unbiased.G", "unbiased.B"],
            Layer::Balanced => &["balanced.R", "balanced.G", "balanced.B"],
            Layer::Albedo => &["albedo.R", "albedo.G", "albedo.B"],
            Layer::Normal => &["normal.X", "normal.Y", "normal.Z"],
            Layer::Depth => &["depth.Z"],
            Layer::Motion => &["motion.X", "motion.Y"],
            Layer::Variance => &["variance"],
            Layer::Count => &["count"],
            Layer::Kernel => &["kernel.weight"],
        }
    }

    /// Whether a film that accumulates for `estimator` can make it.
    pub fn is_served_by(self, estimator: Estimator) -> bool {
        match self {
            Layer::Unbiased => estimator.serves(Estimator::Difference),
            Layer::Balanced => estimator.serves(Estimator::Balanced),
            _ => true,
        }
    }
}

/// A set of layers.
///
/// ```
/// use pmcip::frame::settings::{Layer, Layers};
///
/// let layers: Layers = [Layer::Depth, Layer::Coverage].into_iter().collect();
/// assert_eq!(layers.iter().map(Layer::name).collect::<Vec<_>>(), ["A", "depth"]);
/// assert!(Layers::default().contains(Layer::Variance) && !layers.contains(Layer::Variance));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layers(u16);

impl Default for Layers {
    /// What was sampled: variance, count and kernel.
    fn default() -> Layers {
        [Layer::Variance, Layer::Count, Layer::Kernel].into_iter().collect()
    }
}

impl FromIterator<Layer> for Layers {
    fn from_iter<I: IntoIterator<Item = Layer>>(layers: I) -> Layers {
        Layers(layers.into_iter().fold(0, |set, layer| set | 1 << layer as u16))
    }
}

impl Layers {
    /// Whether it has `layer`.
    pub fn contains(self, layer: Layer) -> bool {
        self.0 >> layer as u16 & 1 == 1
    }

    /// The layers in their order.
    pub fn iter(self) -> impl Iterator<Item = Layer> {
        Layer::value_variants().iter().copied().filter(move |layer| self.contains(*layer))
    }
}
