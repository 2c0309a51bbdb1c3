//! Scenes on disk, and what they become.

pub mod bvh;
