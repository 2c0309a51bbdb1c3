//! Queries against a plain search.

extern crate std;

use super::tree::{COMPATIBLE, FLATTENED};
use super::*;
use crate::maths::vec3;
use proptest::prelude::*;
use std::vec;
use std::vec::Vec;

/// A photon of power 1 in a small grid, so that positions coincide often; one of the six axes is its normal.
fn photon() -> impl Strategy<Value = Photon> {
    let position = prop::array::uniform3((0i32..20, any::<bool>()));
    (position, 0usize..6, 0.0f32..1.0).prop_map(|(position, face, jitter)| {
        let mut normal = [0.0; 3];
        normal[face / 2] = if face % 2 == 0 { 1.0 } else { -1.0 };
        let position = position.map(|(cell, off)| cell as f32 * 0.1 + if off { jitter * 0.1 } else { 0.0 });
        Photon { position, normal, power: [1.0; 3], from: normal }
    })
}

fn tree_memory(sites: &mut [Photon]) -> (Vec<Split>, Vec<Leaf>) {
    let n = leaves(sites.len());
    let (mut splits, mut packets) = (vec![Split::default(); n - 1], vec![Leaf::default(); n]);
    build(sites, &mut splits, &mut packets).unwrap();
    (splits, packets)
}

/// Squared flattened distances of all that go with the query, nearest first.
fn plain(sites: &[Photon], query: &Query) -> Vec<(f32, usize)> {
    let distance = |site: &Photon| {
        let d = vec3::sub(site.position, query.position);
        let along = vec3::dot(d, query.normal);
        vec3::dot(d, d) + FLATTENED * along * along
    };
    let goes = |site: &Photon| vec3::dot(site.normal, query.normal) > COMPATIBLE;
    let mut all: Vec<_> =
        sites.iter().enumerate().filter(|s| goes(s.1)).map(|(i, s)| (distance(s), i)).collect();
    all.retain(|(distance, _)| *distance < query.radius * query.radius);
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all
}

/// Equal but for the order of operations.
fn near(a: f32, b: f32) -> bool {
    (a - b).abs() <= 1e-5 * (1.0 + a.abs())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn queries_find_what_a_plain_search_finds(
        mut sites in prop::collection::vec(photon(), 0..400),
        queries in prop::collection::vec((photon(), 0.01f32..3.0), 20),
    ) {
        let before = sites.len();
        let (splits, packets) = tree_memory(&mut sites);
        let tree = Tree::new(&sites, &splits, &packets).unwrap();
        prop_assert_eq!(tree.sites().len(), before);
        let mut found = Neighbours::<16>::default();
        for (at, radius) in queries {
            // Off the grid, so that no record lies on the radius up to rounding.
            let position = at.position.map(|x| x + 0.0123);
            let query = Query { position, normal: at.normal, radius };
            let expected = plain(&sites, &query);

            let nearest = tree.nearest(&query);
            prop_assert_eq!(nearest.is_some(), !expected.is_empty());
            if let Some((index, distance)) = nearest {
                prop_assert!(near(distance, expected[0].0));
                prop_assert!(expected.iter().any(|e| e.1 == index && near(e.0, distance)));
            }

            tree.k_nearest(&query, &mut found);
            prop_assert_eq!(found.entries().len(), expected.len().min(16));
            let mut distances: Vec<f32> = found.entries().iter().map(|e| e.0).collect();
            distances.sort_by(f32::total_cmp);
            prop_assert!(distances.iter().zip(&expected).all(|(d, e)| near(*d, e.0)));
            let mut indices: Vec<u32> = found.entries().iter().map(|e| e.1).collect();
            indices.sort_unstable();
            indices.dedup();
            prop_assert_eq!(indices.len(), distances.len(), "a record was found twice");
            let radius2 = if expected.len() < 16 { radius * radius } else { distances[15] };
            prop_assert!(near(found.radius2(), radius2));
        }
    }
}

#[test]
fn records_stay_the_same_and_order_is_reproducible() {
    let photon =
        |i: u32| Photon { position: [(i * 7 % 100) as f32, (i % 13) as f32, 0.0], ..Photon::default() };
    let mut a: Vec<Photon> = (0..1000).map(photon).collect();
    let mut b = a.clone();
    assert_eq!(tree_memory(&mut a), tree_memory(&mut b));
    assert_eq!(a, b);
    let key = |p: &Photon| p.position.map(f32::to_bits);
    let mut before: Vec<_> = (0..1000).map(|i| key(&photon(i))).collect();
    let mut after: Vec<_> = a.iter().map(key).collect();
    before.sort_unstable();
    after.sort_unstable();
    assert_eq!(before, after);
}

