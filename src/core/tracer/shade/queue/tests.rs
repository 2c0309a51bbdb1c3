extern crate std;

use super::*;
use crate::tracer::scene::SceneData;
use std::vec::Vec;

const LANES: [u32; 8] = [0, 1, 2, 3, 4, 5, 6, 7];

/// A scene without anything: its centre is the origin.
fn nothing() -> Scene<'static> {
    Scene::new(SceneData::default()).unwrap()
}

/// Eight paths numbered from `first` on; every field is another function of the number, and the direction lies in
/// the octant that `octant` gives it.
fn paths(first: u32, octant: fn(u32) -> u32) -> Paths {
    let number = LANES.map(|lane| first + lane);
    let row = |offset: f32| f32x8::from(number.map(|n| n as f32 + offset));
    let integer = |factor: u32| u32x8::from(number.map(|n| n.wrapping_mul(factor) ^ 0x8000_0000));
    let vector = |offset: f32| Vec3x8::new(row(offset), row(offset + 0.125), row(offset + 0.25));
    let signed = |bit: u32| {
        let sign = |n: u32| if octant(n) >> bit & 1 == 1 { -1.0 } else { 1.0 };
        f32x8::from(number.map(|n| sign(n) * (n as f32 + 1.0 + bit as f32)))
    };
    Paths {
        origin: vector(1000.0),
        direction: Vec3x8::new(signed(0), signed(1), signed(2)),
        throughput: vector(2000.0),
        density: row(3000.0),
        compression: row(4000.0),
        normal: integer(3),
        index: integer(1),
        key: integer(5),
        slot: u32x8::from(number),
        lanes: 8,
    }
}

/// All that a lane holds, as bits.
fn lane(paths: &Paths, lane: usize) -> [u32; 15] {
    let (o, d, t) = (paths.origin, paths.direction, paths.throughput);
    let floats = [o.x, o.y, o.z, d.x, d.y, d.z, t.x, t.y, t.z, paths.density, paths.compression];
    let integers = [paths.normal, paths.index, paths.key, paths.slot];
    let mut all = [0; 15];
    let bits = floats.map(|row| row.to_array()[lane].to_bits());
    all[..11].copy_from_slice(&bits);
    all[11..].copy_from_slice(&integers.map(|row| row.to_array()[lane]));
    all
}

/// The numbers of the current bounce's paths, packet by packet; checks that each path is what was pushed.
fn numbers(queue: &Queue<'_>, octant: fn(u32) -> u32) -> Vec<Vec<u32>> {
    let packet = |i| {
        let found = queue.packet(i);
        let check = |at: usize| {
            let number = found.slot.to_array()[at];
            assert_eq!(lane(&found, at), lane(&paths(number, octant), 0), "path {number}");
            number
        };
        (0..found.lanes as usize).map(check).collect()
    };
    (0..queue.len()).map(packet).collect()
}

#[test]
fn packets_start_as_they_are() {
    let mut memory = [Packet::default(); Queue::required(8 * 3)];
    let mut queue = Queue::new(&mut memory, &nothing());
    assert_eq!((queue.capacity(), queue.len()), (3, 0));
    for first in [0, 8, 16] {
        queue.start(&Paths { lanes: 8 - first / 8, ..paths(first, |n| n) });
    }
    let expected: Vec<Vec<u32>> = [0..8, 8..15, 16..22].into_iter().map(Iterator::collect).collect();
    assert_eq!(numbers(&queue, |n| n), expected);
    queue.clear();
    assert_eq!(queue.len(), 0);
}

/// 8 · 40 paths of which two in three live: each comes back once, with every field; those of an octant side by side, and
/// among them those that start in an octant around the centre, in the order in which they were pushed.
#[test]
fn what_is_pushed_comes_back_once_in_the_order_of_its_octant() {
    let octant: fn(u32) -> u32 = |n| crate::maths::sobol::hash(n) & 7;
    let lives = |n: &u32| n % 3 != 1;
    let mut memory = [Packet::default(); Queue::required(8 * 40)];
    let mut queue = Queue::new(&mut memory, &nothing());
    for first in (0..320).step_by(8) {
        let alive = (0..8).filter(|bit| lives(&(first + bit))).fold(0, |bits, bit| bits | 1 << bit);
        queue.push(&paths(first, octant), alive);
    }
    assert_eq!(queue.len(), 0, "not before the bounce is closed");
    queue.turn();
    let packets = numbers(&queue, octant);
    let mut went: Vec<u32> = (0..320).filter(lives).collect();
    went.sort_by_key(|n| octant(*n));
    assert_eq!(packets.concat(), went);
    assert!(packets.split_last().unwrap().1.iter().all(|packet| packet.len() == 8), "full, but for the last");
    queue.turn();
    assert_eq!(queue.len(), 0, "nothing was pushed since");
}

/// As many paths as there is room for come back from every bounce.
#[test]
fn a_full_queue_is_read_and_written_at_once() {
    const PACKETS: usize = 12;
    let mut memory = [Packet::default(); Queue::required(8 * PACKETS)];
    let mut queue = Queue::new(&mut memory, &nothing());
    assert_eq!(queue.capacity(), PACKETS);
    for first in (0..8 * PACKETS as u32).step_by(8) {
        queue.start(&paths(first, |n| n / 3));
    }
    for bounce in 0..3 {
        for i in 0..queue.len() {
            let packet = queue.packet(i);
            queue.push(&packet, (1 << packet.lanes) - 1);
        }
        queue.turn();
        let mut came: Vec<u32> = numbers(&queue, |n| n / 3).concat();
        came.sort_unstable();
        assert_eq!(came, (0..8 * PACKETS as u32).collect::<Vec<_>>(), "bounce {bounce}");
        assert_eq!(queue.len(), PACKETS);
    }
}

#[test]
fn lanes_beyond_those_in_use_take_no_part() {
    for lanes in 1..=8 {
        let rays = Paths { lanes, ..paths(0, |n| n) }.rays(&nothing());
        assert_eq!(rays.active(), (1 << lanes) - 1, "{lanes} lanes");
        assert_eq!(rays.t_max.to_array()[0], f32::INFINITY);
    }
    assert_eq!(lane_mask(0b1010_0110).to_bitmask(), 0b1010_0110);
}

#[test]
fn without_memory_nothing_may_start() {
    let mut memory = [Packet::default(); 5];
    let mut capacity = |packets: usize| Queue::new(&mut memory[..packets], &nothing()).capacity();
    assert_eq!([0, 1, 2, 3, 5].map(&mut capacity), [0, 0, 1, 1, 2]);
}

#[test]
fn what_was_pushed_is_forgotten_with_the_rest() {
    let mut memory = [Packet::default(); Queue::required(8 * 4)];
    let mut queue = Queue::new(&mut memory, &nothing());
    queue.push(&paths(0, |_| 0), 0b0000_0111);
    queue.push(&paths(8, |_| 5), 0b1111_1111);
    queue.clear();
    queue.turn();
    assert_eq!(queue.len(), 0);
}
