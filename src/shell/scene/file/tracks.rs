//! Tracks from keys.

use super::keys::{Fault, named, points};
use super::tables::{CameraTable, LightTable, MaterialTable, MeshTable, SphereTable};
use super::value::{Point, Scale};
use crate::scene::place::Placement;
use crate::scene::script::{CameraTrack, GlowTrack, ObjectTrack};
use crate::scene::track::{Interpolation, Swing, Track, Turn};
use glam::{DVec3, Quat, Vec3};

impl CameraTable {
    /// The camera over time.
    pub fn track(&self) -> CameraTrack {
        let (keys, blend) = (&self.keys, self.interpolation);
        let up = self.up.map_or(DVec3::Y, |up| up.exact());
        let bounded =
            |still: f32, keys: Vec<(u32, [f64; 1])>| Track::new([still.into()], keys, blend, Swing::Bounded);
        let focus = named(keys, |k| k.focus.map(|v| [v.0.into()]));
        let sharp = self.focus.map(|v| v.0).or(focus.first().map(|key| key.1[0] as f32));
        CameraTrack {
            from: points(keys, blend, self.from.exact(), |k| k.from),
            at: points(keys, blend, self.at.exact(), |k| k.at),
            up: points(keys, blend, up, |k| k.up),
            fov: bounded(self.fov.0, named(keys, |k| k.fov.map(|v| [v.0.into()]))),
            aperture: bounded(
                self.aperture.map_or(0.0, |v| v.0),
                named(keys, |k| k.aperture.map(|v| [v.0.into()])),
            ),
            focus: sharp.map(|still| bounded(still, focus)),
        }
    }
}

/// Turns about the fixed x, y and z axis in this order, by degrees.
pub(super) fn rotation(degrees: Point) -> Quat {
    let turn = |axis, angle: f32| Quat::from_axis_angle(axis, angle.to_radians());
    let degrees = degrees.vec3();
    turn(Vec3::Z, degrees.z) * turn(Vec3::Y, degrees.y) * turn(Vec3::X, degrees.x)
}

impl MeshTable {
    /// The mesh's place over time.
    ///
    /// # Errors
    /// If a factor of the scale changes its sign, which would flatten the mesh on the way.
    pub fn track(&self) -> Result<ObjectTrack, Fault> {
        let (keys, blend) = (&self.keys, self.interpolation);
        let mut last: Option<Vec3> = None;
        for key in keys {
            let Some(scale) = key.get_ref().scale.map(Scale::factors) else { continue };
            if last.is_some_and(|last| (last * scale).min_element() < 0.0) {
                return Err((key.span().start, "keys: a factor of scale changes its sign".into()));
            }
            last = Some(scale);
        }
        let still = self.scale.map_or(Vec3::ONE, Scale::factors).as_dvec3().to_array();
        let scales = named(keys, |k| k.scale.map(|v| v.factors().as_dvec3().to_array()));
        Ok(ObjectTrack::Mesh {
            scale: Track::new(still, scales, blend, Swing::Bounded),
            rotate: Turn::new(
                self.rotate.map_or(Quat::IDENTITY, rotation),
                named(keys, |k| k.rotate.map(rotation)),
                blend,
            ),
            translate: points(keys, blend, self.translate.map_or(DVec3::ZERO, |v| v.exact()), |k| {
                k.translate
            }),
        })
    }

    /// Frames between which angles differ by more than half a turn, which no rotation follows.
    pub fn long_turn(&self) -> Option<(u32, u32)> {
        let turns = named(&self.keys, |k| k.rotate.map(|v| v.vec3()));
        let far = turns.windows(2).find(|pair| (pair[1].1 - pair[0].1).abs().max_element() > 180.0)?;
        Some((far[0].0, far[1].0))
    }
}

impl SphereTable {
    /// The sphere's place over time.
    pub fn track(&self) -> ObjectTrack {
        let (keys, blend) = (&self.keys, self.interpolation);
        let radii = named(keys, |k| k.radius.map(|v| [v.0.into()]));
        ObjectTrack::Sphere {
            center: points(keys, blend, self.center.exact(), |k| k.center),
            radius: Track::new([self.radius.0.into()], radii, blend, Swing::Bounded),
        }
    }
}

impl LightTable {
    /// The light's place over time.
    pub fn track(&self) -> ObjectTrack {
        let (keys, blend) = (&self.keys, self.interpolation);
        ObjectTrack::Light {
            center: points(keys, blend, self.center.exact(), |k| k.center),
            edge_u: points(keys, blend, self.edge_u.exact(), |k| k.edge_u),
            edge_v: points(keys, blend, self.edge_v.exact(), |k| k.edge_v),
        }
    }

    /// The light's place in a frame.
    ///
    /// # Errors
    /// If it has no area.
    pub fn placement(&self, frame: u32) -> Result<Placement, &'static str> {
        self.track().at(f64::from(frame))
    }

    /// The radiance over time, of this material.
    pub fn glow(&self, material: u32) -> GlowTrack {
        let (keys, blend) = (&self.keys, self.interpolation);
        let powers = named(keys, |k| k.power.map(|v| [v.0.into()]));
        GlowTrack {
            material,
            emission: Track::new(
                self.radiance.0.map(f64::from),
                named(keys, |k| k.radiance.map(|v| v.0.map(f64::from))),
                blend,
                Swing::Bounded,
            ),
            power: Track::new([self.power.map_or(1.0, |v| v.0.into())], powers, blend, Swing::Bounded),
        }
    }
}

impl MaterialTable {
    /// The emission over time, of this material.
    pub fn glow(&self, material: u32) -> GlowTrack {
        let (keys, blend) = (&self.keys, self.interpolation);
        let emissions = named(keys, |k| k.emission.map(|v| v.0.map(f64::from)));
        let still = self.emission.map_or([0.0; 3], |v| v.0.map(f64::from));
        GlowTrack {
            material,
            emission: Track::new(still, emissions, blend, Swing::Bounded),
            power: Track::new([1.0], [], Interpolation::Linear, Swing::Bounded),
        }
    }
}
