//! A scene that changes from frame to frame.

use super::place::Placement;
use super::pose::{self, Object};
use super::track::{Track, Turn};
use super::{Error, LoadedScene, View, file, is_obj, obj};
use glam::Vec3;
use pmcip_core::tracer::scene::LightNode8;
use pmcip_core::tracer::scene::{light, light_tree};
use std::path::Path;
use std::time::Instant;

/// The frames of an animation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frames {
    /// Number of the first frame.
    pub first: u32,
    /// Number of the last frame.
    pub last: u32,
    /// Frames a second.
    pub fps: f32,
}

/// What a change of the frame has changed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// Seconds that placing the triangles and building the hierarchy took; none if no object moves.
    pub geometry: Option<f64>,
    /// Whether an emission has changed.
    pub light: bool,
    /// Whether the camera has moved.
    pub view: bool,
}

/// A scene and what its keys make of it: a [`LoadedScene`] that can be brought to any frame.
///
/// The hierarchy is built anew where an object moves, and stays where only the camera or the lamps' power change.
///
/// ```no_run
/// use pmcip::scene::Animation;
///
/// let mut animation = Animation::load("scenes/cornell-anim.toml".as_ref())?;
/// for frame in 1..=100 {
///     animation.seek(frame)?;
///     println!("frame {frame}: the eye is at {:?}", animation.scene().view.from);
/// }
/// # Ok::<(), pmcip::scene::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Animation {
    scene: LoadedScene,
    frame: u32,
    script: Script,
    /// Kept only if one of them moves.
    objects: Vec<Object>,
}

impl Animation {
    /// Loads a scene file, or an OBJ as a scene that never changes, and brings it to its first frame.
    ///
    /// # Errors
    /// If a file cannot be read or understood, or holds no triangle.
    pub fn load(path: &Path) -> Result<Animation, Error> {
        if is_obj(path) { obj::load_scene(path, false) } else { file::load_scene(path) }
    }

    /// Loads a scene to be rendered: as [`load`](Self::load), but something shines in it. An OBJ without light gets a
    /// lamp behind the camera, and a warning that says so.
    ///
    /// # Errors
    /// As [`load`](Self::load), and if a scene file has no light.
    pub fn load_lit(path: &Path) -> Result<Animation, Error> {
        if is_obj(path) {
            return obj::load_scene(path, true);
        }
        let animation = file::load_scene(path)?;
        animation.scene.require_light().map(|()| animation)
    }

    /// Takes a scene whose objects stand where `script` wants them in `frame`.
    pub(super) fn new(
        scene: LoadedScene,
        objects: Vec<Object>,
        script: Script,
        frame: u32,
    ) -> Result<Animation, Error> {
        let mut animation = Animation { scene, frame, script, objects };
        if !animation.script.moves() {
            animation.objects = Vec::new();
        }
        animation.look(frame)?;
        animation.shine(frame);
        animation.list_lights();
        Ok(animation)
    }

    /// The scene as it is in the current frame.
    pub fn scene(&self) -> &LoadedScene {
        &self.scene
    }

    /// The scene for good.
    pub fn into_scene(self) -> LoadedScene {
        self.scene
    }

    /// The current frame.
    pub fn frame(&self) -> u32 {
        self.frame
    }

    /// The frames that the scene file names.
    pub fn frames(&self) -> Option<Frames> {
        self.script.frames
    }

    /// Brings the scene to a frame, which may be any, and says what that has changed.
    ///
    /// # Errors
    /// If in this frame a light has no area, the camera looks nowhere, or an object is at infinity. The scene is
    /// then of no use.
    pub fn seek(&mut self, frame: u32) -> Result<Change, Error> {
        let mut change = Change { view: self.look(frame)?, light: self.shine(frame), geometry: None };
        if self.script.moves() {
            let start = Instant::now();
            let placements = self.script.placements(frame).map_err(|m| self.blame(frame, m))?;
            if placements != self.scene.placements {
                self.place(placements).map_err(|m| self.blame(frame, m))?;
                change.geometry = Some(start.elapsed().as_secs_f64());
            }
        }
        if change.light || change.geometry.is_some() {
            self.list_lights();
        }
        self.frame = frame;
        Ok(change)
    }

    fn blame(&self, frame: u32, message: &str) -> Error {
        Error::in_file(&self.scene.path, format!("frame {frame}: {message}"))
    }

    /// Turns the camera; whether it has moved.
    fn look(&mut self, frame: u32) -> Result<bool, Error> {
        let Some(camera) = &self.script.camera else { return Ok(false) };
        let view = camera.at(frame).map_err(|m| self.blame(frame, m))?;
        Ok(std::mem::replace(&mut self.scene.view, view) != view)
    }

