extern crate std;

use super::tracks::{NO_REGION, Tracks, regions};
use super::*;
use crate::predict::homography::{self, Block, Pair};
use std::vec;
use std::vec::Vec;

fn belief(variance: f32, freedom: f32) -> Belief {
    Belief { variance, light: 1.0, freedom }
}

#[test]
fn wild_positions_carry_nothing() {
    let before = [1, 2, 3, 4, 5, 6];
    let wild =
        [[f32::NAN, 0.5], [0.5, f32::INFINITY], [-0.1, 0.5], [3.0, 0.5], [2.9999998, 1.9999999], [0.0, 0.0]];
    let mut out = [0; 6];
    carry(&before, 3, 2, &wild, -1, &mut out).unwrap();
    assert_eq!(out, [-1, -1, -1, -1, 6, 1]);
    assert_eq!(carry(&before, 3, 3, &wild, -1, &mut out), Err(Error::Size));
}

#[test]
fn knowledge_adds_up_and_saturates() {
    let filter = Filter::new(100.0);
    let mut beliefs = [belief(1.0, 20.0); 64];
    let mut last = 20.0;
    for _ in 0..50 {
        filter.update(8, &mut beliefs, &[belief(1.0, 20.0); 64]).unwrap();
        assert!(beliefs[0].freedom >= last);
        last = beliefs[0].freedom;
    }
    // In equilibrium f = 1/(1/f + drift/spread) + 20.
    assert!(last > 40.0 && last < filter.spread / filter.drift + 20.0, "{last}");
    assert!((beliefs[5].variance - 1.0).abs() < 1e-5);
}

#[test]
fn a_change_of_everything_is_followed() {
    let filter = Filter::new(100.0);
    let mut beliefs = [belief(1.0, 1000.0); 64];
    let outlook = filter.update(8, &mut beliefs, &[belief(100.0, 100.0); 64]).unwrap();
    assert!(beliefs.iter().all(|b| b.variance > 85.0), "{:?}", beliefs[0]);
    assert!(outlook.miss > 0.9 && outlook.known == 1.0);
}

#[test]
fn a_single_bright_sample_is_not() {
    let filter = Filter::new(100.0);
    let mut beliefs = [belief(1.0, 400.0); 256];
    let mut seen = [belief(1.0, 20.0); 256];
    seen[77].variance = 1000.0;
    filter.update(16, &mut beliefs, &seen).unwrap();
    assert!(beliefs[77].variance < 150.0, "{:?}", beliefs[77]);
}

#[test]
fn what_is_not_a_number_is_forgotten() {
    let filter = Filter::new(100.0);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0] {
        let spoilt = Belief { variance: bad, light: 1.0, freedom: 5.0 };
        let mut beliefs = [spoilt; 8];
        filter.update(8, &mut beliefs, &[belief(2.0, 3.0); 8]).unwrap();
        assert_eq!(beliefs, [belief(2.0, 3.0); 8]);
        let outlook = filter.update(8, &mut beliefs, &[spoilt; 8]).unwrap();
        assert!(beliefs.iter().all(|b| b.variance == 2.0) && outlook.miss == 0.0);
    }
    assert_eq!(filter.update(3, &mut [Belief::NONE; 8], &[Belief::NONE; 8]), Err(Error::Size));
}

/// A plane with a large and a small dense patch.
fn patches() -> Vec<f32> {
    let dense = |x: usize, y: usize| (10..22).contains(&x) && (5..15).contains(&y) || x < 3 && y > 26;
    (0..40 * 30).map(|i| if dense(i % 40, i / 40) { 1e-2 } else { 1e-5 }).collect()
}

#[test]
fn dense_regions_are_found() {
    let (mut labels, mut scratch) = ([0; 1200], [0; 1200]);
    let density = patches();
    assert_eq!(regions(&density, 40, 0.8, 5, &mut labels, &mut scratch), Ok(2));
    assert_eq!(labels.iter().filter(|l| **l == 0).count(), 120);
    assert_eq!(labels.iter().filter(|l| **l == 1).count(), 9);
    assert_eq!(labels[5 * 40 + 10], 0);
    assert_eq!(regions(&density, 40, 0.8, 20, &mut labels, &mut scratch), Ok(1));
    for flat in [0.0, 1.0, f32::NAN, f32::INFINITY, -1.0] {
        assert_eq!(regions(&[flat; 1200], 40, 0.8, 1, &mut labels, &mut scratch), Ok(0), "{flat}");
        assert!(labels.iter().all(|l| *l == NO_REGION));
    }
    assert_eq!(regions(&density, 40, 0.8, 5, &mut labels, &mut [0; 100]), Err(Error::Scratch));
    assert_eq!(regions(&density, 41, 0.8, 5, &mut labels, &mut scratch), Err(Error::Size));
}

#[test]
fn a_region_goes_its_own_way() {
    let (mut labels, mut scratch) = ([0; 1200], [0; 1200]);
    regions(&patches(), 40, 0.8, 20, &mut labels, &mut scratch).unwrap();
    // The patch has moved 4 to the right since, all else 1 up.
    let grid =
        |i: usize, x0: f64, y0: f64, step: f64| [x0 + step * (i % 5) as f64, y0 + step * (i / 5) as f64];
    let own = (0..25).map(|i| grid(i, 11.0, 6.0, 2.0)).map(|to| Pair { from: [to[0] + 4.0, to[1]], to });
    let apart = |p: &[f64; 2]| !((3.0..30.0).contains(&p[0]) && p[1] < 22.0);
    let others = (0..130).map(|i| [3.0 * (i % 13) as f64 + 1.0, 3.0 * (i / 13) as f64 + 1.0]).filter(apart);
    let others = others.map(|to| Pair { from: [to[0], to[1] - 1.0], to });
    let pairs: Vec<Pair> = own.chain(others).collect();
    let mut picked = vec![Pair::default(); pairs.len()];
    let mut blocks = vec![Block::default(); homography::required(pairs.len())];
    let settings = homography::Settings::default();
    let settings = homography::Settings { threshold: 1.0, ..settings };
    let tracks = Tracks::find(&pairs, &labels, 40, &settings, &mut picked, &mut blocks).unwrap();
    let mut positions = [[0.0; 2]; 1200];
    tracks.positions(&labels, 40, 30, &mut positions).unwrap();
    for (pixel, wanted) in [(8 * 40 + 20, [16.5, 8.5]), (20 * 40 + 35, [35.5, 21.5])] {
        let [x, y]: [f32; 2] = positions[pixel];
        assert!((x - wanted[0]).abs() < 0.01 && (y - wanted[1]).abs() < 0.01, "{x} {y}");
    }
    let short = Tracks::find(&pairs, &labels, 40, &settings, &mut picked[1..], &mut blocks);
    assert_eq!(short, Err(Error::Scratch));
}

#[test]
fn without_pairs_nothing_is_carried() {
    let settings = homography::Settings::default();
    let tracks = Tracks::find(&[], &[NO_REGION; 4], 2, &settings, &mut [], &mut []).unwrap();
    assert_eq!(tracks, Tracks::default());
    let mut positions = [[0.0; 2]; 4];
    tracks.positions(&[NO_REGION; 4], 2, 2, &mut positions).unwrap();
    assert!(positions.as_flattened().iter().all(|x| x.is_nan()));
}
