//! What lets light pass: glass, and thin sheets.

use super::Converter;
use pmcip_core::tracer::scene::{Material, Scattering};

/// From this part of the light on that passes, what is closed is glass.
const MOSTLY_CLEAR: f32 = 0.5;

impl Converter<'_, '_> {
    /// Glass, and what is thin and lets light pass.
    pub(super) fn transmit(&mut self, material: &mut Material) {
        let Some(transmission) = self.stated.transmission() else { return };
        let mut part = transmission.transmission_factor().clamp(0.0, 1.0);
        if let Some(info) = transmission.transmission_texture() {
            self.note("transmission", "transmissionTexture: its mean is taken");
            part *= self.mean("transmissionTexture", &info, false)[0];
        }
        // Metal lets nothing pass.
        part *= 1.0 - self.stated.pbr_metallic_roughness().metallic_factor().clamp(0.0, 1.0);
        let volume = self.stated.volume().filter(|volume| volume.thickness_factor() > 0.0);
        if volume
            .as_ref()
            .is_some_and(|v| v.attenuation_distance().is_finite() && v.attenuation_color() != [1.0; 3])
        {
            self.note("volume", "KHR_materials_volume: what is inside is clear here");
        }
        if part <= 0.0 {
            return;
        }
        if part >= MOSTLY_CLEAR && (volume.is_some() || self.is_closed) {
            self.glass(material, part);
        } else {
            self.thin(material, part);
        }
    }

    /// A smooth dielectric.
    fn glass(&mut self, material: &mut Material, part: f32) {
        if material.roughness > 1e-3 {
            self.note("rough glass", "rough glass is smooth here");
        }
        if part < 1.0 {
            self.note("part glass", "what transmits at least half of the light transmits all of it here");
        }
        let [r, g, b, _] = self.stated.pbr_metallic_roughness().base_color_factor();
        let mut tint = [r, g, b].map(|v| v.clamp(0.0, 1.0));
        if let Some(info) = self.stated.pbr_metallic_roughness().base_color_texture() {
            self.note("glass", "the tint of glass is even here: the mean of baseColorTexture is taken");
            let mean = self.mean("baseColorTexture", &info, true);
            (0..3).for_each(|i| tint[i] *= mean[i]);
        }
        *material = Material {
            scattering: Scattering::Dielectric,
            specular: tint,
            ior: material.ior,
            ..Material::default()
        };
    }

    /// A sheet: of the light that is not reflected, `part` goes straight on.
    fn thin(&mut self, material: &mut Material, part: f32) {
        self.note("thin", "what is thin and transmits light is partly there, and does not tint what passes");
        // What is there scatters the rest, and has the whole lobe.
        let reflected = material.specular.iter().sum::<f32>() / 3.0;
        let there = 1.0 - part * (1.0 - reflected);
        if there > 0.0 {
            material.diffuse = material.diffuse.map(|v| (v * (1.0 - part) / there).min(1.0));
            material.specular = material.specular.map(|v| (v / there).min(1.0));
        }
        material.opacity = there;
    }
}
