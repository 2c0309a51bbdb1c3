//! Where what a pixel shows was a frame ago: first hits, and motion vectors from the scene itself.
//!
//! One ray through each pixel's centre. The point it hits is moved back as its object has moved, and projected by the
//! camera of then. A ray that leaves the scene shows something infinitely far away, which only turns.
//!
//! A lens and an open shutter are left out: the pinhole in its middle, as the shutter opens, says where things are.
//!
//! Limits: what is seen in a mirror or through glass is not followed, only the mirror or the glass; an edge inside a
//! pixel belongs to what its centre shows.

use crate::error::Error;
use crate::frame::memory::zeros;
use crate::frame::settings::{Layer, Settings};
use crate::frame::threads::{each, start_threads};
use crate::scene::{LoadedScene, Pose, Shift, View};
use glam::Vec3;
use pmcip_core::maths::vec3::Vec3x8;
use pmcip_core::tracer::camera::Camera;
use pmcip_core::tracer::scene::Scene;
use pmcip_core::tracer::shade::cutout;
use pmcip_core::tracer::trace::{MISS, Rays8, Tracer};
use rayon::ThreadPool;
use std::collections::BTreeMap;
use wide::f32x8;

/// The object of a pixel that shows none.
pub const NO_OBJECT: u32 = u32::MAX;

/// Rows that a thread looks at.
const ROWS: usize = 8;

/// How far two depths of the same point may differ, as a part of the depth.
const SAME_DEPTH: f32 = 0.02;

/// What one pixel shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sight {
    /// The object, an index into [`LoadedScene::placements`], or [`NO_OBJECT`].
    pub object: u32,
    /// Distance from the eye in scene units, infinite without an object.
    pub depth: f32,
    /// Where it was on the film a frame ago, in pixels from the upper left corner; perhaps outside. None if it was
    /// beside or behind the camera.
    pub before: Option<[f32; 2]>,
    /// Its distance from the eye a frame ago.
    pub depth_before: f32,
}

/// What all pixels show, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// One a pixel.
    pub sights: Vec<Sight>,
}

/// The planes of [`Layer::Motion`] by channel: pixels, to the right and downwards, by which what a pixel shows has moved
/// since everything stood `before`; 0 without that, and where it was beside or behind the camera. On `threads` threads, on all
/// there are if that is `None`.
///
/// # Errors
/// As [`Motion::new`], and [`Error::Work`] if threads or memory are lacking.
pub fn layer(
    scene: &LoadedScene,
    settings: &Settings,
    before: Option<&Pose>,
    threads: Option<usize>,
) -> Result<BTreeMap<String, Vec<f32>>, Error> {
    let (width, height) = (settings.sampler.width, settings.sampler.height);
    let pixels = width as usize * height as usize;
    let mut planes: [Vec<f32>; 2] = [zeros(pixels)?, zeros(pixels)?];
    if let Some(before) = before {
        let pool = start_threads(threads)?;
        let motion = Motion::new(scene, &settings.view, before, (width, height), pool.as_ref())?;
        for (i, shift) in motion.shifts().enumerate() {
            (planes[0][i], planes[1][i]) = (shift[0], shift[1]);
        }
    }
    let channels = Layer::Motion.channels().iter().map(|name| (*name).to_owned());
    Ok(channels.zip(planes).collect())
}

/// What looks at a scene now and a frame ago.
struct Eyes<'a> {
    scene: &'a LoadedScene,
    view: Scene<'a>,
    now: Camera,
    then: Camera,
    /// How each object comes from where it is to where it was.
    shifts: Vec<Shift>,
}

