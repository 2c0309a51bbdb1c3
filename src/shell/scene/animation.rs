//! A scene that changes from frame to frame.

use super::error::Error;
use super::model::{Frames, LoadedScene, Pose};
use super::object::Object;
use super::place::Placement;
use super::pose;
use super::script::Script;
use super::sky::SkyMap;
use glam::DVec3;
use pmcip_core::tracer::scene::LightNode8;
use pmcip_core::tracer::scene::{light, light_tree};
use std::time::Instant;

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
    /// Where the coordinates of each object begin.
    homes: Vec<DVec3>,
    /// Where each object stands as the shutter closes.
    closing: Vec<Placement>,
}

impl Animation {
    /// Takes a scene whose objects stand where `script` wants them in `frame`, and where they stand as its shutter closes.
    pub(super) fn new(
        scene: LoadedScene,
        objects: Vec<Object>,
        script: Script,
        frame: u32,
        closing: Vec<Placement>,
    ) -> Result<Animation, Error> {
        let homes = objects.iter().map(|object| object.home).collect();
        let mut animation = Animation { scene, frame, script, objects, homes, closing };
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

    /// The scene under another sky, or under one at all.
    pub fn under(mut self, sky: SkyMap) -> Animation {
        self.scene.sky = Some(sky);
        self
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
            let placements = self.placements(f64::from(frame))?;
            let closing = self.placements(self.script.closes(frame))?;
            if placements != self.scene.placements || closing != self.closing {
                self.place(placements, closing).map_err(|m| self.blame(frame, m))?;
                change.geometry = Some(start.elapsed().as_secs_f64());
            }
        }
        if change.light || change.geometry.is_some() {
            self.list_lights();
        }
        self.frame = frame;
        Ok(change)
    }

    /// Where everything stood in the frame before; none before the first frame.
    ///
    /// # Errors
    /// As [`seek`](Self::seek).
    pub fn before(&self) -> Result<Option<Pose>, Error> {
        if self.frame <= self.script.first_frame() {
            return Ok(None);
        }
        let frame = self.frame - 1;
        let time = f64::from(frame);
        let camera = self.script.camera.as_ref().map(|camera| camera.at(time, self.origin())).transpose();
        let view = camera.map_err(|m| self.blame(frame, m))?.unwrap_or(self.scene.view);
        let placements = self.placements(time)?;
        Ok(Some(Pose { view, placements }))
    }

    fn origin(&self) -> DVec3 {
        DVec3::from_array(self.scene.origin)
    }

    /// Where all objects stand at a time in frames, in the scene's own coordinates.
    fn placements(&self, time: f64) -> Result<Vec<Placement>, Error> {
        let placements = self.script.placements(time).map_err(|m| self.blame(time as u32, m))?;
        let seated = placements.iter().zip(&self.homes);
        Ok(seated.map(|(placement, home)| placement.seated(*home, self.origin())).collect())
    }

    fn blame(&self, frame: u32, message: &str) -> Error {
        Error::in_file(&self.scene.path, format!("frame {frame}: {message}"))
    }

    /// Turns the camera; whether it has moved.
    fn look(&mut self, frame: u32) -> Result<bool, Error> {
        let Some(camera) = &self.script.camera else { return Ok(false) };
        let at = |time: f64| camera.at(time, self.origin()).map_err(|m| self.blame(frame, m));
        let (view, closing) = (at(f64::from(frame))?, at(self.script.closes(frame))?);
        self.scene.closing_view = (closing != view).then_some(closing);
        Ok(std::mem::replace(&mut self.scene.view, view) != view)
    }

    /// Sets emissions; whether one has changed.
    fn shine(&mut self, frame: u32) -> bool {
        let mut changed = false;
        for glow in &self.script.glows {
            let emission = &mut self.scene.materials[glow.material as usize].emission;
            let [power] = glow.power.at(frame);
            let new = glow.emission.at(frame).map(|v| v as f32 * power as f32);
            changed |= std::mem::replace(emission, new) != new;
        }
        changed
    }

    /// Moves the objects.
    fn place(&mut self, placements: Vec<Placement>, closing: Vec<Placement>) -> Result<(), &'static str> {
        let geometry = pose::pose(&self.objects, &placements, &closing)?;
        let scene = &mut self.scene;
        (scene.nodes, scene.leaves, scene.triangles) = (geometry.nodes, geometry.leaves, geometry.triangles);
        (scene.surfaces, scene.objects) = (geometry.surfaces, geometry.objects);
        (scene.colours, scene.second_uvs) = (geometry.colours, geometry.second);
        (scene.placements, scene.moved, self.closing) = (placements, geometry.moved, closing);
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
            &scene.moved.triangles,
            &scene.surfaces,
            &scene.materials,
            &mut scene.lights,
            &mut order,
            &mut scene.light_nodes,
        );
        scene.light_nodes.truncate(used);
    }
}
