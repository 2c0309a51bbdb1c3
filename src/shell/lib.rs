//! The std shell around `pmcip-core`: scenes, frames, reports, command line.
//!
//! A scene on disk becomes arrays ([`scene`]), a trial picture tells whether the camera sees any light ([`probe`]),
//! the core renders them on all threads ([`render`]) as the
//! [`settings`] say, until their samples are spent or it is good enough ([`stop`]), filters the frame if it shall ([`guide`]), and the frame goes to disk as EXR and PNG ([`frame_io`], through [`mod@output`], which never
//! leaves half a file) or is measured against a reference ([`metrics`]); [`compare`] does so for many methods and
//! reports. An animation is a sequence of such frames ([`sequence`]; [`motion`] tells where
//! a pixel was a frame ago, [`predict`] lets a frame learn from those before), and a [`video`] for people. Pictures made by earlier programs are known by their [`version`].
//! The program `pmcip` puts a command line before this and adds nothing to it. The formulas of sampling and
//! shading are all in the core.

pub mod compare;
pub mod error;
pub mod frame_io;
pub mod guide;
pub mod metrics;
pub mod motion;
pub mod output;
pub mod photons;
pub mod predict;
pub mod probe;
pub mod render;
pub mod scene;
pub mod sequence;
pub mod settings;
pub mod stop;
pub mod version;
pub mod video;
