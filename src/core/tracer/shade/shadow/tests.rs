use super::*;

/// Eight rays numbered from `first` on; what they carry and where to follows from the number.
fn rays(first: u32, slot: fn(u32) -> u32) -> ShadowRays {
    let number = [0, 1, 2, 3, 4, 5, 6, 7].map(|lane| first + lane);
    let row = |factor: f32, offset: f32| f32x8::from(number.map(|n| n as f32 * factor + offset));
    let vector = |offset: f32| Vec3x8::new(row(1.0, offset), row(1.0, offset + 0.25), row(1.0, offset + 0.5));
    ShadowRays {
        time: row(1.0, 400.0),
        origin: vector(100.0),
        direction: vector(200.0),
        t_max: row(1.0, 300.0),
        value: Vec3x8::new(row(1.0, 1.0), row(4.0, 2.0), row(16.0, 3.0)),
        slot: u32x8::from(number.map(slot)),
    }
}

fn sums(radiance: &[Rgb8], slot: u32) -> [f32; 3] {
    let (batch, lane) = (&radiance[slot as usize / 8], slot as usize % 8);
    [batch.r, batch.g, batch.b].map(|row| row.to_array()[lane])
}

const fn value(n: u32) -> [f32; 3] {
    [n as f32 + 1.0, 4.0 * n as f32 + 2.0, 16.0 * n as f32 + 3.0]
}

/// A few rays at a time, through packets that fill up in the middle: every wanted value arrives once, where it
/// should, and nothing else does.
#[test]
fn each_value_reaches_its_sample_once() {
    const RAYS: u32 = 64;
    let slot: fn(u32) -> u32 = |n| (n * 37 + 5) % RAYS;
    let wanted = |n: u32| !crate::maths::sobol::hash(n).is_multiple_of(4);
    let mut radiance = [Rgb8::default(); RAYS as usize / 8];
    let mut shadows = Shadows::default();
    let mut packets = 0;
    let mut trace = |shadows: &mut Shadows| {
        let lanes = shadows.lanes();
        assert_eq!(shadows.rays().active(), (1 << lanes) - 1);
        // What has no ray delivers nothing.
        shadows.deliver(u32::MAX, &mut radiance);
        shadows.pass();
        packets += 1;
    };
    for first in (0..RAYS).step_by(8) {
        let lanes = (0..8).filter(|bit| wanted(first + bit)).fold(0, |bits, bit| bits | 1 << bit);
        shadows.fill(&rays(first, slot), lanes);
        if shadows.lanes() == 8 {
            trace(&mut shadows);
        }
    }
    if shadows.lanes() > 0 {
        trace(&mut shadows);
    }
    assert_eq!(shadows.lanes(), 0);
    for n in 0..RAYS {
        let due = if wanted(n) { value(n) } else { [0.0; 3] };
        assert_eq!(sums(&radiance, slot(n)), due, "ray {n}");
    }
    assert_eq!(packets, (0..RAYS).filter(|n| wanted(*n)).count().div_ceil(8));
}

/// Five rays, then six: a packet of eight, and the last three of the six wait.
#[test]
fn what_does_not_fit_waits() {
    let mut shadows = Shadows::default();
    shadows.fill(&rays(0, |n| n), 0b0111_1010);
    assert_eq!(shadows.lanes(), 5);
    shadows.fill(&rays(8, |n| n), 0b1110_1101);
    assert_eq!(shadows.lanes(), 8);
    for numbers in [&[1, 3, 4, 5, 6, 8, 10, 11][..], &[13, 14, 15]] {
        let packed = shadows.rays();
        assert_eq!(shadows.lanes() as usize, numbers.len());
        for (lane, number) in numbers.iter().map(|n: &u32| *n as f32).enumerate() {
            let all = [packed.origin.x, packed.origin.y, packed.origin.z, packed.direction.x];
            let found = all.map(|row| row.to_array()[lane]);
            assert_eq!(found, [100.0, 100.25, 100.5, 200.0].map(|offset| number + offset), "lane {lane}");
            assert_eq!(packed.direction.y.to_array()[lane], number + 200.25);
            assert_eq!(packed.direction.z.to_array()[lane], number + 200.5);
            assert_eq!(packed.t_max.to_array()[lane], number + 300.0);
            assert_eq!(packed.time.to_array()[lane], number + 400.0);
        }
        shadows.pass();
    }
    assert_eq!(shadows.lanes(), 0);
}

/// Rays that are blocked deliver nothing; several for the same sample add up.
#[test]
fn only_free_rays_deliver_and_values_add_up() {
    let mut shadows = Shadows::default();
    shadows.fill(&rays(0, |n| n / 4 + 8), 0b1111_1111);
    let mut radiance = [Rgb8::default(); 2];
    shadows.deliver(0b0101_0110, &mut radiance);
    let sum = |a: u32, b: u32| [0, 1, 2].map(|c| value(a)[c] + value(b)[c]);
    assert_eq!(sums(&radiance, 8), sum(1, 2));
    assert_eq!(sums(&radiance, 9), sum(4, 6));
    assert!((0..8).chain(10..16).all(|slot| sums(&radiance, slot) == [0.0; 3]));
}

#[test]
fn an_empty_packet_has_no_rays() {
    let mut shadows = Shadows::default();
    assert_eq!((shadows.rays().active(), shadows.lanes()), (0, 0));
    shadows.pass();
    assert_eq!(shadows.lanes(), 0);
}
