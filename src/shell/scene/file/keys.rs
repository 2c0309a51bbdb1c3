//! Keys of the scene file: what TOML may say about change.

use super::value::{FieldOfView, Point, Positive, Power, Radiance, Scale};
use crate::scene::track::{Interpolation, Swing, Track};
use glam::DVec3;
use serde::Deserialize;
use toml::Spanned;

/// Keys of one table, and how it gets from one to the next.
pub(super) type Keys<K> = Vec<Spanned<K>>;

/// A key: what is so in a frame.
pub(super) trait Key {
    fn frame(&self) -> u32;
}

/// Declares a key of properties that may be left out.
macro_rules! key {
    ($(#[$doc:meta])* $name:ident { $($property:ident: $kind:ty),* }) => {
        $(#[$doc])*
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        pub(super) struct $name {
            pub frame: u32,
            $(pub $property: Option<$kind>,)*
        }

        impl Key for $name {
            fn frame(&self) -> u32 {
                self.frame
            }
        }
    };
}

key!(
    /// A key of the camera.
    CameraKey { from: Point, at: Point, up: Point, fov: FieldOfView, aperture: Power, focus: Positive }
);
key!(
    /// A key of a mesh.
    MeshKey { translate: Point, rotate: Point, scale: Scale }
);
key!(
    /// A key of a sphere.
    SphereKey { center: Point, radius: Positive }
);
key!(
    /// A key of a light.
    LightKey { center: Point, edge_u: Point, edge_v: Point, radiance: Radiance, power: Power }
);
key!(
    /// A key of a material.
    MaterialKey { emission: Radiance }
);

/// What is wrong with keys, and where.
pub(super) type Fault = (usize, String);

/// Checks that keys come in the order of their frames.
pub(super) fn check<K: Key>(keys: &Keys<K>) -> Result<(), Fault> {
    for pair in keys.windows(2) {
        let (a, b) = (pair[0].get_ref().frame(), pair[1].get_ref().frame());
        if a >= b {
            return Err((pair[1].span().start, format!("keys: frame {b} does not come after frame {a}")));
        }
    }
    Ok(())
}

/// The keys that name a property.
pub(super) fn named<K: Key, V>(keys: &Keys<K>, value: impl Fn(&K) -> Option<V>) -> Vec<(u32, V)> {
    keys.iter().filter_map(|key| Some((key.get_ref().frame(), value(key.get_ref())?))).collect()
}

/// A point that follows its keys.
pub(super) fn points<K: Key>(
    keys: &Keys<K>,
    blend: Interpolation,
    still: DVec3,
    value: impl Fn(&K) -> Option<Point>,
) -> Track<3> {
    Track::new(still.to_array(), named(keys, |key| value(key).map(|v| v.0)), blend, Swing::Free)
}
