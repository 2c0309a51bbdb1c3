//! Light from outside: a picture of the sky from a file, one colour, sun and sky by direction, or a photographer's light.

mod daylight;
mod file;
mod map;
mod order;
mod soft;

pub(super) use daylight::Daylight;
pub use map::SkyMap;
pub(super) use order::{Kind, Order};
