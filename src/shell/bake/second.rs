//! Second texture coordinates as the places in a lightmap: glTF files have them for that.
//!
//! They are used if every surface that has an irradiance has some, all are in the square from 0 to 1, and no two places share
//! one. Islands are pieces that hang together along edges in space and in the square. What is black keeps nothing: it may
//! lack them.

use super::atlas::{Atlas, Fineness, LEAST_SIZE, MOST_CHARTS};
use super::charts::normal;
use super::raster::Flat;
use crate::scene::{LoadedScene, MAX_SIZE};
use glam::{Vec2, Vec3};
use std::collections::HashMap;

/// How far coordinates may leave the square by rounding.
const BESIDE: f32 = 1e-4;

/// One texel of so many may show two places.
const TOLERATED: usize = 1000;

/// Lays out a scene's surfaces by their second texture coordinates.
///
/// # Errors
/// Why they cannot be used: some surface has none, or they leave the square from 0 to 1, lie on one another, or are not as
/// fine as asked for.
pub fn atlas(scene: &LoadedScene, fineness: Fineness) -> Result<Atlas<'_>, String> {
    let islands = islands(scene)?;
    if islands.len() > MOST_CHARTS {
        return Err(format!("they fall into {} pieces, at most {MOST_CHARTS} can be baked", islands.len()));
    }
    let (size, density) = size(scene, &islands, fineness)?;
    let axes = islands.iter().map(|island| axis(scene, island)).collect();
    let mut atlas = Atlas::empty(scene, size, density, axes);
    let mut distances = vec![f32::INFINITY; atlas.labels.len()];
    let flat = |triangle: u32| flat(scene, triangle, size as f32);
    let islands = (1..).zip(&islands);
    let twice: usize = islands.map(|(label, island)| atlas.draw(label, island, flat, &mut distances)).sum();
    match twice * TOLERATED > atlas.used() {
        true => Err(format!("{twice} of {} texels show two places", atlas.used())),
        false => Ok(atlas),
    }
}

/// Pieces that hang together, as triangles by their index in the scene.
///
/// # Errors
/// If a surface that is not black has no coordinates or they leave the square, or there is nothing.
fn islands(scene: &LoadedScene) -> Result<Vec<Vec<u32>>, String> {
    if scene.second_uvs.is_empty() {
        return Err("there are none".into());
    }
    let mut laid = Vec::new();
    for (i, uv) in scene.second_uvs.iter().enumerate().filter(|(i, _)| normal(scene, *i).is_some()) {
        let numbers = uv.as_flattened();
        if numbers.iter().all(|v| (-BESIDE..=1.0 + BESIDE).contains(v)) {
            laid.push(i as u32);
        } else if numbers.iter().any(|v| !v.is_nan()) {
            return Err("they leave the square from 0 to 1".into());
        } else if scene.materials[scene.surfaces[i].material as usize].diffuse != [0.0; 3] {
            return Err("not all surfaces have them".into());
        }
    }
    if laid.iter().all(|i| area(scene, *i) == 0.0) {
        return Err("they have no area".into());
    }
    Ok(connected(scene, &laid))
}

/// A corner in space and in the square.
type Corner = [u32; 5];

/// An edge by its ends, in either direction.
type Side = [Corner; 2];

fn sides(scene: &LoadedScene, i: u32) -> [Side; 3] {
    let corner = |k: usize| -> Corner {
        let ([x, y, z], [u, v]) = (scene.triangles[i as usize].corners[k], scene.second_uvs[i as usize][k]);
        // A zero is a zero, whatever its sign.
        [x, y, z, u, v].map(|v| (v + 0.0).to_bits())
    };
    [(0, 1), (1, 2), (2, 0)].map(|(a, b)| {
        let mut side = [corner(a), corner(b)];
        side.sort_unstable();
        side
    })
}

fn connected(scene: &LoadedScene, laid: &[u32]) -> Vec<Vec<u32>> {
    let mut at: HashMap<Side, Vec<u32>> = HashMap::new();
    for &i in laid {
        sides(scene, i).into_iter().for_each(|side| at.entry(side).or_default().push(i));
    }
    let mut taken = vec![false; scene.triangles.len()];
    let mut islands = Vec::new();
    for &first in laid {
        if std::mem::replace(&mut taken[first as usize], true) {
            continue;
        }
        let (mut island, mut next) = (vec![first], 0);
        while let Some(&from) = island.get(next) {
            next += 1;
            for to in sides(scene, from).iter().filter_map(|side| at.get(side)).flatten() {
                if !std::mem::replace(&mut taken[*to as usize], true) {
                    island.push(*to);
                }
            }
        }
        islands.push(island);
    }
    islands
}

/// Where a triangle lies in a square of `size` texels, rows from the top.
fn flat(scene: &LoadedScene, i: u32, size: f32) -> Flat {
    scene.second_uvs[i as usize].map(|[u, v]| [u * size, (1.0 - v) * size])
}

/// Area of a triangle in the square.
fn area(scene: &LoadedScene, i: u32) -> f32 {
    let [a, b, c] = scene.second_uvs[i as usize].map(Vec2::from);
    0.5 * (b - a).perp_dot(c - a).abs()
}

fn area_vector(scene: &LoadedScene, i: u32) -> Vec3 {
    let [a, b, c] = scene.triangles[i as usize].corners.map(Vec3::from);
    0.5 * (b - a).cross(c - a)
}

/// The direction that an island faces on the whole.
fn axis(scene: &LoadedScene, island: &[u32]) -> Vec3 {
    island.iter().map(|i| area_vector(scene, *i)).sum::<Vec3>().normalize_or(Vec3::Z)
}

/// Texels a side, and per scene unit in the mean.
///
/// # Errors
/// If no size is as fine as asked for.
fn size(scene: &LoadedScene, islands: &[Vec<u32>], fineness: Fineness) -> Result<(u32, f32), String> {
    let sum = |of: fn(&LoadedScene, u32) -> f32| -> f64 {
        islands.iter().flatten().map(|i| f64::from(of(scene, *i))).sum()
    };
    let in_space = sum(|scene, i| area_vector(scene, i).length());
    let density = |size: u32| (f64::from(size) * (sum(area) / in_space).sqrt()) as f32;
    let sizes = std::iter::successors(Some(LEAST_SIZE), |size| Some(2 * size));
    let fine = |asked: f32| sizes.take_while(|size| *size <= MAX_SIZE).find(|size| density(*size) >= asked);
    match fineness {
        Fineness::Size(size) => Ok((size, density(size))),
        Fineness::Both(size, asked) if density(size) >= asked => Ok((size, density(size))),
        Fineness::Both(size, asked) => Err(format!("{size}×{size} texels are too few for {asked} per unit")),
        Fineness::Density(asked) => match fine(asked) {
            Some(size) => Ok((size, density(size))),
            None => Err(format!("{asked} texels per unit need more than {MAX_SIZE}×{MAX_SIZE} of them")),
        },
    }
}
