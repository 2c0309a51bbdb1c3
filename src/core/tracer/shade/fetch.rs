//! Records of eight lanes, fetched as rows and transposed: one load a row instead of one a number.

use crate::maths::vec3::Vec3x8;
use crate::tracer::scene::{Lamp, Material, Motion, SceneData, Triangle, between};
use wide::{f32x8, u32x8};

/// The corners of eight triangles, each at its time.
#[inline(always)]
pub(super) fn corners(data: &SceneData<'_>, triangle: [u32; 8], time: f32x8) -> [Vec3x8; 3] {
    match &data.motion {
        None => standing(data.triangles, triangle),
        Some(motion) => moving_corners(data, motion, triangle, time),
    }
}

/// Kept out of the loops that call it, and fetching all itself: scenes that stand still pay no copy for it.
#[inline(never)]
fn moving_corners(data: &SceneData<'_>, motion: &Motion<'_>, triangle: [u32; 8], time: f32x8) -> [Vec3x8; 3] {
    let (open, closing) = (standing(data.triangles, triangle), standing(motion.triangles, triangle));
    [0, 1, 2].map(|corner| between(open[corner], closing[corner], time))
}

/// The shading normals at the corners of eight triangles as the shutter closes.
pub(super) fn closing_normals(motion: &Motion<'_>, triangle: [u32; 8]) -> [Vec3x8; 3] {
    columns(motion.normals, triangle)
}

#[inline(always)]
fn standing(triangles: &[Triangle], triangle: [u32; 8]) -> [Vec3x8; 3] {
    let row = |i: u32| bytemuck::cast_ref::<_, [f32; 9]>(&triangles[i as usize]);
    let [ax, ay, az, bx, by, bz, cx, cy] = first(triangle.map(row));
    let cz = f32x8::from(triangle.map(|i| row(i)[8]));
    [Vec3x8::new(ax, ay, az), Vec3x8::new(bx, by, bz), Vec3x8::new(cx, cy, cz)]
}

/// The colours at the corners of eight triangles. There must be colours.
pub(super) fn colours(data: &SceneData<'_>, triangle: [u32; 8]) -> [Vec3x8; 3] {
    columns(data.colours, triangle)
}

/// Three vectors of eight records.
fn columns(records: &[[[f32; 3]; 3]], record: [u32; 8]) -> [Vec3x8; 3] {
    let column = |i: usize| f32x8::from(record.map(|t| records[t as usize].as_flattened()[i]));
    [0, 3, 6].map(|corner| Vec3x8::new(column(corner), column(corner + 1), column(corner + 2)))
}

/// The surfaces of eight triangles.
pub(super) struct Surfaces {
    /// Shading normals at the corners.
    pub normals: [Vec3x8; 3],
    /// Texture coordinates at the corners.
    pub uv: [(f32x8, f32x8); 3],
    /// Index of the material.
    pub material: [u32; 8],
}

impl Surfaces {
    /// Texture coordinates at barycentric weights.
    #[inline(always)]
    pub fn coordinates(&self, weights: [f32x8; 3]) -> (f32x8, f32x8) {
        let mix = |[a, b, c]: [f32x8; 3]| a * weights[0] + b * weights[1] + c * weights[2];
        (mix(self.uv.map(|t| t.0)), mix(self.uv.map(|t| t.1)))
    }
}

/// Fetches surfaces.
#[inline(always)]
pub(super) fn surfaces(data: &SceneData<'_>, triangle: [u32; 8]) -> Surfaces {
    let row = |i: u32| bytemuck::cast_ref::<_, [f32; 16]>(&data.surfaces[i as usize]);
    let [ax, ay, az, bx, by, bz, cx, cy] = first(triangle.map(row));
    let [cz, au, av, bu, bv, cu, cv, material] = last(triangle.map(row));
    Surfaces {
        normals: [Vec3x8::new(ax, ay, az), Vec3x8::new(bx, by, bz), Vec3x8::new(cx, cy, cz)],
        uv: [(au, av), (bu, bv), (cu, cv)],
        material: bytemuck::cast::<_, u32x8>(material).to_array(),
    }
}

