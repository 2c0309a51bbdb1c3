//! Irradiance from photons.

use super::neighbours::Neighbours;
use super::record::{Irradiance, Photon};
use super::tree::{Query, Tree};
use crate::maths::vec3;

/// Photons an estimate of irradiance averages over.
const NEIGHBOURS: usize = 64;

/// Estimates reach no farther than this many times the radius of [`NEIGHBOURS`] evenly spread photons: where there
/// are fewer photons, fewer are averaged over.
const REACH: f32 = 4.0;

/// Every how many photons one is made a point of known irradiance (Christensen 1999, section 4).
pub const STRIDE: usize = 4;

/// Radius within which the irradiance from `photons` is estimated, in scene units.
fn reach(photons: &Tree<'_, Photon>) -> f32 {
    REACH * photons.spacing() * libm::sqrtf(NEIGHBOURS as f32)
}

/// Computes value and radius of each of `points`, whose positions and normals are given, from `photons`.
///
/// That a point coincides with a photon makes up for the photons that are missing around a place whose nearest
/// point it is: looked up from anywhere, the estimate is right on average.
pub fn estimate(photons: &Tree<'_, Photon>, points: &mut [Irradiance]) {
    let mut found = Neighbours::<NEIGHBOURS>::default();
    let radius = reach(photons);
    for point in points {
        photons.k_nearest(&Query { position: point.position, normal: point.normal, radius }, &mut found);
        point.value = [0.0; 3];
        for (distance2, index) in found.entries() {
            let power = vec3::scale(photons.sites()[*index as usize].power, found.kernel(*distance2));
            point.value = [0, 1, 2].map(|c| point.value[c] + power[c]);
        }
        point.radius = libm::sqrtf(found.radius2());
    }
}
