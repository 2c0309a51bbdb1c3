//! Sun and clear sky by direction: light scattered once along each line of sight, and an estimate of the rest.
//!
//! Rayleigh and Mie scattering once are integrated as by Nishita, Sirai, Tadamura and Nakamae, *Display of the Earth Taking
//! into Account Atmospheric Scattering*, SIGGRAPH 1993, through a round atmosphere, so that the sun may set. All further
//! scattering is taken for even in all directions, after Hillaire, *A Scalable and Production Ready Sky and Atmosphere
//! Rendering Technique*, CGF 39(4), 2020; coefficients for red, green and blue and the layer of ozone are of the same
//! source. Luminances are absolute: the sun's illuminance outside of the atmosphere is 128 klx (IES), taken for white.
//!
//! Limits: no clouds; three wavelengths; below the horizon an even ground that is lit by sun and sky.

use super::map::SkyMap;
use glam::Vec3;
use pmcip_core::tracer::scene::Sun;
use rayon::prelude::*;
use std::f32::consts::PI;

/// Half the angle under which the sun is seen, in radians: 0.53° in all.
pub const SUN_RADIUS: f32 = 0.004_625;
/// Illuminance by the sun outside of the atmosphere, in lux.
const SUN_LUX: f32 = 128_000.0;

/// Radii of the ground and of the atmosphere's end, in km.
const GROUND: f32 = 6360.0;
const TOP: f32 = 6460.0;
/// The eye's height above the ground, in km.
const EYE: f32 = 0.002;
/// Coefficients at the ground, in 1/km.
const RAYLEIGH: Vec3 = Vec3::new(5.802e-3, 13.558e-3, 33.1e-3);
const MIE: f32 = 3.996e-3;
const MIE_ABSORBED: f32 = 4.4e-3;
const OZONE: Vec3 = Vec3::new(0.650e-3, 1.881e-3, 0.085e-3);
/// Heights over which densities fall by e, in km.
const RAYLEIGH_SCALE: f32 = 8.0;
const MIE_SCALE: f32 = 1.2;
/// Asymmetry of Mie scattering.
const FORWARD: f32 = 0.8;

/// Steps along a line of sight, and towards the sun from each.
const STEPS: u32 = 40;
const SUN_STEPS: u32 = 12;
/// Heights at which further scattering is estimated, and directions there.
const HEIGHTS: usize = 24;
const DIRECTIONS: u32 = 64;
/// Rows of the picture.
const ROWS: u32 = 256;

/// A clear day.
#[derive(Clone, Copy, Debug)]
pub struct Daylight {
    /// To the sun, in the sky's axes; unit length, +y up.
    pub sun: Vec3,
    /// Amount of haze: 1 is a clear day, 0 clean air.
    pub haze: f32,
    /// Part of the light that the ground reflects.
    pub ground: [f32; 3],
}

/// What the air does with light at a height, in 1/km.
struct Air {
    rayleigh: Vec3,
    mie: f32,
    extinction: Vec3,
}

/// Light along a line of sight.
struct Line {
    /// Scattered towards the eye, of a sun of irradiance 1.
    light: Vec3,
    /// Part of even light around that is scattered towards the eye.
    passed_on: Vec3,
    /// Part of the light from behind that arrives.
    transmittance: Vec3,
}

