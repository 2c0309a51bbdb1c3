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
        let used = shadows.take();
        assert_eq!((used, shadows.lanes()), ((1 << lanes) - 1, 0));
        shadows.deliver(used, &mut radiance);
        packets += 1;
    };
    for first in (0..RAYS).step_by(8) {
        let mut left = (0..8).filter(|bit| wanted(first + bit)).fold(0, |bits, bit| bits | 1 << bit);
        while left != 0 {
            left = shadows.fill(&rays(first, slot), left);
            if shadows.lanes() == 8 {
                trace(&mut shadows);
            }
        }
    }
    if shadows.lanes() > 0 {
        trace(&mut shadows);
    }
    for n in 0..RAYS {
        let due = if wanted(n) { value(n) } else { [0.0; 3] };
        assert_eq!(sums(&radiance, slot(n)), due, "ray {n}");
    }
    assert_eq!(packets, (0..RAYS).filter(|n| wanted(*n)).count().div_ceil(8));
}

#[test]
fn what_does_not_fit_is_handed_back() {
    let mut shadows = Shadows::default();
    assert_eq!(shadows.fill(&rays(0, |n| n), 0b0111_1010), 0);
    assert_eq!(shadows.lanes(), 5);
    assert_eq!(shadows.fill(&rays(8, |n| n), 0b1110_1101), 0b1110_0000, "room for three");
    assert_eq!(shadows.fill(&rays(16, |n| n), 0b0000_0011), 0b0000_0011, "no room");
    let packed = shadows.rays();
    let numbers = [1, 3, 4, 5, 6, 8, 10, 11].map(|n: u32| n as f32);
    for (lane, number) in numbers.into_iter().enumerate() {
        let all = [packed.origin.x, packed.origin.y, packed.origin.z, packed.direction.x];
        let found = all.map(|row| row.to_array()[lane]);
        assert_eq!(found, [100.0, 100.25, 100.5, 200.0].map(|offset| number + offset), "lane {lane}");
        assert_eq!(packed.direction.y.to_array()[lane], number + 200.25);
        assert_eq!(packed.direction.z.to_array()[lane], number + 200.5);
        assert_eq!(packed.t_max.to_array()[lane], number + 300.0);
        assert_eq!(packed.time.to_array()[lane], number + 400.0);
    }
}

/// Rays that are blocked deliver nothing; several for the same sample add up.
#[test]
fn only_free_rays_deliver_and_values_add_up() {
    let mut shadows = Shadows::default();
    shadows.fill(&rays(0, |n| n / 4 + 8), 0b1111_1111);
    shadows.take();
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
    assert_eq!((shadows.rays().active(), shadows.take()), (0, 0));
}
