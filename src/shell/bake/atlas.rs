//! All charts in one square of texels, and what each texel shows.
//!
//! Every texel that a triangle touches belongs to its chart, so that no filter finds a black one at a border; around charts
//! there is [`GUTTER`], so that none finds another chart's.

use super::charts::{Chart, charts};
use super::raster::{Flat, nearest, touched};
use crate::error::Error;
use crate::scene::{LoadedScene, MAX_SIZE};
use glam::Vec3;
use guillotiere::{AtlasAllocator, size2};
use pmcip_core::maths::vec3::Vec3x8;
use pmcip_core::sampler::guide::Feature;
use pmcip_core::tracer::shade::irradiance::{Sites, Unwrapped};
use wide::f32x8;

/// Texels beside a chart that are of no other.
pub const GUTTER: u32 = 2;
/// Most charts, that labels can tell apart.
pub(super) const MOST_CHARTS: usize = u16::MAX as usize;
/// Smallest side of an atlas that is as large as it has to be.
pub(super) const LEAST_SIZE: u32 = 64;
/// Distance of points from the sides of their triangle, relative to its largest coordinate: 128 units in the last place. What
/// rises from a side is not met from behind by rounding, which leaves dark texels at the foot of walls.
const INSET: f32 = 1.0 / (1 << 16) as f32;
/// Halvings of the interval in which the finest texels that fit are looked for.
const HALVINGS: usize = 12;
/// How often charts that lie on themselves are divided.
const DIVISIONS: usize = 16;

/// How fine a lightmap is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fineness {
    /// As fine as a square of this many texels a side admits.
    Size(u32),
    /// This many texels per scene unit, in a square that is a power of two.
    Density(f32),
    /// Both.
    Both(u32, f32),
}

/// Where every triangle lies in the lightmap.
#[derive(Clone, Debug)]
pub struct Atlas<'a> {
    scene: &'a LoadedScene,
    /// Texels a side.
    pub size: u32,
    /// Texels per scene unit.
    pub density: f32,
    /// Number of a texel's chart from 1 on, 0 if nothing touches it; rows from the top.
    pub labels: Vec<u16>,
    /// Corners of the scene's triangles, in texels from the top left; none for a triangle without irradiance.
    pub corners: Vec<Option<Flat>>,
    /// The triangle that is nearest to each labelled texel's centre.
    shown: Vec<u32>,
    /// The direction along which each chart is projected.
    axes: Vec<Vec3>,
    /// Least barycentric weights of each triangle's points.
    insets: Vec<[f32; 3]>,
}

