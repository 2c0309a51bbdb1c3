//! Colours: linear Rec. 709.

use wide::f32x8;

/// Weights of red, green and blue in luminance (ITU-R BT.709).
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Luminance Y of a colour by the weights of ITU-R BT.709, in the colour's own unit.
#[inline]
pub fn luminance([r, g, b]: [f32; 3]) -> f32 {
    LUMINANCE[0] * r + LUMINANCE[1] * g + LUMINANCE[2] * b
}

/// [`luminance`] in eight lanes.
#[inline(always)]
pub fn luminance8([r, g, b]: [f32x8; 3]) -> f32x8 {
    let [red, green, blue] = LUMINANCE.map(f32x8::splat);
    r * red + g * green + b * blue
}

/// Sum of the squared luminances of colours, by the sums of r², g², b², nothing, rg, gb, br, nothing.
#[inline(always)]
pub fn squared_luminance(products: f32x8) -> f32 {
    let [red, green, blue] = LUMINANCE;
    let (of_green, of_blue, of_red) = (2.0 * red * green, 2.0 * green * blue, 2.0 * blue * red);
    let weights = [red * red, green * green, blue * blue, 0.0, of_green, of_blue, of_red, 0.0];
    let [a, b, c, _, d, e, f, _] = (products * f32x8::from(weights)).to_array();
    (a + d) + (b + e) + (c + f)
}
