//! What changes from frame to frame: camera, objects, emissions.

use super::model::{Frames, View};
use super::place::Placement;
use super::rig::Rig;
use super::track::{Track, Turn};
use glam::DVec3;
use std::sync::Arc;

/// What a scene does over time.
#[derive(Clone, Debug, Default)]
pub(super) struct Script {
    pub frames: Option<Frames>,
    pub camera: Option<CameraPath>,
    /// One for each object.
    pub paths: Vec<ObjectTrack>,
    /// One for each material that can change.
    pub glows: Vec<GlowTrack>,
    /// Part of a frame's time in which the shutter is open, from the frame on.
    pub shutter: f32,
    /// Whether a path has keys.
    pub moving: bool,
}

impl Script {
    /// Nothing moves: so many objects where they are.
    pub fn still(objects: usize) -> Script {
        Script { paths: vec![ObjectTrack::Still; objects], ..Script::default() }
    }

    pub fn first_frame(&self) -> u32 {
        self.frames.map_or(0, |frames| frames.first)
    }

    pub fn moves(&self) -> bool {
        self.moving
    }

    /// Where all objects stand in a frame, or at a time between frames, in the scene file's coordinates.
    pub fn placements(&self, frame: impl Into<f64>) -> Result<Vec<Placement>, &'static str> {
        let frame = frame.into();
        self.paths.iter().map(|path| path.at(frame)).collect()
    }

    /// When the shutter of a frame closes, in frames.
    pub fn closes(&self, frame: u32) -> f64 {
        f64::from(frame) + f64::from(self.shutter)
    }
}

/// A camera over time.
#[derive(Clone, Debug)]
pub(super) enum CameraPath {
    /// By keys of its own.
    Keys(CameraTrack),
    /// Along −z of a node, its vertical field of view in degrees, and how far it looks.
    Node { rig: Arc<Rig>, node: usize, fov: f32, distance: f64 },
}

impl CameraPath {
    /// The camera at a time, in frames, in a scene whose coordinates begin at `origin`.
    ///
    /// # Errors
    /// If it looks nowhere.
    pub fn at(&self, frame: f64, origin: DVec3) -> Result<View, &'static str> {
        match self {
            CameraPath::Keys(track) => track.at(frame, origin),
            CameraPath::Node { rig, node, fov, distance } => {
                let map = rig.at(*node, frame);
                let axis = |axis: DVec3| axis.try_normalize().ok_or("camera: its node is flat");
                let (back, up) = (axis(map.matrix3.z_axis)?, axis(map.matrix3.y_axis)?);
                if back.cross(up).length() < 1e-5 {
                    return Err("camera: its node is flat");
                }
                let from = map.translation - origin;
                let [from, at, up] = [from, from - *distance * back, up].map(|v| v.as_vec3().to_array());
                Ok(View { from, at, up, fov: *fov, aperture: 0.0, focus: None })
            }
        }
    }
}

/// A camera that follows keys.
#[derive(Clone, Debug)]
pub(super) struct CameraTrack {
    pub from: Track<3>,
    pub at: Track<3>,
    pub up: Track<3>,
    pub fov: Track<1>,
    pub aperture: Track<1>,
    /// None: the distance of `at`.
    pub focus: Option<Track<1>>,
}

impl CameraTrack {
    /// The camera at a time, in frames, in a scene whose coordinates begin at `origin`.
    ///
    /// # Errors
    /// If it looks nowhere.
    pub fn at(&self, frame: f64, origin: DVec3) -> Result<View, &'static str> {
        let [from, at, up] = [&self.from, &self.at, &self.up].map(|track| DVec3::from_array(track.at(frame)));
        let [from, at, up] = [from - origin, at - origin, up].map(|v| v.as_vec3());
        let forward = (at - from).try_normalize().ok_or("camera: from and at are the same point")?;
        let upward = up.try_normalize().ok_or("camera: up has no direction")?;
        if forward.cross(upward).length() < 1e-5 {
            return Err("camera: up is parallel to the view");
        }
        let one = |track: &Track<1>| track.at(frame)[0] as f32;
        let focus = self.focus.as_ref().map(one);
        let (fov, aperture) = (one(&self.fov), one(&self.aperture));
        Ok(View { from: from.to_array(), at: at.to_array(), up: up.to_array(), fov, aperture, focus })
    }
}

/// An object's place over time.
#[derive(Clone, Debug)]
pub(super) enum ObjectTrack {
    Still,
    Mesh {
        scale: Track<3>,
        rotate: Turn,
        translate: Track<3>,
    },
    Sphere {
        center: Track<3>,
        radius: Track<1>,
    },
    Light {
        center: Track<3>,
        edge_u: Track<3>,
        edge_v: Track<3>,
    },
    Node {
        rig: Arc<Rig>,
        node: usize,
    },
    /// At a node and turned as it is, of its own size.
    Rigid {
        rig: Arc<Rig>,
        node: usize,
    },
}

impl ObjectTrack {
    /// The place in a frame, or at a time between frames.
    ///
    /// # Errors
    /// If a light has no area.
    pub fn at(&self, frame: f64) -> Result<Placement, &'static str> {
        let point = |track: &Track<3>| DVec3::from_array(track.at(frame));
        let vector = |track: &Track<3>| point(track).as_vec3();
        Ok(match self {
            ObjectTrack::Still => Placement::IDENTITY,
            ObjectTrack::Mesh { scale, rotate, translate } => {
                Placement::new(vector(scale), rotate.at(frame), point(translate))
            }
            ObjectTrack::Sphere { center, radius } => {
                Placement::sphere(point(center), radius.at(frame)[0] as f32)
            }
            ObjectTrack::Light { center, edge_u, edge_v } => {
                let (u, v) = (vector(edge_u), vector(edge_v));
                if u.cross(v).length_squared() <= 1e-12 * u.length_squared() * v.length_squared() {
                    return Err("lights: edge_u and edge_v span no area");
                }
                Placement::rectangle(point(center), u, v)
            }
            ObjectTrack::Node { rig, node } => Placement::affine(rig.at(*node, frame)),
            ObjectTrack::Rigid { rig, node } => Placement::affine(rig.rigid(*node, frame)),
        })
    }
}

/// The emission of a material over time.
#[derive(Clone, Debug)]
pub(super) struct GlowTrack {
    pub material: u32,
    pub emission: Track<3>,
    /// A factor.
    pub power: Track<1>,
}