impl<'a> Atlas<'a> {
    /// Lays out a scene's surfaces.
    ///
    /// # Errors
    /// [`Error::Setting`] if there are none, too many pieces of them, or they do not fit.
    pub fn new(scene: &'a LoadedScene, fineness: Fineness) -> Result<Atlas<'a>, Error> {
        let mut charts = charts(scene);
        for _ in 0..DIVISIONS {
            let (atlas, folded) = Atlas::of(scene, &charts, fineness)?;
            if folded.is_empty() {
                return Ok(atlas);
            }
            let divided = |(i, chart): (usize, &Chart)| match folded.contains(&i) {
                true => chart.halves(scene).to_vec(),
                false => vec![chart.clone()],
            };
            charts = charts.iter().enumerate().flat_map(divided).collect();
        }
        Err(Error::Setting("surfaces cannot be laid flat: they wind on themselves too often".into()))
    }

    /// The atlas of `charts`, and those which lie on themselves.
    fn of(scene: &'a LoadedScene, charts: &[Chart], fineness: Fineness) -> Result<(Self, Vec<usize>), Error> {
        if charts.is_empty() {
            return Err(Error::Setting("there is nothing to bake: no surface is diffuse".into()));
        }
        if charts.len() > MOST_CHARTS {
            let reason =
                format!("surfaces fall into {} pieces, at most {MOST_CHARTS} can be baked", charts.len());
            return Err(Error::Setting(reason));
        }
        let (size, density, corners) = lay_out(charts, fineness)?;
        let axes = charts.iter().map(|chart| chart.axes[0].cross(chart.axes[1])).collect();
        let mut atlas = Atlas::empty(scene, size, density, axes);
        let mut distances = vec![f32::INFINITY; atlas.labels.len()];
        let charts = charts.iter().zip(corners).enumerate();
        let folded = charts.filter_map(|(i, (chart, corner))| {
            let flat = |triangle: u32| {
                scene.triangles[triangle as usize].corners.map(|point| {
                    let at = chart.flat(point);
                    [0, 1].map(|k| corner[k] + at[k] * density)
                })
            };
            (atlas.draw((i + 1) as u16, &chart.triangles, flat, &mut distances) > 0).then_some(i)
        });
        let folded = folded.collect();
        Ok((atlas, folded))
    }

    /// An atlas of nothing, for pieces that are seen along `axes`.
    pub(super) fn empty(scene: &'a LoadedScene, size: u32, density: f32, axes: Vec<Vec3>) -> Self {
        let texels = size as usize * size as usize;
        let (labels, shown) = (vec![0; texels], vec![0; texels]);
        let corners = vec![None; scene.triangles.len()];
        let insets = scene.triangles.iter().map(|triangle| inset(&triangle.corners)).collect();
        Atlas { scene, size, density, labels, corners, shown, axes, insets }
    }

    /// Draws triangles that lie where `flat` says; returns how many texels show two places.
    pub(super) fn draw(
        &mut self,
        label: u16,
        triangles: &[u32],
        flat: impl Fn(u32) -> Flat,
        distances: &mut [f32],
    ) -> usize {
        let mut folded = 0;
        for &i in triangles {
            let flat = flat(i);
            self.corners[i as usize] = Some(flat);
            touched(&flat, self.size, |x, y| {
                let texel = y as usize * self.size as usize + x as usize;
                let centre = [x as f32 + 0.5, y as f32 + 0.5];
                let (_, distance) = nearest(&flat, centre);
                if distance == 0.0 && distances[texel] == 0.0 {
                    // Both hold the centre: neighbours that share the edge there, or two layers.
                    let apart = self.point(i, centre).0.distance(self.point(self.shown[texel], centre).0);
                    folded += usize::from(apart * self.density > 1.0);
                }
                if distance < distances[texel] {
                    (distances[texel], self.shown[texel], self.labels[texel]) = (distance, i, label);
                }
            });
        }
        folded
    }

    /// The point of triangle `i` that is nearest to a place, a hair off its sides, and the unit shading normal there.
    fn point(&self, i: u32, place: [f32; 2]) -> (Vec3, Vec3) {
        let (triangle, surface) = (&self.scene.triangles[i as usize], &self.scene.surfaces[i as usize]);
        let weights = self.corners[i as usize].map_or([1.0, 0.0, 0.0], |flat| nearest(&flat, place).0);
        let least = self.insets[i as usize];
        let rest = 1.0 - least.iter().sum::<f32>();
        let weights = [0, 1, 2].map(|k| least[k] + rest * weights[k]);
        let mix = |of: &[[f32; 3]; 3]| (0..3).map(|k| weights[k] * Vec3::from(of[k])).sum::<Vec3>();
        let smooth = mix(&surface.normals).try_normalize();
        (mix(&triangle.corners), smooth.unwrap_or_else(|| self.front(i)))
    }

    /// The unit geometric normal of a triangle.
    fn front(&self, i: u32) -> Vec3 {
        let [a, b, c] = self.scene.triangles[i as usize].corners.map(Vec3::from);
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// What a filter knows of the texels: albedo 1, as irradiance has none, the normal, and for depth the height over the plane
    /// that the chart was projected on, as from a point beyond the scene: where rows and columns are known, the position.
    pub fn features(&self) -> Vec<Feature> {
        let coordinates = self.scene.triangles.iter().flat_map(|t| t.corners.as_flattened());
        let beyond = 2.0 * coordinates.fold(0.0f32, |most, x| most.max(x.abs()));
        let texels = self.labels.iter().zip(&self.shown).enumerate();
        let feature = |(i, (&label, &shown)): (usize, (&u16, &u32))| {
            if label == 0 {
                return Feature::default();
            }
            let (x, y) = (i % self.size as usize, i / self.size as usize);
            let (point, normal) = self.point(shown, [x as f32 + 0.5, y as f32 + 0.5]);
            Feature {
                albedo: [1.0; 3],
                normal: normal.into(),
                depth: beyond + self.axes[usize::from(label) - 1].dot(point),
            }
        };
        texels.map(feature).collect()
    }

    /// Texels that something touches.
    pub fn used(&self) -> usize {
        self.labels.iter().filter(|label| **label != 0).count()
    }

    /// Number of charts.
    pub fn charts(&self) -> usize {
        usize::from(self.labels.iter().copied().max().unwrap_or(0))
    }
}

impl Unwrapped for Atlas<'_> {
    fn sites(&self, x: f32x8, y: f32x8) -> Sites {
        let (x, y) = (x.to_array(), y.to_array());
        let mut rows = [[0.0; 8]; 10];
        for lane in 0..8 {
            let (column, row) = ((x[lane] as u32).min(self.size - 1), (y[lane] as u32).min(self.size - 1));
            let shown = self.shown[row as usize * self.size as usize + column as usize];
            let (point, normal) = self.point(shown, [x[lane], y[lane]]);
            let corners = self.scene.triangles[shown as usize].corners;
            let reach = corners.as_flattened().iter().fold(0.0f32, |most, x| most.max(x.abs()));
            let values = [point.to_array(), normal.to_array(), self.front(shown).to_array()];
            let values = values.as_flattened().iter().chain([&reach]);
            rows.iter_mut().zip(values).for_each(|(row, value)| row[lane] = *value);
        }
        let vector = |i: usize| Vec3x8::new(rows[i].into(), rows[i + 1].into(), rows[i + 2].into());
        Sites { position: vector(0), normal: vector(3), facing: vector(6), reach: rows[9].into() }
    }
}

/// Weights that points of a triangle have at least, so that they are [`INSET`] off its sides.
fn inset(corners: &[[f32; 3]; 3]) -> [f32; 3] {
    let distance = INSET * corners.as_flattened().iter().fold(0.0f32, |most, x| most.max(x.abs()));
    let [a, b, c] = corners.map(Vec3::from);
    let area = (b - a).cross(c - a).length();
    [b - c, c - a, a - b].map(|side| (distance * side.length() / area).min(0.25))
}

/// Size, density and the corners of all charts.
fn lay_out(charts: &[Chart], fineness: Fineness) -> Result<(u32, f32, Vec<[f32; 2]>), Error> {
    match fineness {
        Fineness::Both(size, density) => match pack(charts, size, density) {
            Some(corners) => Ok((size, density, corners)),
            None => Err(Error::Setting(format!(
                "{size}×{size} texels are too few for {density} per unit: leave one of them out"
            ))),
        },
        Fineness::Density(density) => {
            let sizes = std::iter::successors(Some(LEAST_SIZE), |size| Some(2 * size));
            let mut found = sizes
                .take_while(|size| *size <= MAX_SIZE)
                .filter_map(|size| Some((size, density, pack(charts, size, density)?)));
            found.next().ok_or_else(|| {
                Error::Setting(format!(
                    "{density} texels per unit need more than {MAX_SIZE}×{MAX_SIZE} of them"
                ))
            })
        }
        Fineness::Size(size) => {
            finest(charts, size).map(|(density, corners)| (size, density, corners)).ok_or_else(|| {
                Error::Setting(format!("{size}×{size} texels are too few for {} pieces", charts.len()))
            })
        }
    }
}

/// The largest density, up to a few thousandths, at which all charts fit.
fn finest(charts: &[Chart], size: u32) -> Option<(f32, Vec<[f32; 2]>)> {
    let area: f32 = charts.iter().map(|chart| chart.extent[0] * chart.extent[1]).sum();
    // The charts' own boxes cannot cover more than everything.
    let (mut least, mut most) = (0.0, size as f32 / area.sqrt().max(f32::MIN_POSITIVE));
    let mut best = None;
    for _ in 0..HALVINGS {
        let density = 0.5 * (least + most);
        match pack(charts, size, density) {
            Some(corners) => (least, best) = (density, Some((density, corners))),
            None => most = density,
        }
    }
    best
}

/// Corners of the charts in a square of `size` texels, in texels, if there is room for all.
fn pack(charts: &[Chart], size: u32, density: f32) -> Option<Vec<[f32; 2]>> {
    let side = |extent: f32| (extent * density).ceil() as i64 + 1 + 2 * i64::from(GUTTER);
    let sides: Vec<[i64; 2]> = charts.iter().map(|chart| chart.extent.map(side)).collect();
    if sides.as_flattened().iter().any(|side| *side > i64::from(size)) {
        return None;
    }
    let mut order: Vec<usize> = (0..charts.len()).collect();
    order.sort_by_key(|i| (std::cmp::Reverse(sides[*i].into_iter().max()), *i));
    let mut room = AtlasAllocator::new(size2(size as i32, size as i32));
    let mut corners = vec![[0.0; 2]; charts.len()];
    for i in order {
        let place = room.allocate(size2(sides[i][0] as i32, sides[i][1] as i32))?.rectangle.min;
        corners[i] = [place.x, place.y].map(|at| at as f32 + GUTTER as f32 + 0.5);
    }
    Some(corners)
}