    /// Sets emissions; whether one has changed.
    fn shine(&mut self, frame: u32) -> bool {
        let mut changed = false;
        for glow in &self.script.glows {
            let emission = &mut self.scene.materials[glow.material as usize].emission;
            let [power] = glow.power.at(frame);
            let new = glow.emission.at(frame).map(|v| v * power);
            changed |= std::mem::replace(emission, new) != new;
        }
        changed
    }

    /// Moves the objects.
    fn place(&mut self, placements: Vec<Placement>) -> Result<(), &'static str> {
        let geometry = pose::pose(&self.objects, &placements)?;
        let scene = &mut self.scene;
        (scene.nodes, scene.leaves, scene.triangles) = (geometry.nodes, geometry.leaves, geometry.triangles);
        (scene.surfaces, scene.objects) = (geometry.surfaces, geometry.objects);
        scene.placements = placements;
        geometry.warnings.into_iter().for_each(|warning| scene.warn(warning));
        Ok(())
    }

    /// Lists the triangles that shine.
    fn list_lights(&mut self) {
        let scene = &mut self.scene;
        scene.lights.clear();
        scene.lights.resize(light::count(&scene.surfaces, &scene.materials), Default::default());
        let used = light::build(&scene.triangles, &scene.surfaces, &scene.materials, &mut scene.lights);
        scene.lights.truncate(used);
        scene.light_nodes.clear();
        scene.light_nodes.resize(light_tree::required(used), LightNode8::default());
        let mut order = vec![0; used];
        let used = light_tree::build(
            &scene.triangles,
            &scene.surfaces,
            &scene.materials,
            &mut scene.lights,
            &mut order,
            &mut scene.light_nodes,
        );
        scene.light_nodes.truncate(used);
    }
}

/// What a scene does over time.
#[derive(Clone, Debug, Default)]
pub(super) struct Script {
    pub frames: Option<Frames>,
    pub camera: Option<CameraTrack>,
    /// One for each object.
    pub paths: Vec<ObjectTrack>,
    /// One for each material that can change.
    pub glows: Vec<GlowTrack>,
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

    fn moves(&self) -> bool {
        self.moving
    }

    /// Where all objects stand in a frame.
    pub fn placements(&self, frame: u32) -> Result<Vec<Placement>, &'static str> {
        self.paths.iter().map(|path| path.at(frame)).collect()
    }
}

/// A camera over time.
#[derive(Clone, Debug)]
pub(super) struct CameraTrack {
    pub from: Track<3>,
    pub at: Track<3>,
    pub up: Track<3>,
    pub fov: Track<1>,
}

impl CameraTrack {
    /// The camera of a frame.
    ///
    /// # Errors
    /// If it looks nowhere.
    pub fn at(&self, frame: u32) -> Result<View, &'static str> {
        let [from, at, up] = [&self.from, &self.at, &self.up].map(|track| Vec3::from_array(track.at(frame)));
        let forward = (at - from).try_normalize().ok_or("camera: from and at are the same point")?;
        let upward = up.try_normalize().ok_or("camera: up has no direction")?;
        if forward.cross(upward).length() < 1e-5 {
            return Err("camera: up is parallel to the view");
        }
        let [fov] = self.fov.at(frame);
        Ok(View { from: from.to_array(), at: at.to_array(), up: up.to_array(), fov })
    }
}

/// An object's place over time.
#[derive(Clone, Debug)]
pub(super) enum ObjectTrack {
    Still,
    Mesh { scale: Track<3>, rotate: Turn, translate: Track<3> },
    Sphere { center: Track<3>, radius: Track<1> },
    Light { center: Track<3>, edge_u: Track<3>, edge_v: Track<3> },
}

impl ObjectTrack {
    /// The place in a frame.
    ///
    /// # Errors
    /// If a light has no area.
    pub fn at(&self, frame: u32) -> Result<Placement, &'static str> {
        let vector = |track: &Track<3>| Vec3::from_array(track.at(frame));
        Ok(match self {
            ObjectTrack::Still => Placement::IDENTITY,
            ObjectTrack::Mesh { scale, rotate, translate } => {
                Placement::new(vector(scale), rotate.at(frame), vector(translate))
            }
            ObjectTrack::Sphere { center, radius } => Placement::sphere(vector(center), radius.at(frame)[0]),
            ObjectTrack::Light { center, edge_u, edge_v } => {
                let (u, v) = (vector(edge_u), vector(edge_v));
                if u.cross(v).length_squared() <= 1e-12 * u.length_squared() * v.length_squared() {
                    return Err("lights: edge_u and edge_v span no area");
                }
                Placement::rectangle(vector(center), u, v)
            }
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
