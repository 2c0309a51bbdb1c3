//! Values of textures, lane by lane.

use crate::maths::vec3::Vec3x8;
use crate::tracer::scene::{NO_TEXTURE, SceneData, Texture};
use wide::{f32x8, u32x8};

/// The lanes that have a texture.
#[inline(always)]
pub(super) fn is_some(texture: u32x8) -> f32x8 {
    bytemuck::cast(texture.simd_ne(u32x8::splat(NO_TEXTURE)))
}

/// Texture values by lane, white where a lane has none.
pub(super) fn textured(data: &SceneData<'_>, texture: u32x8, (u, v): (f32x8, f32x8)) -> Vec3x8 {
    let (u, v) = (u.to_array(), v.to_array());
    let mut rgb = [[1.0f32; 8]; 3];
    for (lane, texture) in texture.to_array().into_iter().enumerate().filter(|t| t.1 != NO_TEXTURE) {
        let value = bilinear(&data.textures[texture as usize], data.texels, u[lane], v[lane]);
        for (row, value) in rgb.iter_mut().zip(value) {
            row[lane] = value;
        }
    }
    Vec3x8::new(rgb[0].into(), rgb[1].into(), rgb[2].into())
}

/// Bilinear interpolation between the four nearest texels of the texture, repeated or clamped.
pub(super) fn bilinear(texture: &Texture, texels: &[[f32; 3]], u: f32, v: f32) -> [f32; 3] {
    let [u, v] = [(u, 0), (v, 1)].map(|(x, axis)| x * texture.scale[axis] + texture.offset[axis]);
    let around = if texture.clamp { clamped } else { neighbours };
    let (x0, x1, fx) = around(u, texture.width);
    let (y0, y1, fy) = around(1.0 - v, texture.height);
    let texel =
        |x: u32, y: u32| texels[texture.first as usize + y as usize * texture.width as usize + x as usize];
    let mix = |a: [f32; 3], b: [f32; 3], f: f32| [0, 1, 2].map(|c| a[c] + (b[c] - a[c]) * f);
    mix(mix(texel(x0, y0), texel(x1, y0), fx), mix(texel(x0, y1), texel(x1, y1), fx), fy)
}

/// The two texels around coordinate `u` (period 1) and the weight of the second.
fn neighbours(u: f32, size: u32) -> (u32, u32, f32) {
    let turn = u - libm::floorf(u);
    let position = if turn.is_finite() { turn * size as f32 - 0.5 } else { 0.0 };
    let below = libm::floorf(position);
    let first = if below < 0.0 { size - 1 } else { (below as u32).min(size - 1) };
    (first, (first + 1) % size, position - below)
}

/// The two texels around coordinate `u`, those of the edge beyond 0 and 1, and the weight of the second.
fn clamped(u: f32, size: u32) -> (u32, u32, f32) {
    let position = (u * size as f32 - 0.5).clamp(0.0, (size - 1) as f32);
    let position = if position.is_finite() { position } else { 0.0 };
    let first = position as u32;
    (first, (first + 1).min(size - 1), position - first as f32)
}