impl Daylight {
    /// The sky and its sun, each cd/m² as radiance `scale`.
    pub fn sky(&self, scale: f32) -> SkyMap {
        let further = self.further();
        let eye = Vec3::Y * (GROUND + EYE);
        let (columns, half) = (2 * ROWS as usize, ROWS as usize / 2);
        let above: Vec<Vec3> = (0..half * columns)
            .into_par_iter()
            .map(|i| self.line(eye, direction(i % columns, i / columns), &further).light)
            .collect();
        let to_sun = self.transmittance(eye, self.sun);
        let ground = Vec3::from(self.ground) / PI * (irradiance(&above) + to_sun * self.sun.y.max(0.0));
        let of_sun = scale * SUN_LUX;
        let rows = above.into_iter().chain(std::iter::repeat_n(ground, half * columns));
        let texels = rows.map(|light| (light * of_sun).to_array()).collect();
        let solid_angle = 2.0 * PI * (1.0 - SUN_RADIUS.cos());
        let sun = Sun {
            direction: self.sun.to_array(),
            radius: SUN_RADIUS,
            radiance: (to_sun * of_sun / solid_angle).to_array(),
        };
        let shines = to_sun.max_element() > 0.0;
        SkyMap::new((2 * ROWS, ROWS), texels, shines.then_some(sun), "sun and sky".into())
    }

    fn air(&self, height: f32) -> Air {
        let rayleigh = RAYLEIGH * (-height / RAYLEIGH_SCALE).exp();
        let haze = self.haze * (-height / MIE_SCALE).exp();
        let ozone = OZONE * (1.0 - (height - 25.0).abs() / 15.0).max(0.0);
        Air { rayleigh, mie: MIE * haze, extinction: rayleigh + (MIE + MIE_ABSORBED) * haze + ozone }
    }

    /// Part of the light of the atmosphere's end that arrives at a point; none through the ground.
    fn transmittance(&self, from: Vec3, direction: Vec3) -> Vec3 {
        if meets(from, direction, GROUND).is_some() {
            return Vec3::ZERO;
        }
        let step = end(from, direction) / SUN_STEPS as f32;
        let at = |i: u32| from + direction * ((i as f32 + 0.5) * step);
        let depth: Vec3 = (0..SUN_STEPS).map(|i| self.air(height(at(i))).extinction).sum();
        (-depth * step).exp()
    }

    /// What comes along a line from the atmosphere's end, or from the ground without its own light. `further` is the even
    /// light of [`further`](Self::further).
    fn line(&self, from: Vec3, direction: Vec3, further: &[Vec3]) -> Line {
        let length = meets(from, direction, GROUND).unwrap_or_else(|| end(from, direction));
        let cosine = direction.dot(self.sun);
        let (rayleigh, mie) = (rayleigh_phase(cosine), mie_phase(cosine));
        let mut line = Line { light: Vec3::ZERO, passed_on: Vec3::ZERO, transmittance: Vec3::ONE };
        let mut start = 0.0;
        for i in 1..=STEPS {
            // Steps that grow: air is densest near the eye.
            let stop = length * (i as f32 / STEPS as f32).powi(2);
            let step = stop - start;
            let at = from + direction * (start + 0.5 * step);
            let air = self.air(height(at));
            let scattered = air.rayleigh + air.mie;
            let sun = self.transmittance(at, self.sun);
            let source =
                sun * (air.rayleigh * rayleigh + air.mie * mie) + scattered * even(further, height(at));
            // Extinction within the step is integrated exactly.
            let through = (-air.extinction * step).exp();
            let share = line.transmittance * (Vec3::ONE - through) / air.extinction.max(Vec3::splat(1e-9));
            line.light += source * share;
            line.passed_on += scattered * share;
            line.transmittance *= through;
            start = stop;
        }
        line
    }

    /// Even light of the second and all further scatterings by height.
    fn further(&self) -> Vec<Vec3> {
        (0..HEIGHTS).map(|i| self.further_at(height_of(i))).collect()
    }

    fn further_at(&self, height: f32) -> Vec3 {
        let at = Vec3::Y * (GROUND + height);
        let (mut second, mut passed_on) = (Vec3::ZERO, Vec3::ZERO);
        for i in 0..DIRECTIONS {
            let direction = spiral(i);
            let line = self.line(at, direction, &[]);
            second += line.light + line.transmittance * self.bounced(at, direction);
            passed_on += line.passed_on;
        }
        let mean = 1.0 / DIRECTIONS as f32;
        second * mean / (Vec3::ONE - passed_on * mean)
    }

