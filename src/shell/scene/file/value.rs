//! Numbers of the scene file, checked as they are read, so that an error knows its line.

use crate::scene::model::MAX_SIZE;
use glam::{DVec3, Vec3};
use pmcip_core::tracer::scene::MIN_ROUGHNESS;
use serde::{Deserialize, Deserializer, de::Error};

/// Declares a type that can only be read if its value passes a test.
macro_rules! checked {
    ($(#[$doc:meta])* $name:ident($value:ty), $expected:expr, $test:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub(super) struct $name(pub $value);

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let value = <$value>::deserialize(deserializer)?;
                let test: fn(&$value) -> bool = $test;
                if test(&value) { Ok($name(value)) } else { Err(D::Error::custom(concat!("expected ", $expected))) }
            }
        }
    };
}

checked!(
    /// An image's width or height in pixels.
    Size(u32), "a size from 1 to 16384", |v| (1..=MAX_SIZE).contains(v)
);
checked!(
    /// A length, an index of refraction, a factor.
    Positive(f32), "a finite number above 0", |v| v.is_finite() && *v > 0.0
);
checked!(
    /// Brightness of a picture in stops.
    Exposure(f32), "a finite number of stops", |v| v.is_finite()
);
checked!(
    /// A factor that may be 0.
    Power(f32), "a finite number, not below 0", |v| v.is_finite() && *v >= 0.0
);
checked!(
    /// A part of something.
    Part(f32), "a number from 0 to 1", |v| (0.0..=1.0).contains(v)
);
checked!(
    /// The width of a lobe.
    Roughness(f32), "a number from 0.000001 to 1", |v| (MIN_ROUGHNESS..=1.0).contains(v)
);
checked!(
    /// An angle in degrees.
    FieldOfView(f32), "an angle between 0 and 180 degrees", |v| *v > 0.0 && *v < 180.0
);
checked!(
    /// How often an icosahedron is split.
    Subdivisions(u32), "a number from 0 to 8", |v| *v <= 8
);
checked!(
    /// A point, a direction, three angles.
    Point([f64; 3]), "three finite numbers", |v| v.iter().all(|v| v.abs() <= f64::from(f32::MAX))
);
checked!(
    /// A colour that takes no more light than there is.
    Reflectance([f32; 3]), "three numbers from 0 to 1", |v| v.iter().all(|v| (0.0..=1.0).contains(v))
);
checked!(
    /// A colour without limit.
    Radiance([f32; 3]), "three finite numbers, none below 0", |v| v.iter().all(|v| v.is_finite() && *v >= 0.0)
);
checked!(
    /// One factor for all axes, or one for each; a negative factor mirrors.
    Scale(Factors), "finite factors other than 0", |f| f.vec3().to_array().iter().all(|v| v.is_normal())
);

/// A number or three.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "expected a number or three numbers")]
pub(super) enum Factors {
    Same(f32),
    Each([f32; 3]),
}

impl Factors {
    fn vec3(self) -> Vec3 {
        match self {
            Factors::Same(v) => Vec3::splat(v),
            Factors::Each(v) => Vec3::from_array(v),
        }
    }
}

impl Scale {
    /// The factor of each axis.
    pub fn factors(self) -> Vec3 {
        self.0.vec3()
    }
}

impl Point {
    /// As a vector.
    pub fn vec3(self) -> Vec3 {
        self.exact().as_vec3()
    }

    /// As a vector of double precision.
    pub fn exact(self) -> DVec3 {
        DVec3::from_array(self.0)
    }
}
