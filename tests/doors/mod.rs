//! The doors through which input comes: of each what must hold for any bytes, and inputs to begin with. Shared with the fuzz
//! targets of the same names, which call `check` for long.

pub mod allocate;
pub mod bytes;
pub mod capi;
pub mod estimate;
pub mod features;
pub mod film;
pub mod guide;
pub mod hierarchy;
pub mod homography;
pub mod merge;
pub mod picture;
pub mod predict;
pub mod scene;
pub mod weights;

#[path = "../films/mod.rs"]
pub mod films;
#[path = "../view/mod.rs"]
mod view;

/// What can come through.
pub struct Door {
    /// Of the fuzz target.
    pub name: &'static str,
    /// Panics if something does not hold of an input.
    pub check: fn(&[u8]),
    /// Inputs that get far.
    pub seeds: fn() -> Vec<Vec<u8>>,
}

macro_rules! doors {
    ($($name:ident),*) => { [$(Door { name: stringify!($name), check: $name::check, seeds: $name::seeds }),*] };
}

/// All of them.
pub const ALL: [Door; 13] = doors![
    allocate, weights, merge, estimate, guide, homography, features, predict, hierarchy, scene, film, capi,
    picture
];

/// Inputs that came through once, by door.
pub const FOUND: [(&str, &[u8]); 6] = [
    ("estimate", include_bytes!("found/estimate-negative")),
    ("hierarchy", include_bytes!("found/hierarchy-wild")),
    ("predict", include_bytes!("found/predict-overflow")),
    ("picture", include_bytes!("found/picture-claim")),
    ("picture", include_bytes!("found/picture-b44")),
    ("picture", include_bytes!("found/picture-tile")),
];
