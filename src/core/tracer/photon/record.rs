//! Records on surfaces, and what a tree over them is made of.

use bytemuck::{Pod, Zeroable};

/// Light that arrived on a surface.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Photon {
    /// Where, in scene units.
    pub position: [f32; 3],
    /// Unit geometric normal there, on the side it arrived at.
    pub normal: [f32; 3],
    /// Its share of the lights' flux (radiance times area times solid angle), linear Rec. 709.
    pub power: [f32; 3],
    /// Unit direction it came from, away from the surface.
    pub from: [f32; 3],
}

/// A surface point whose irradiance is known.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Irradiance {
    /// Where, in scene units.
    pub position: [f32; 3],
    /// Unit geometric normal, on the lit side.
    pub normal: [f32; 3],
    /// Irradiance, linear Rec. 709.
    pub value: [f32; 3],
    /// Radius over which it was averaged, in scene units.
    pub radius: f32,
}

/// A record on a surface, as the tree sees it.
pub trait Site {
    /// Where it is, in scene units.
    fn position(&self) -> [f32; 3];
    /// Unit normal of the surface.
    fn normal(&self) -> [f32; 3];
}

impl Site for Photon {
    #[inline]
    fn position(&self) -> [f32; 3] {
        self.position
    }
    #[inline]
    fn normal(&self) -> [f32; 3] {
        self.normal
    }
}

impl Site for Irradiance {
    #[inline]
    fn position(&self) -> [f32; 3] {
        self.position
    }
    #[inline]
    fn normal(&self) -> [f32; 3] {
        self.normal
    }
}

/// An inner node: what lies below `at` on `axis` is in the left half.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Split {
    /// 0, 1 or 2.
    pub axis: u32,
    /// Coordinate of the plane.
    pub at: f32,
}

/// Up to eight records side by side.
#[repr(align(32))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf {
    pub(super) position: [[f32; 8]; 3],
    pub(super) normal: [[f32; 8]; 3],
    /// Index of the first record.
    pub(super) first: u32,
}

impl Default for Leaf {
    /// Without records: all infinitely far.
    fn default() -> Self {
        Leaf { position: [[f32::INFINITY; 8]; 3], normal: [[0.0; 8]; 3], first: 0 }
    }
}

/// Why memory is too short or lent slices are not a tree.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// There must be [`leaves`] leaves for the records, and one split less.
    Length,
    /// More than 2³² − 8 records.
    TooMany,
    /// The split of this index has no such axis.
    Split(usize),
    /// The leaf of this index reaches beyond the records.
    Leaf(usize),
}

impl core::fmt::Display for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Error::Length => f.write_str("the numbers of leaves and splits do not fit the records"),
            Error::TooMany => f.write_str("there are too many records for one tree"),
            Error::Split(i) => write!(f, "split {i} has no such axis"),
            Error::Leaf(i) => write!(f, "leaf {i} reaches beyond the records"),
        }
    }
}

impl core::error::Error for Error {}

/// Leaves that a tree over `records` records has: a power of two. It has one split less.
pub const fn leaves(records: usize) -> usize {
    records.div_ceil(8).next_power_of_two()
}
