//! Which samples are rejected, and which paths simply end.

use super::*;
use crate::tracer::shade::vertex::ROULETTE_DEPTH;

/// Eight samples' paths along z that carry one half, and their radiance.
fn paths() -> (Paths, [Rgb8; 1]) {
    let paths = Paths {
        origin: Vec3x8::default(),
        direction: Vec3x8::splat([0.0, 0.0, 1.0]),
        throughput: Vec3x8::splat([0.5; 3]),
        density: f32x8::ONE,
        compression: f32x8::ONE,
        normal: u32x8::ZERO,
        index: u32x8::ZERO,
        key: u32x8::ZERO,
        slot: u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]),
        lanes: 8,
    };
    (paths, [Rgb8::default()])
}

#[test]
fn only_what_is_not_a_number_is_rejected() {
    let nan = f32::NAN;
    let (mut paths, mut radiance) = paths();
    // Sound; each channel lost; nothing left; no direction; lost, but not hit; infinite.
    paths.throughput.x = f32x8::new([0.5, nan, 0.5, 0.5, 0.0, 0.5, nan, f32::INFINITY]);
    paths.throughput.y = f32x8::new([0.5, 0.5, nan, 0.5, 0.0, 0.5, nan, 0.5]);
    paths.throughput.z = f32x8::new([0.5, 0.5, 0.5, nan, 0.0, 0.5, nan, 0.5]);
    paths.direction.y = f32x8::new([0.0, 0.0, 0.0, 0.0, 0.0, nan, 0.0, 0.0]);
    let hit = crate::tracer::shade::queue::lane_mask(0b1011_1111);
    reject_nan(&paths, hit, &mut radiance);
    for channel in [radiance[0].r, radiance[0].g, radiance[0].b] {
        assert_eq!(channel.is_nan().to_bitmask(), 0b0010_1110);
        assert!((channel.is_nan() | channel.simd_eq(f32x8::ZERO)).all());
    }
}

/// The roulette divides by a survival of zero where nothing is carried: that path ends, and no sample is rejected for it.
#[test]
fn paths_that_carry_nothing_just_end() {
    let (mut paths, mut radiance) = paths();
    paths.throughput = Vec3x8::default();
    for depth in [1, ROULETTE_DEPTH] {
        let mut next = paths;
        reject_nan(&next, f32x8::ONE.simd_eq(f32x8::ONE), &mut radiance);
        assert!(!survivors(&mut next, f32x8::ONE.simd_eq(f32x8::ONE), depth).any());
    }
    assert_eq!(radiance, [Rgb8::default()]);
}
