//! What methods are compared on: a still picture, or the frames of an animation.

use super::reference::{self, Noise};
use super::spread::Spread;
use crate::error::Error;
use crate::frame::settings::Settings;
use crate::picture::frame_io::{self, Picture};
use crate::scene::{Animation, LoadedScene};
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// A frame to be rendered.
#[derive(Clone, Copy, Debug)]
pub struct Shot<'a> {
    /// The scene as it is in this frame.
    pub scene: &'a LoadedScene,
    /// Size, depth, camera and number of the frame.
    pub base: Settings,
    /// What it is judged by.
    pub reference: &'a Picture,
    /// Standard error of the reference's energy over the energy, if anything tells it.
    pub noise: Option<Spread>,
}

/// Frames and their references.
pub trait Stage {
    /// Numbers of the frames.
    fn frames(&self) -> RangeInclusive<u32>;

    /// Whether it is a sequence, if perhaps of one frame.
    fn is_sequence(&self) -> bool;

    /// Brings a frame.
    ///
    /// # Errors
    /// [`Error::Setting`] if the scene cannot be brought to this frame, [`Error::Read`] if its reference is gone.
    fn show(&mut self, frame: u32) -> Result<Shot<'_>, Error>;
}

/// A still picture.
#[derive(Clone, Copy, Debug)]
pub struct Still<'a>(pub Shot<'a>);

impl Stage for Still<'_> {
    fn frames(&self) -> RangeInclusive<u32> {
        self.0.base.sampler.frame..=self.0.base.sampler.frame
    }

    fn is_sequence(&self) -> bool {
        false
    }

    fn show(&mut self, _: u32) -> Result<Shot<'_>, Error> {
        Ok(self.0)
    }
}

/// Frames of an animation. References are read one at a time: there may be more than fit into memory.
pub struct Moving<'a> {
    /// The scene.
    pub animation: &'a mut Animation,
    /// Numbers of the frames.
    pub frames: RangeInclusive<u32>,
    /// Settings of a frame, but for its number.
    pub base: &'a dyn Fn(&LoadedScene) -> Settings,
    /// File of the references, without a number.
    pub references: PathBuf,
    /// The reference read last.
    pub reference: Picture,
}

impl Moving<'_> {
    /// Brings the scene to a frame, and says how that is rendered.
    ///
    /// # Errors
    /// [`Error::Setting`] if that is not possible.
    pub fn seek(&mut self, frame: u32) -> Result<(&LoadedScene, Settings), Error> {
        self.animation.seek(frame).map_err(Error::setting)?;
        let mut base = (self.base)(self.animation.scene());
        base.sampler.frame = frame;
        Ok((self.animation.scene(), base))
    }
}

impl Stage for Moving<'_> {
    fn frames(&self) -> RangeInclusive<u32> {
        self.frames.clone()
    }

    fn is_sequence(&self) -> bool {
        true
    }

    fn show(&mut self, frame: u32) -> Result<Shot<'_>, Error> {
        let (_, base) = self.seek(frame)?;
        self.reference = frame_io::read_exr(&reference::of_frame(&self.references, frame))?;
        let scene = self.animation.scene();
        let noise = Noise::of(&self.reference, f64::from(scene.cd_per_unit)).map(|noise| noise.energy);
        Ok(Shot { scene, base, reference: &self.reference, noise })
    }
}
