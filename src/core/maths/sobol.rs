//! Owen-scrambled Sobol points, eight at a time, without state.
//!
//! The first two dimensions of Sobol's sequence (direction numbers of Joe and Kuo), shuffled and scrambled by
//! hashing: Burley, *Practical hash-based Owen scrambling*, JCGT 2020, with the hash of Vegdahl, *Building a
//! better LK hash*, psychopath.io 2021. Any 2^k consecutive samples from a multiple of 2^k on are a
//! (0, k, 2)-net. Further dimensions are padded sets: the same points, shuffled and scrambled by other keys.
//!
//! Limits: 2^32 points a key; coordinates are multiples of 2^-24 in [0, 1), never 1.

use wide::{f32x8, i8x32, i32x8, u32x8};

/// Point number `index` of the two-dimensional set `set` of the sequence named by `key`.
#[inline]
pub fn point(index: u32x8, key: u32x8, set: u32) -> (f32x8, f32x8) {
    let key = hash8(key ^ u32x8::splat(hash(set)));
    let first = owen(reverse(index), key);
    let shuffled = reverse(first);
    // Reversed, the first coordinate of point i is i; scrambling works on reversed bits.
    let x = owen(shuffled, hash8(key ^ u32x8::splat(0x9e37_79b9)));
    let y = owen(pascal(shuffled), hash8(key ^ u32x8::splat(0x85eb_ca6b)));
    (unit(reverse(x)), unit(reverse(y)))
}

/// The key of a frame.
#[inline]
pub(crate) fn frame_key(seed: u32, frame: u32) -> u32 {
    hash(hash(seed) ^ frame)
}

/// The keys of a frame's pixels.
///
/// Two words, mixed in one after the other: whatever one of them has in common with that of another frame, pixels of
/// the two frames share a key as rarely as chance has it. (By the first alone, frames whose keys differ in bits of the
/// coordinates only would have the same keys, in another order.)
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelKeys {
    inner: u32,
    outer: u32,
}

impl PixelKeys {
    pub fn new(seed: u32, frame: u32) -> Self {
        PixelKeys { inner: frame_key(seed, frame), outer: frame_key(frame, seed) }
    }

    /// The keys of the sequences of eight pixels; `place` is a row in the upper and a column in the lower half.
    #[inline(always)]
    pub fn at(self, place: u32x8) -> u32x8 {
        hash8(hash8(place ^ u32x8::splat(self.inner)) ^ u32x8::splat(self.outer))
    }
}

/// Mixes 32 bits, one to one (the function `lowbias32` of Wellons' hash prospector), 0 not to 0.
#[inline]
pub fn hash(x: u32) -> u32 {
    let mut x = x ^ 0x5bd1_e995;
    x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
    x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

/// [`hash`] in eight lanes.
#[inline]
pub fn hash8(x: u32x8) -> u32x8 {
    let mut x = x ^ u32x8::splat(0x5bd1_e995);
    x = (x ^ x >> 16) * u32x8::splat(0x7feb_352d);
    x = (x ^ x >> 15) * u32x8::splat(0x846c_a68b);
    x ^ x >> 16
}

/// Owen scrambling of bit-reversed numbers: a bit is flipped depending on the bits below it only.
#[inline(always)]
fn owen(x: u32x8, seed: u32x8) -> u32x8 {
    let mut x = x ^ (x * u32x8::splat(0x3d20_adea));
    x = (x + seed) * (seed >> 16 | u32x8::splat(1));
    x = x ^ (x * u32x8::splat(0x0552_6c56));
    x ^ (x * u32x8::splat(0x53a2_2864))
}

/// The second Sobol coordinate, bits reversed: the index as a polynomial p(z) over GF(2), taken to p(1 + z).
///
/// Since (1 + z)^(2^k) = 1 + z^(2^k), one shift and exclusive or for each k does it.
#[inline(always)]
fn pascal(x: u32x8) -> u32x8 {
    let mut x = x ^ x >> 16;
    x = x ^ (x & u32x8::splat(0xff00_ff00)) >> 8;
    x = x ^ (x & u32x8::splat(0xf0f0_f0f0)) >> 4;
    x = x ^ (x & u32x8::splat(0xcccc_cccc)) >> 2;
    x ^ (x & u32x8::splat(0xaaaa_aaaa)) >> 1
}

/// Reverses the order of the bits: that of each half of a byte by a table, then that of the bytes.
#[inline(always)]
fn reverse(x: u32x8) -> u32x8 {
    const REVERSED: [u8; 16] = [0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15];
    const LOW: i8x32 = table(REVERSED);
    const HIGH: i8x32 = table(shifted(REVERSED));
    const ORDER: i8x32 = table([3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12]);
    let half = u32x8::splat(0x0f0f_0f0f);
    let [low, high]: [i8x32; 2] = [x & half, x >> 4 & half].map(bytemuck::cast);
    let bytes = HIGH.swizzle_half_relaxed(low) | LOW.swizzle_half_relaxed(high);
    bytemuck::cast(bytes.swizzle_half_relaxed(ORDER))
}

/// A table of sixteen bytes, once for each half of a register.
const fn table(values: [u8; 16]) -> i8x32 {
    let (mut twice, mut i) = ([0; 32], 0);
    while i < 32 {
        twice[i] = values[i % 16] as i8;
        i += 1;
    }
    i8x32::new(twice)
}

/// Numbers of four bits, moved to the upper half of a byte.
const fn shifted(mut values: [u8; 16]) -> [u8; 16] {
    let mut i = 0;
    while i < 16 {
        values[i] <<= 4;
        i += 1;
    }
    values
}

/// The upper 24 bits as a fraction.
#[inline(always)]
fn unit(x: u32x8) -> f32x8 {
    let upper: i32x8 = bytemuck::cast(x >> 8);
    f32x8::from_i32x8(upper) * f32x8::splat(1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests;