#[test]
fn what_is_no_tree_is_refused() {
    let mut sites = [Photon::default(); 20];
    let (mut splits, mut packets) = tree_memory(&mut sites);
    assert_eq!((splits.len(), packets.len()), (3, 4));
    assert_eq!(build(&mut sites, &mut splits[..2], &mut packets), Err(Error::Length));
    assert_eq!(Tree::new(&sites, &splits, &packets[..2]).err(), Some(Error::Length));
    assert_eq!(Tree::new(&sites[..17], &splits, &packets).err(), Some(Error::Leaf(3)));
    splits[1].axis = 3;
    assert_eq!(Tree::new(&sites, &splits, &packets).err(), Some(Error::Split(1)));
}

/// 40,000 photons of a wall surround a few of the floor: the search ends early, and what it says is still true.
#[test]
fn patience_ends_without_a_wrong_answer() {
    let coordinate = |i: u32| (crate::maths::sobol::hash(i) >> 8) as f32 / (1 << 24) as f32;
    let photon = |i: u32| Photon {
        position: [0, 1, 2].map(|axis| coordinate(3 * i + axis)),
        normal: if i.is_multiple_of(100) { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] },
        ..Photon::default()
    };
    let mut sites: Vec<Photon> = (0..40_000).map(photon).collect();
    let (splits, packets) = tree_memory(&mut sites);
    let tree = Tree::new(&sites, &splits, &packets).unwrap();
    let mut found = Neighbours::<64>::default();
    let query = Query { position: [0.4, 0.5, 0.6], normal: [0.0, 0.0, 1.0], radius: 0.9 };
    tree.k_nearest(&query, &mut found);
    assert!(found.radius2() < 0.2, "more was searched than 256 leaves");
    let expected = plain(&sites, &Query { radius: found.radius2().sqrt(), ..query });
    assert_eq!(found.entries().len(), expected.len());
}

#[test]
fn an_empty_tree_answers() {
    let (splits, packets) = tree_memory(&mut []);
    let tree = Tree::<Photon>::new(&[], &splits, &packets).unwrap();
    let query = Query { position: [0.0; 3], normal: [0.0, 0.0, 1.0], radius: 1e9 };
    assert_eq!(tree.nearest(&query), None);
    let mut points = [Irradiance { normal: query.normal, ..Irradiance::default() }];
    estimate(&tree, &mut points);
    assert_eq!(points[0].value, [0.0; 3]);
}

/// Photons of power 1/n spread at random over a unit square: the irradiance is 1 everywhere. An estimate from k
/// photons deviates by √(4/3k), so the mean of 100 far apart by 1.4 %; allowed are 4 such deviations.
#[test]
fn even_light_is_estimated_evenly() {
    let n = 40_000u32;
    let coordinate = |i: u32| (crate::maths::sobol::hash(i) >> 8) as f32 / (1 << 24) as f32;
    let normal = [0.0, 0.0, 1.0];
    let photon = |i: u32| Photon {
        position: [coordinate(2 * i), coordinate(2 * i + 1), 0.0],
        normal,
        power: [1.0 / n as f32; 3],
        from: normal,
    };
    let mut sites: Vec<Photon> = (0..n).map(photon).collect();
    let (splits, packets) = tree_memory(&mut sites);
    let tree = Tree::new(&sites, &splits, &packets).unwrap();
    let at = |i: usize| [0.1 + 0.08 * (i % 10) as f32, 0.1 + 0.08 * (i / 10) as f32, 0.0];
    let mut points: Vec<Irradiance> =
        (0..100).map(|i| Irradiance { position: at(i), normal, ..Irradiance::default() }).collect();
    estimate(&tree, &mut points);
    let mean = points.iter().map(|p| f64::from(p.value[0])).sum::<f64>() / 100.0;
    assert!((mean - 1.0).abs() < 4.0 * 0.0144, "{mean}");
    assert!(points.iter().all(|p| (p.radius / 0.0226 - 1.0).abs() < 0.3), "radius √(64/πn) = 0.0226");
}
