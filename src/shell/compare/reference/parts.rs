//! A reference in parts: the same picture several times, with fewer samples and a seed each, and their mean.
//!
//! The samples of one render are stratified, so that nothing within it tells how far it is off: the variance of single
//! samples says too much, and iterations are not independent. Parts are. Their spread is honest, at the price that the
//! mean of eight is stratified less finely than one render would be.

use super::super::spread::Spread;
use super::noise::{self, Noise, Source};
use crate::error::Error;
use crate::frame::render::{self, Frame};
use crate::frame::settings::Settings;
use crate::picture::frame_io::Picture;
use crate::picture::metrics::luminance;
use crate::scene::LoadedScene;

/// Parts, at most: seven degrees of freedom make an interval a fifth wider than a known error would.
pub const PARTS: u32 = 8;
/// Samples a pixel of a part, at least.
const LEAST_SPP: u32 = 2;

/// Samples a pixel of each part.
fn division(spp: u32) -> impl Iterator<Item = u32> {
    let parts = (spp / LEAST_SPP).clamp(1, PARTS);
    (0..parts).map(move |part| spp / parts + u32::from(part < spp % parts))
}

/// Renders all parts and their mean. `settings` says how so many samples a pixel are rendered; seeds are `seed` and
/// those below it. The attributes are those of `settings(spp)`, and what the parts tell of the noise.
///
/// # Errors
/// As [`render::render`].
pub fn render(
    scene: &LoadedScene,
    settings: impl Fn(u32) -> Settings,
    (spp, seed): (u32, u32),
    threads: Option<usize>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Picture, Error> {
    let mut sum = Sum::default();
    let mut settings_of_all = settings(spp);
    settings_of_all.sampler.seed = seed;
    let mut picture = Picture::default();
    for (part, spp) in division(spp).enumerate() {
        let mut settings = settings(spp);
        settings.sampler.seed = seed - part as u32;
        let frame = render::render(scene, &settings, threads, progress)?;
        sum.add(&frame, f64::from(spp));
        picture = frame.picture(&settings_of_all, scene);
    }
    sum.write(&mut picture, f64::from(scene.cd_per_unit));
    Ok(picture)
}

/// The parts so far, merged as Chan, Golub and LeVeque (1979) merge moments.
#[derive(Default)]
struct Sum {
    parts: usize,
    /// Samples a pixel.
    spp: f64,
    pixels: Vec<Pixel>,
    /// Sum of luminances.
    energy: Moments,
}

/// Mean, and squared deviations of the parts' means from it times the parts' samples.
#[derive(Clone, Copy, Default)]
struct Moments {
    mean: f64,
    between: f64,
}

#[derive(Clone, Copy, Default)]
struct Pixel {
    rgb: [f64; 3],
    luminance: Moments,
    /// Squared deviations of samples from the means of their parts.
    within: f64,
}

impl Moments {
    /// Adds a mean of `new` samples to that of `old` ones.
    fn add(&mut self, value: f64, old: f64, new: f64) {
        let shift = value - self.mean;
        self.mean += shift * new / (old + new);
        self.between += shift * shift * old * new / (old + new);
    }

    /// Variance of the mean of `spp` samples in `parts` parts, whose variances go as one over their samples.
    fn variance_of_mean(&self, parts: usize, spp: f64) -> f64 {
        self.between / (parts.saturating_sub(1) as f64 * spp)
    }
}

impl Sum {
    fn add(&mut self, frame: &Frame, spp: f64) {
        self.pixels.resize(frame.rgb.len(), Pixel::default());
        let old = self.spp;
        for ((pixel, rgb), variance) in self.pixels.iter_mut().zip(&frame.rgb).zip(&frame.variance) {
            let part = spp / (old + spp);
            (0..3).for_each(|c| pixel.rgb[c] += (f64::from(rgb[c]) - pixel.rgb[c]) * part);
            pixel.luminance.add(luminance(*rgb), old, spp);
            pixel.within += f64::from(*variance) * spp * (spp - 1.0);
        }
        let energy = frame.rgb.iter().map(|rgb| luminance(*rgb)).sum();
        self.energy.add(energy, old, spp);
        (self.parts, self.spp) = (self.parts + 1, old + spp);
    }

    /// Makes the picture of one part that of all.
    fn write(&self, picture: &mut Picture, cd_per_unit: f64) {
        let spp = self.spp;
        picture.rgb = self.pixels.iter().map(|pixel| pixel.rgb.map(|value| value as f32)).collect();
        let of_sample = |pixel: &Pixel| (pixel.within + pixel.luminance.between) / (spp - 1.0).max(1.0);
        let variance = self.pixels.iter().map(|pixel| (of_sample(pixel) / spp) as f32).collect();
        picture.planes.insert("variance".into(), variance);
        picture.planes.insert("count".into(), vec![spp as f32; self.pixels.len()]);
        if self.parts > 1 {
            self.noise(picture, cd_per_unit).keep(self.parts, &mut picture.attributes);
        }
    }

    fn noise(&self, picture: &Picture, cd_per_unit: f64) -> Noise {
        let of_pixel = |pixel: &Pixel| pixel.luminance.variance_of_mean(self.parts, self.spp);
        let variance: Vec<f64> = self.pixels.iter().map(of_pixel).collect();
        let energy = self.energy.variance_of_mean(self.parts, self.spp).sqrt() / self.energy.mean;
        let energy = Spread::new(energy, (self.parts - 1) as f64);
        Noise { err: noise::err(&variance, picture, cd_per_unit), energy, source: Source::Parts }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::stats;
    use super::*;
    use crate::frame::settings::Method;
    use crate::scene;
    use statrs::distribution::{ContinuousCDF, FisherSnedecor};
    use std::path::Path;

    #[test]
    fn every_sample_is_in_a_part() {
        for (spp, parts) in [
            (1, vec![1]),
            (3, vec![3]),
            (5, vec![3, 2]),
            (16, vec![2; 8]),
            (4099, vec![513, 513, 513, 512, 512, 512, 512, 512]),
        ] {
            assert_eq!(division(spp).collect::<Vec<u32>>(), parts);
        }
    }

    #[test]
    fn moments_are_those_of_the_textbook() {
        // Means of 2, 1 and 1 samples: the mean 2.5, deviations 2·0.25 + 2.25 + 0.25 = 3, over 2 and over 4.
        let mut moments = Moments::default();
        for (value, old, new) in [(2.0, 0.0, 2.0), (4.0, 2.0, 1.0), (2.0, 3.0, 1.0)] {
            moments.add(value, old, new);
        }
        assert!((moments.mean - 2.5).abs() < 1e-12);
        assert!((moments.variance_of_mean(3, 4.0) - 3.0 / 8.0).abs() < 1e-12);
    }

    const REFERENCES: u32 = 48;
    const SPP: u32 = 32;

    /// What parts say of the energy's noise, against the spread of 48 references with seeds of their own. If both are right
    /// the ratio of the variances has Fisher's F with 48·7 and 47 degrees of freedom: between its 0.05 % and 99.95 %
    /// quantiles but for one in a thousand seeds (one test; seeds are fixed). The variance layer, which takes samples as
    /// independent, must be seen to say too much.
    #[test]
    fn parts_know_the_noise_of_their_mean() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
        let scene = scene::load(&file).unwrap();
        let settings = |spp| Settings::new(&scene, Method::Uniform, Some(spp), Some((16, 16)));
        let (mut energies, mut by_parts, mut by_variance) = (vec![], vec![], vec![]);
        for reference in 0..REFERENCES {
            let seeds = (SPP, 1000 + PARTS * reference);
            let picture = render(&scene, settings, seeds, Some(1), &|_| ()).unwrap();
            energies.push(picture.rgb.iter().map(|rgb| luminance(*rgb)).sum::<f64>());
            let parts = Noise::of(&picture, 100.0).unwrap();
            assert_eq!((parts.source, parts.energy), (Source::Parts, Spread::new(parts.energy.stderr, 7.0)));
            by_parts.push(parts.energy.stderr.powi(2));
            by_variance.push(noise::own_energy_stderr(&picture, &picture).powi(2));
        }
        let spread = Spread::of_mean(&energies).unwrap();
        let truth = f64::from(REFERENCES) * (spread.stderr / stats::mean(&energies)).powi(2);
        let fisher =
            FisherSnedecor::new(f64::from(REFERENCES * (PARTS - 1)), f64::from(REFERENCES - 1)).unwrap();
        let [low, high] = [0.0005, 0.9995].map(|probability| fisher.inverse_cdf(probability));
        let [parts, variance] = [by_parts, by_variance].map(|list| stats::mean(&list) / truth);
        println!(
            "parts {parts:.2}, variance layer {variance:.2} of the true variance ({low:.2} to {high:.2})"
        );
        assert!((low..high).contains(&parts), "parts say {parts} of the true variance");
        assert!(variance > high, "the layer should be seen to overstate: {variance}");
    }
}
