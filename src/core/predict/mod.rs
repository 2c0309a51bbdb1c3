//! What earlier frames of an animation tell about the next one: the start-up kernel.
//!
//! Lai, Chenney, Liu, Niu, Fan, *Animation rendering with Population Monte Carlo image-plane sampler*, The Visual
//! Computer 2010, section 3.2, carry the kernel α along the motion of the picture. Here a [`Belief`] is carried
//! instead: variance and luminance of a pixel's samples, and how many degrees of freedom that knowledge is worth. A
//! frame then adds to what earlier ones knew. From frame to frame:
//!
//! 1. [`carry`] moves the beliefs along a correspondence, from motion vectors or from
//!    homographies ([`tracks`]).
//! 2. [`Sampler::begin_predicted`](crate::sampler::Sampler::begin_predicted) takes them where the frame itself knows
//!    too little.
//! 3. [`Sampler::beliefs`](crate::sampler::Sampler::beliefs) says what the frame has seen, and [`Filter::update`]
//!    merges both: a scalar Kalman filter for every pixel (Kalman, *A new approach to linear filtering and prediction
//!    problems*, 1960) whose process noise is what the prediction was off by more than chance explains.
//!
//! What was carried stems from other frames, and is independent of the samples whose number it decides: no bias.
//!
//! Positions are in pixels from the upper left corner; the centre of the first pixel is (0.5, 0.5). Planes are rows from
//! the top. Everything is lent by the caller, and the same input gives the same bits.
//!
//! ```
//! use pmcip_core::predict::{Belief, Filter, carry};
//!
//! let old = [1.0, 2.0, 3.0, 4.0].map(|variance| Belief { variance, light: 1.0, freedom: 10.0 });
//! let from_the_right = [[1.5, 0.5], [2.5, 0.5], [3.5, 0.5], [f32::NAN; 2]];
//! let mut beliefs = [Belief::NONE; 4];
//! carry(&old, 4, 1, &from_the_right, Belief::NONE, &mut beliefs)?;
//! assert_eq!(beliefs.map(|b| b.variance), [2.0, 3.0, 4.0, 0.0]);
//!
//! let seen = [Belief { variance: 3.0, light: 1.0, freedom: 10.0 }; 4];
//! Filter::new(100.0).update(4, &mut beliefs, &seen)?;
//! assert!(beliefs[0].variance > 2.4 && beliefs[0].variance < 2.6 && beliefs[0].freedom > 15.0);
//! assert_eq!(beliefs[3], seen[3]);
//! # Ok::<(), pmcip_core::predict::Error>(())
//! ```

mod belief;
mod carry;
pub mod features;
mod filter;
pub mod homography;
pub mod tracks;

pub use belief::{Belief, Error, Prior};
pub use carry::carry;
pub use filter::{Filter, Outlook};

#[cfg(test)]
mod tests;