    /// Radiance of the ground that a line meets, by the sun alone.
    fn bounced(&self, from: Vec3, direction: Vec3) -> Vec3 {
        let Some(length) = meets(from, direction, GROUND) else { return Vec3::ZERO };
        let up = (from + direction * length).normalize();
        let lit = self.transmittance(up * (GROUND + EYE), self.sun) * up.dot(self.sun).max(0.0);
        Vec3::from(self.ground) / PI * lit
    }
}

/// Height above the ground.
fn height(at: Vec3) -> f32 {
    (at.length() - GROUND).max(0.0)
}

/// Distance at which a ray from inside of the atmosphere meets a sphere around the earth's centre from outside.
fn meets(from: Vec3, direction: Vec3, radius: f32) -> Option<f32> {
    let [from, direction] = [from, direction].map(Vec3::as_dvec3);
    let along = from.dot(direction);
    let root = along * along - from.length_squared() + f64::from(radius).powi(2);
    (root > 0.0 && -along - root.sqrt() > 0.0).then(|| (-along - root.sqrt()) as f32)
}

/// Distance of the atmosphere's end.
fn end(from: Vec3, direction: Vec3) -> f32 {
    let [from, direction] = [from, direction].map(Vec3::as_dvec3);
    let along = from.dot(direction);
    let root = along * along - from.length_squared() + f64::from(TOP).powi(2);
    (root.max(0.0).sqrt() - along) as f32
}

fn rayleigh_phase(cosine: f32) -> f32 {
    3.0 / (16.0 * PI) * (1.0 + cosine * cosine)
}

/// Cornette and Shanks, *Physically reasonable analytic expression for the single-scattering phase function*, 1992.
fn mie_phase(cosine: f32) -> f32 {
    let g2 = FORWARD * FORWARD;
    let base = 1.0 + g2 - 2.0 * FORWARD * cosine;
    3.0 / (8.0 * PI) * (1.0 - g2) * (1.0 + cosine * cosine) / ((2.0 + g2) * base.powf(1.5))
}

/// The height of an entry of the table of even light: denser below.
fn height_of(i: usize) -> f32 {
    let part = i as f32 / (HEIGHTS - 1) as f32;
    (TOP - GROUND) * part * part
}

/// The table of even light at a height; none where there is no table yet.
fn even(table: &[Vec3], height: f32) -> Vec3 {
    if table.is_empty() {
        return Vec3::ZERO;
    }
    let place = (height / (TOP - GROUND)).clamp(0.0, 1.0).sqrt() * (HEIGHTS - 1) as f32;
    let below = (place as usize).min(HEIGHTS - 2);
    table[below].lerp(table[below + 1], place - below as f32)
}

/// Directions spread evenly over the sphere.
fn spiral(i: u32) -> Vec3 {
    let y = 1.0 - (2 * i + 1) as f32 / DIRECTIONS as f32;
    let (sin, cos) = (2.399_963_2 * i as f32).sin_cos();
    let r = (1.0 - y * y).sqrt();
    Vec3::new(r * cos, y, r * sin)
}

/// The direction of a texel.
fn direction(column: usize, row: usize) -> Vec3 {
    let (around, down) = (PI * (column as f32 + 0.5) / ROWS as f32, PI * (row as f32 + 0.5) / ROWS as f32);
    Vec3::new(down.sin() * around.sin(), down.cos(), -down.sin() * around.cos())
}

/// Irradiance of the ground by the rows above it.
fn irradiance(above: &[Vec3]) -> Vec3 {
    let columns = 2 * ROWS as usize;
    let texel = (PI / ROWS as f32).powi(2);
    let rows = above.chunks(columns).enumerate();
    let row = |(y, row): (usize, &[Vec3])| {
        let down = PI * (y as f32 + 0.5) / ROWS as f32;
        row.iter().sum::<Vec3>() * (down.sin() * down.cos() * texel)
    };
    rows.map(row).sum()
}

#[cfg(test)]
mod tests;
