//! Animations of a glTF file, as keys of its nodes.
//!
//! All animations play at once from time 0, as long as no two move the same part of a node: of such the first plays.

use super::data::Data;
use crate::scene::channel::{Blend, Channel, Key};
use crate::scene::model::Frames;
use crate::scene::notes::Notes;
use crate::scene::rig::Rig;
use crate::scene::room::Kind;
use gltf::animation::{Interpolation, Property};
use gltf::{Animation, Document};
use std::collections::HashSet;

/// Frames a second: glTF has seconds only.
pub(super) const FPS: f64 = 24.0;

/// Names that a note lists at most.
const NAMES: usize = 5;

/// Lets the rig move; returns the frames that this takes, if it takes any.
///
/// # Errors
/// If keys are not there.
pub(super) fn animate(
    document: &Document,
    data: &Data,
    rig: &mut Rig,
    notes: &mut Notes,
) -> Result<Option<Frames>, String> {
    let (mut taken, mut left_out) = (HashSet::new(), Vec::new());
    for animation in document.animations() {
        let parts: Vec<_> = animation.channels().map(|c| part(&c.target())).collect();
        if parts.iter().any(|part| taken.contains(part)) {
            let number = animation.index().to_string();
            left_out.push(animation.name().map_or(number, |name| format!("\"{}\"", name.escape_debug())));
            continue;
        }
        taken.extend(parts);
        add(&animation, data, rig, notes)?;
    }
    if !left_out.is_empty() {
        let more = left_out.len().saturating_sub(NAMES);
        let names = left_out[..left_out.len() - more].join(", ");
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        notes.add("animations", || {
            format!("animations that move what an earlier one moves are left out: {names}{more}")
        });
    }
    let spans = rig.joints.iter().filter_map(|joint| joint.moves.span());
    let span = spans.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    // A key that is meant to be at a frame may be a little beside it.
    const BESIDE: f64 = 1e-3;
    Ok(span.map(|(start, end)| Frames {
        first: (start * FPS + BESIDE).floor().max(0.0) as u32,
        last: (end * FPS - BESIDE).ceil().max(0.0) as u32,
        fps: FPS as f32,
    }))
}

/// What a channel moves.
fn part(target: &gltf::animation::Target<'_>) -> (usize, u8) {
    (target.node().index(), target.property() as u8)
}

fn add(animation: &Animation<'_>, data: &Data, rig: &mut Rig, notes: &mut Notes) -> Result<(), String> {
    for channel in animation.channels() {
        let (sampler, target) = (channel.sampler(), channel.target());
        if target.property() == Property::MorphTargetWeights {
            notes.add("weights", || "animations of morph targets are left out".into());
            continue;
        }
        let blend = match sampler.interpolation() {
            Interpolation::Step => Blend::Step,
            Interpolation::Linear => Blend::Linear,
            Interpolation::CubicSpline => Blend::Cubic,
        };
        let times = data.fractions(&sampler.input())?;
        data.lease.take(times.len(), Kind::Keys)?;
        let moves = &mut rig.joints[target.node().index()].moves;
        let good = match target.property() {
            Property::Translation => {
                moves.translation = keys(&times, &data.vectors::<3>(&sampler.output())?, blend);
                moves.translation.is_some()
            }
            Property::Rotation => {
                moves.rotation = keys(&times, &data.vectors::<4>(&sampler.output())?, blend);
                moves.rotation.is_some()
            }
            _ => {
                moves.scale = keys(&times, &data.vectors::<3>(&sampler.output())?, blend);
                moves.scale.is_some()
            }
        };
        if !good {
            let name = animation.index();
            let what = "keys whose times do not rise, or that are too few or no numbers, are left out";
            notes.add("keys", || format!("animation {name}: {what}"));
        }
    }
    Ok(())
}

/// A channel of these keys; of a cubic each has a tangent before and after its value.
fn keys<const N: usize>(times: &[f32], values: &[[f32; N]], blend: Blend) -> Option<Channel<N>> {
    let each = if blend == Blend::Cubic { 3 } else { 1 };
    if times.len().checked_mul(each) != Some(values.len()) {
        return None;
    }
    let key = |values: &[[f32; N]]| -> Key<N> {
        let exact = |i: usize| values[i].map(f64::from);
        if each == 3 { [exact(0), exact(1), exact(2)] } else { [[0.0; N], exact(0), [0.0; N]] }
    };
    let times = times.iter().map(|time| f64::from(*time));
    Channel::new(times.zip(values.chunks_exact(each).map(key)).collect(), blend)
}
