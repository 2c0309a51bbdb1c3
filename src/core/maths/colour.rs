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