impl Eyes<'_> {
    /// Looks at a row of pixels, eight at a time.
    fn row(&self, tracer: &mut Tracer<'_>, y: u32, row: &mut [Sight]) {
        for (x, sights) in (0..).step_by(8).zip(row.chunks_mut(8)) {
            let columns = f32x8::new(std::array::from_fn(|lane| (x + lane as u32) as f32 + 0.5));
            let direction = self.now.directions(columns, f32x8::splat(y as f32 + 0.5));
            let origin = Vec3x8::splat(self.now.origin());
            let rays = Rays8 { origin, direction, t_max: f32x8::splat(f32::INFINITY), ..Rays8::default() };
            let hits = cutout::seen(tracer, &rays);
            let [dx, dy, dz] = [direction.x, direction.y, direction.z].map(f32x8::to_array);
            let (t, triangle) = (hits.t.to_array(), hits.triangle.to_array());
            for (lane, sight) in sights.iter_mut().enumerate() {
                *sight = self.sight(Vec3::new(dx[lane], dy[lane], dz[lane]), t[lane], triangle[lane]);
            }
        }
    }

    /// What is seen in a direction, where a ray hits a triangle at `t`, if any.
    fn sight(&self, direction: Vec3, t: f32, triangle: u32) -> Sight {
        let object = if triangle == MISS { NO_OBJECT } else { self.scene.objects[triangle as usize] };
        let eye = Vec3::from_array(self.now.origin());
        let offset = match self.shifts.get(object as usize) {
            Some(shift) => shift.position(eye + t * direction) - Vec3::from_array(self.then.origin()),
            None => direction,
        };
        Sight {
            object,
            depth: t,
            before: self.then.project(offset.to_array()),
            depth_before: if object == NO_OBJECT { f32::INFINITY } else { offset.length() },
        }
    }
}

impl Motion {
    /// Looks at `scene` by `view`, and back to where everything stood `before`: on all threads of `pool`, on the caller's if
    /// there is none.
    ///
    /// # Errors
    /// [`Error::Setting`] if a camera or the scene is refused, or `before` is of a scene with other objects, [`Error::Work`] if
    /// memory is lacking.
    pub fn new(
        scene: &LoadedScene,
        view: &View,
        before: &Pose,
        (width, height): (u32, u32),
        pool: Option<&ThreadPool>,
    ) -> Result<Motion, Error> {
        if before.placements.len() != scene.placements.len() {
            return Err(Error::Setting("the scene of the frame before had other objects".into()));
        }
        let camera = |view: &View| view.camera(width, height);
        let (now, then) =
            (camera(view).map_err(Error::setting)?, camera(&before.view).map_err(Error::setting)?);
        let shifts = scene.placements.iter().zip(&before.placements);
        let shifts = shifts.map(|(now, then)| now.towards(then)).collect();
        let eyes = Eyes { scene, view: Scene::new(scene.data()).map_err(Error::setting)?, now, then, shifts };
        let mut sights: Vec<Sight> = zeros(width as usize * height as usize)?;
        let parts = sights.chunks_mut(ROWS * width as usize).enumerate().collect();
        each(pool, parts, |(part, sights)| {
            let mut tracer = Tracer::new(eyes.view);
            for (dy, row) in sights.chunks_mut(width as usize).enumerate() {
                eyes.row(&mut tracer, (part * ROWS + dy) as u32, row);
            }
        });
        Ok(Motion { width, height, sights })
    }

    /// By how many pixels, to the right and downwards, what each pixel shows has moved; 0 if nobody knows.
    fn shifts(&self) -> impl Iterator<Item = [f32; 2]> {
        let centre = |i: usize| [i % self.width as usize, i / self.width as usize].map(|at| at as f32 + 0.5);
        let shift = move |(i, sight): (usize, &Sight)| {
            let ([x, y], [x_before, y_before]) = (centre(i), sight.before.unwrap_or(centre(i)));
            [x - x_before, y - y_before]
        };
        self.sights.iter().enumerate().map(shift)
    }

    /// The pixel of the frame before that shows what pixel `i` shows now, with what was seen in that frame.
    ///
    /// None where it was outside of the film or hidden: where that pixel showed another object, or another depth.
    pub fn source(&self, i: usize, before: &Motion) -> Option<usize> {
        let sight = self.sights.get(i)?;
        let [x, y] = sight.before?.map(f32::floor);
        let inside = x >= 0.0 && y >= 0.0 && x < before.width as f32 && y < before.height as f32;
        let source = inside.then(|| y as usize * before.width as usize + x as usize)?;
        let seen = before.sights.get(source)?;
        let near = (seen.depth - sight.depth_before).abs() <= SAME_DEPTH * sight.depth_before;
        let both_far = seen.object == NO_OBJECT;
        (seen.object == sight.object && (near || both_far)).then_some(source)
    }
}