/// Eight materials.
pub(super) struct Materials {
    pub diffuse: Vec3x8,
    pub scattering: u32x8,
    pub texture: u32x8,
    pub specular: Vec3x8,
    pub roughness: f32x8,
    pub ior: f32x8,
    pub emission: Vec3x8,
    pub opacity: f32x8,
    pub opacity_texture: u32x8,
    pub emission_texture: u32x8,
}

/// Fetches materials.
#[inline(always)]
pub(super) fn materials(data: &SceneData<'_>, material: [u32; 8]) -> Materials {
    let row = |i: u32| bytemuck::cast_ref::<Material, [f32; 16]>(&data.materials[i as usize]);
    let [dr, dg, db, scattering, texture, sr, sg, sb] = first(material.map(row));
    let [roughness, ior, er, eg, eb, opacity, mask, glow] = last(material.map(row));
    Materials {
        diffuse: Vec3x8::new(dr, dg, db),
        scattering: bytemuck::cast(scattering),
        texture: bytemuck::cast(texture),
        specular: Vec3x8::new(sr, sg, sb),
        roughness,
        ior,
        emission: Vec3x8::new(er, eg, eb),
        opacity,
        opacity_texture: bytemuck::cast(mask),
        emission_texture: bytemuck::cast(glow),
    }
}

/// Eight lamps.
pub(super) struct Lamps {
    pub corner: Vec3x8,
    pub edges: [Vec3x8; 2],
    pub normal: Vec3x8,
    pub emission: Vec3x8,
    pub inverse_area: f32x8,
}

impl Lamps {
    /// The corners of the triangles.
    #[inline(always)]
    pub fn corners(&self) -> [Vec3x8; 3] {
        [self.corner, self.corner + self.edges[0], self.corner + self.edges[1]]
    }
}

/// Fetches lamps by the numbers of their lights, each as it is at its time.
#[inline(always)]
pub(super) fn lamps(data: &SceneData<'_>, light: [u32; 8], time: f32x8) -> Lamps {
    let row = |i: u32| bytemuck::cast_ref::<Lamp, [f32; 16]>(&data.lights[i as usize].lamp);
    let [ax, ay, az, ux, uy, uz, vx, vy] = first(light.map(row));
    let [vz, nx, ny, nz, er, eg, eb, inverse_area] = last(light.map(row));
    let lamps = Lamps {
        corner: Vec3x8::new(ax, ay, az),
        edges: [Vec3x8::new(ux, uy, uz), Vec3x8::new(vx, vy, vz)],
        normal: Vec3x8::new(nx, ny, nz),
        emission: Vec3x8::new(er, eg, eb),
        inverse_area,
    };
    match &data.motion {
        None => lamps,
        Some(motion) => moving_lamps(data, motion, light, time),
    }
}

/// Kept out of the loops that call it, as [`moving_corners`].
#[inline(never)]
fn moving_lamps(data: &SceneData<'_>, motion: &Motion<'_>, light: [u32; 8], time: f32x8) -> Lamps {
    let light = light.map(|i| &data.lights[i as usize]);
    let [a, b, c] = moving_corners(data, motion, light.map(|light| light.triangle), time);
    let edges = [b - a, c - a];
    let across = edges[0].cross(edges[1]);
    let inverse = f32x8::ONE / across.length();
    let emission = [0, 1, 2].map(|i| f32x8::from(light.map(|light| light.lamp.emission[i])));
    Lamps {
        corner: a,
        edges,
        normal: across * inverse,
        emission: Vec3x8::new(emission[0], emission[1], emission[2]),
        inverse_area: f32x8::splat(2.0) * inverse,
    }
}

/// The columns of the rows' first eight numbers.
#[inline(always)]
fn first<const N: usize>(rows: [&[f32; N]; 8]) -> [f32x8; 8] {
    f32x8::transpose(rows.map(|row| f32x8::from(&row[..8])))
}

/// The columns of the rows' last eight numbers.
#[inline(always)]
fn last<const N: usize>(rows: [&[f32; N]; 8]) -> [f32x8; 8] {
    f32x8::transpose(rows.map(|row| f32x8::from(&row[N - 8..])))
}
