//! Speed against error: every method at every sample count, many times, against one reference.
//!
//! A [`Plan`] names [`Variant`]s of the sampler, sample counts and a number of runs. [`run`] renders them all, the
//! methods taking turns within a sample count and the sample counts within a run, so that a machine that is busy
//! for a while hurts all methods alike. Each render has a seed of its own, and none that of the reference. What comes
//! out, a [`Comparison`], goes to disk as JSON, CSV and a page through [`mod@report`]; [`reference`](mod@reference)
//! keeps the reference from one comparison to the next.
//!
//! Seconds are wall time of the render, without loading the scene, measuring and writing; a row has the median of
//! its runs, and the mean of the errors. Errors are in the units of [`metrics`](crate::picture::metrics).
//!
//! What is rendered, a [`Stage`], is a still picture or the frames of an animation. Of frames there are curves and one
//! measure more, flicker; a row then has the means over all frames.
//!
//! Pictures of other programs, [`Other`], are rows as well, measured against the same reference; they have no pictures on the
//! page.
//!
//! The energy bias has a standard error that contains the spread of the runs and the reference's own noise, as far as
//! anything tells that ([`reference::noise`]), and an interval of at least 95 % by Student's t: three runs know their spread so badly
//! that two standard errors would miss the truth in one case of five. With a single run the `variance` plane of its
//! picture stands for the spread of runs: that takes samples and pixels as independent, and its error as known.
//!
//! Limits: errors contain the reference's own noise, which [`Reference`](reference::Reference) estimates, and every
//! method's last picture is kept, hence 24 bytes a pixel and method.

mod add;
mod colour;
mod data;
mod digits;
mod other;
mod page;
mod pictures;
mod plan;
mod plot;
mod raster;
pub mod ratio;
pub mod reference;
pub mod report;
mod run;
pub mod spread;
mod stage;
mod stats;
mod table;
mod variant;
mod write;

pub use data::{Comparison, FrameRow, Row, Shown};
pub use other::Other;
pub use plan::Plan;
pub use run::run;
pub use stage::{Moving, Shot, Stage, Still};
pub use stats::Measures;
pub use variant::Variant;
