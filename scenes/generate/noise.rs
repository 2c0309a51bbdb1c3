//! Noise from integer hashes: the same bits wherever arithmetic is IEEE 754.

use glam::{IVec3, Vec3};

/// A number in `[0, 1)` for a key, without visible pattern (the finaliser of MurmurHash3).
pub fn hash(key: u32) -> f32 {
    let mut h = key.wrapping_mul(0x9E37_79B9) ^ 0x85EB_CA6B;
    h = (h ^ (h >> 16)).wrapping_mul(0x85EB_CA6B);
    h = (h ^ (h >> 13)).wrapping_mul(0xC2B2_AE35);
    ((h ^ (h >> 16)) >> 8) as f32 / (1 << 24) as f32
}

/// A number in `[low, high)` for a key.
pub fn between(key: u32, low: f32, high: f32) -> f32 {
    low + (high - low) * hash(key)
}

fn lattice(p: IVec3) -> f32 {
    let key = (p.x as u32).wrapping_mul(73_856_093)
        ^ (p.y as u32).wrapping_mul(19_349_663)
        ^ (p.z as u32).wrapping_mul(83_492_791);
    2.0 * hash(key) - 1.0
}

/// Smooth noise of wavelength 1 in `[-1, 1]`.
pub fn value(p: Vec3) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    let w = f * f * (3.0 - 2.0 * f);
    let cell = cell.as_ivec3();
    let corner = |x, y, z| lattice(cell + IVec3::new(x, y, z));
    let row = |y, z| corner(0, y, z) + w.x * (corner(1, y, z) - corner(0, y, z));
    let layer = |z| row(0, z) + w.y * (row(1, z) - row(0, z));
    layer(0) + w.z * (layer(1) - layer(0))
}

/// `octaves` of noise, each twice as fine and half as strong as the one before.
pub fn fractal(p: Vec3, octaves: u32) -> f32 {
    let octave = |i: u32| value(p * (1 << i) as f32 + 17.3 * i as f32) / (1 << i) as f32;
    (0..octaves).map(octave).sum()
}
