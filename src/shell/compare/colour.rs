//! Numbers as colours, and pixels as pictures inside a page.

use super::raster::Raster;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

/// Control points of a colour map, evenly spaced, sRGB.
pub type Map = [[u8; 3]];

/// Viridis (van der Walt and Smith 2015), perceptually uniform from dark to bright.
pub const VIRIDIS: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];

/// From blue over white to red, as light at both ends: what is too dark, and what is too bright.
pub const BLUE_RED: [[u8; 3]; 5] =
    [[33, 76, 152], [128, 168, 214], [246, 246, 246], [226, 145, 122], [164, 32, 41]];

/// What numbers which colours stand for; what lies outside gets the colour of the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Number of the first colour.
    pub low: f64,
    /// Number of the last colour.
    pub high: f64,
    /// Whether equal factors, not equal differences, are equally far apart.
    pub logarithmic: bool,
    /// The colours.
    pub map: &'static Map,
}

impl Scale {
    /// A logarithmic scale that leaves out the lowest and highest half per cent of `values`.
    pub fn logarithmic(values: impl Iterator<Item = f64>) -> Scale {
        let positive = sorted(values.filter(|value| *value > 0.0));
        let (low, high) = (quantile(&positive, 0.005), quantile(&positive, 0.995));
        let (low, high) = if low.is_finite() { (low, high) } else { (1.0, 1.0) };
        // A single value gets the middle of a scale that is at least a factor of four wide.
        let widen = (4.0 * low / high).max(1.0).sqrt();
        Scale { low: low / widen, high: high * widen, logarithmic: true, map: &VIRIDIS }
    }

    /// A linear scale around zero that leaves out the one per cent of `values` farthest from it.
    pub fn symmetric(values: impl Iterator<Item = f64>) -> Scale {
        let sizes = sorted(values.map(f64::abs));
        let high = quantile(&sizes, 0.99);
        let high = if high > 0.0 { high } else { 1.0 };
        Scale { low: -high, high, logarithmic: false, map: &BLUE_RED }
    }

    /// The colour of a number; what is not a number is black.
    pub fn colour(&self, value: f64) -> [u8; 3] {
        if value.is_nan() {
            return [0; 3];
        }
        let position = if self.logarithmic {
            (value.max(self.low) / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        blend(self.map, position.clamp(0.0, 1.0))
    }

    /// The colours as a gradient of CSS.
    pub fn gradient(&self) -> String {
        let stops: Vec<String> = self.map.iter().map(|[r, g, b]| format!("rgb({r},{g},{b})")).collect();
        format!("linear-gradient(90deg,{})", stops.join(","))
    }
}

/// The colour at `position`, 0 to 1.
fn blend(map: &Map, position: f64) -> [u8; 3] {
    let place = position * (map.len() - 1) as f64;
    let left = (place as usize).min(map.len() - 2);
    let part = place - left as f64;
    let mix = |a: u8, b: u8| (f64::from(a) + part * (f64::from(b) - f64::from(a))).round() as u8;
    [0, 1, 2].map(|i| mix(map[left][i], map[left + 1][i]))
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_unstable_by(f64::total_cmp);
    values
}

/// The value below which a part of the sorted `values` lies; not a number if there is none.
pub fn quantile(values: &[f64], part: f64) -> f64 {
    let last = values.len().saturating_sub(1) as f64;
    values.get((last * part).round() as usize).copied().unwrap_or(f64::NAN)
}

/// The picture as an address that carries it.
pub fn data_uri(raster: &Raster) -> String {
    let mut png = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut png, CompressionType::Default, FilterType::Adaptive);
    let pixels = raster.pixels.as_flattened();
    // Memory takes every byte, and the sizes are right by construction.
    let written =
        encoder.write_image(pixels, raster.width as u32, raster.height as u32, ExtendedColorType::Rgb8);
    debug_assert!(written.is_ok());
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_meet_their_ends_and_middle() {
        let scale = Scale { low: 1.0, high: 100.0, logarithmic: true, map: &VIRIDIS };
        assert_eq!(scale.colour(1.0), VIRIDIS[0]);
        assert_eq!(scale.colour(10.0), VIRIDIS[4]);
        assert_eq!(scale.colour(1e9), VIRIDIS[8]);
        assert_eq!(scale.colour(0.0), VIRIDIS[0]);
        assert_eq!(scale.colour(f64::NAN), [0; 3]);
        assert_eq!(Scale::symmetric([-2.0, 1.0].into_iter()).colour(0.0), BLUE_RED[2]);
    }

    #[test]
    fn a_single_value_is_in_the_middle_of_its_scale() {
        let scale = Scale::logarithmic([3.0, 3.0].into_iter());
        assert!((scale.low - 1.5).abs() < 1e-12 && (scale.high - 6.0).abs() < 1e-12);
        assert_eq!(scale.colour(3.0), VIRIDIS[4]);
        assert_eq!(Scale::logarithmic(std::iter::empty()).colour(1.0), VIRIDIS[4]);
    }
}
