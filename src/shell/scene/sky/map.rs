//! A sky in memory.

use glam::{Mat3, Vec3};
use pmcip_core::tracer::scene::sky::{build, required};
use pmcip_core::tracer::scene::{Sky, Sun};

/// A sky in memory, ready to be lent to the core: 16 bytes a texel.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyMap {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear radiance, rows from the top; laid out as [`sky`](pmcip_core::tracer::scene::sky) says.
    pub texels: Vec<[f32; 3]>,
    /// The sun, in the scene's axes.
    pub sun: Option<Sun>,
    /// The picture's axes in the scene's.
    pub axes: [[f32; 3]; 3],
    /// Whether the eye sees it directly.
    pub visible: bool,
    /// Where it came from, for reports.
    pub source: String,
    rows: Vec<u32>,
    cells: Vec<u32>,
    power: f32,
}

impl SkyMap {
    /// A sky of a picture of so many texels and rows, linear radiance row by row from the top, and a sun; `source` is for
    /// reports. It is of no use unless there are as many texels.
    pub fn new(
        (width, height): (u32, u32),
        texels: Vec<[f32; 3]>,
        sun: Option<Sun>,
        source: String,
    ) -> SkyMap {
        let (rows, cells) = required(width, height);
        let (mut rows, mut cells) = (vec![0; rows], vec![0; cells]);
        let power = build((width, height), &texels, sun.as_ref(), &mut rows, &mut cells);
        let axes = Mat3::IDENTITY.to_cols_array_2d();
        SkyMap { width, height, texels, sun, axes, visible: true, source, rows, cells, power }
    }

    /// A sky of one colour all around.
    pub fn even(radiance: [f32; 3]) -> SkyMap {
        SkyMap::new((1, 1), vec![radiance], None, "one colour".into())
    }

    /// The sky turned by a rotation from its own axes to the scene's, its sun as well.
    pub(super) fn turned(mut self, rotation: Mat3) -> SkyMap {
        let axes = Mat3::from_cols_array_2d(&self.axes);
        self.axes = (rotation * axes).to_cols_array_2d();
        if let Some(sun) = &mut self.sun {
            sun.direction = (rotation * Vec3::from(sun.direction)).normalize().to_array();
        }
        self
    }

    /// The sky as the core sees it.
    pub fn lent(&self) -> Sky<'_> {
        Sky {
            width: self.width,
            height: self.height,
            texels: &self.texels,
            rows: &self.rows,
            cells: &self.cells,
            axes: self.axes,
            sun: self.sun,
            power: self.power,
            visible: self.visible,
        }
    }
}
