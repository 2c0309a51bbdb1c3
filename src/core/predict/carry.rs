//! Moves planes along a correspondence.

use super::belief::Error;

/// Moves a plane: every pixel takes what the pixel at its position in `positions` had `before`.
///
/// `nothing` where the position is outside of the picture or not a number. The nearest pixel is taken as it is:
/// blending would blur a plane that is carried through many frames.
///
/// # Errors
/// [`Error::Size`] if a slice has not `width · height` entries.
pub fn carry<T: Copy>(
    before: &[T],
    width: usize,
    height: usize,
    positions: &[[f32; 2]],
    nothing: T,
    out: &mut [T],
) -> Result<(), Error> {
    let pixels = width.checked_mul(height).ok_or(Error::Size)?;
    if [before.len(), positions.len(), out.len()] != [pixels; 3] {
        return Err(Error::Size);
    }
    for (out, position) in out.iter_mut().zip(positions) {
        *out = pixel_at(*position, width, height).map_or(nothing, |i| before[i]);
    }
    Ok(())
}

/// Index of the pixel at a position.
#[inline]
pub(super) fn pixel_at([x, y]: [f32; 2], width: usize, height: usize) -> Option<usize> {
    let inside = x >= 0.0 && y >= 0.0 && x < width as f32 && y < height as f32;
    inside.then(|| (y as usize).min(height - 1) * width + (x as usize).min(width - 1))
}
