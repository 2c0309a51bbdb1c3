//! What the core makes of a glTF material.
//!
//! * Base colour b, metallic part m and index n make a diffuse surface of reflectance b (1 − m) (1 − F) and a GGX lobe of
//!   reflectance F (1 − m) + b m at normal incidence and of width α = roughness², with F = ((n − 1) / (n + 1))² as
//!   `KHR_materials_ior` and `KHR_materials_specular` have it. (glTF lets the diffuse part shrink at grazing angles as
//!   the lobe grows; here it does not: they differ by some percent beyond 70°.)
//! * Textures vary the diffuse part, what is emitted, what is there and, of all but glass, the normals. Lobes are even: of a texture for roughness and
//!   metal, and of that for the colour of metals, the mean is taken.
//! * What is emitted is radiance in cd/m².
//! * `KHR_materials_transmission`: what encloses a volume, or is a closed mesh as programs write glass, is a smooth
//!   dielectric tinted by b if at least half of the light passes. Anything else is thin: the part that passes goes straight on.
//! * `MASK` is a cut-out, `BLEND` partial coverage. Both sides of a surface reflect, `doubleSided` or not.

mod glass;

use super::texture::{Pictures, Stated, Turn, Use};
use crate::scene::assemble::Assembly;
use crate::scene::notes::Notes;
use crate::scene::texture::Purpose;
use gltf::Material as Source;
use gltf::material::AlphaMode;
use gltf::texture::Info;
use pmcip_core::tracer::scene::{MIN_ROUGHNESS, Material, NO_TEXTURE, Scattering};

/// The most radiance that a material gets.
const BRIGHTEST: f32 = 1e20;

/// Index of refraction where none is stated.
const DEFAULT_INDEX: f32 = 1.5;

/// A material of the core, and which coordinates its textures are looked up by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    pub material: u32,
    /// Number of the set of coordinates.
    pub set: u32,
    /// What is done to them.
    pub turn: Option<Turn>,
    /// Whether colours of vertices count.
    pub coloured: bool,
    /// Whether it has textures.
    pub textured: bool,
    /// Whether something of it has a colour that those of vertices do not reach.
    pub tinted: bool,
}

impl Look {
    /// A material that is not the file's.
    pub fn plain(material: u32) -> Look {
        Look { material, set: 0, turn: None, coloured: false, textured: false, tinted: false }
    }
}

/// Converts a material of a primitive that is closed or not.
pub(super) fn convert(
    stated: &Source<'_>,
    is_closed: bool,
    pictures: &mut Pictures<'_>,
    notes: &mut Notes,
    assembly: &mut Assembly,
) -> Look {
    Converter { stated, is_closed, pictures, notes, assembly, laid: None }.convert()
}

struct Converter<'a, 'b> {
    stated: &'a Source<'a>,
    is_closed: bool,
    pictures: &'a mut Pictures<'b>,
    notes: &'a mut Notes,
    assembly: &'a mut Assembly,
    /// The coordinates of the textures so far.
    laid: Option<(u32, Option<Turn>)>,
}

impl Converter<'_, '_> {
    fn name(&self) -> String {
        let number = self.stated.index().map_or("default".to_owned(), |index| index.to_string());
        let name = self.stated.name().map(|name| format!("\"{}\"", name.escape_debug()));
        name.unwrap_or(number)
    }

    fn note(&mut self, kind: &'static str, message: &str) {
        let name = self.name();
        self.notes.add(kind, || format!("material {name}: {message}"));
    }

    fn convert(&mut self) -> Look {
        let mut material = self.surface();
        self.transmit(&mut material);
        self.cut_out(&mut material);
        self.glow(&mut material);
        let map = self.bend(&material);
        self.name_others();
        let name = self.name();
        let (set, turn) = self.laid.unwrap_or((0, None));
        let coloured = material.scattering == Scattering::Rough;
        let tinted = !coloured || self.stated.pbr_metallic_roughness().metallic_factor() > 0.0;
        let textured = self.laid.is_some();
        let material = self.assembly.add_named(material, &name);
        if let Some(map) = map {
            self.assembly.bend(material, map);
        }
        Look { material, set, turn, coloured, textured, tinted }
    }

    /// Base colour, metal and roughness.
    fn surface(&mut self) -> Material {
        let stated = self.stated;
        let pbr = stated.pbr_metallic_roughness();
        let [r, g, b, _] = pbr.base_color_factor();
        let base = self.unit("baseColorFactor", [r, g, b]);
        let colour = pbr.base_color_texture();
        let texture = colour.as_ref().and_then(|info| self.texture("baseColorTexture", info, Purpose::Solid));
        let [_, green, blue, _] = match pbr.metallic_roughness_texture() {
            Some(info) => {
                self.note(
                    "metallicRoughness",
                    "metallicRoughnessTexture: lobes are even here: its mean is taken",
                );
                self.mean("metallicRoughnessTexture", &info, false)
            }
            None => [1.0; 4],
        };
        let [metal, roughness] = self.unit("factors", [pbr.metallic_factor(), pbr.roughness_factor()]);
        let (metal, roughness) = (metal * blue, roughness * green);
        let mut tint = base;
        if let (Some(info), true) = (&colour, metal > 0.0 && texture.is_some()) {
            self.note("metal", "a metal's colour is even here: the mean of baseColorTexture is taken");
            let mean = self.mean("baseColorTexture", info, true);
            (0..3).for_each(|i| tint[i] *= mean[i]);
        }
        let index = self.index();
        let normal = self.normal_reflectance(index);
        let (mut diffuse, mut specular) = ([0.0; 3], [0.0; 3]);
        for i in 0..3 {
            diffuse[i] = base[i] * (1.0 - metal) * (1.0 - normal[i]);
            specular[i] = (normal[i] * (1.0 - metal) + tint[i] * metal).clamp(0.0, 1.0);
        }
        if stated.unlit() {
            self.note("unlit", "KHR_materials_unlit: it is lit as all else, and diffuse");
            (diffuse, specular) = (base, [0.0; 3]);
        }
        Material {
            diffuse,
            specular,
            texture: texture.unwrap_or(NO_TEXTURE),
            roughness: (roughness * roughness).clamp(MIN_ROUGHNESS, 1.0),
            ior: index,
            ..Material::default()
        }
    }

    /// The index of refraction, above 0.
    fn index(&mut self) -> f32 {
        match self.stated.ior().unwrap_or(DEFAULT_INDEX) {
            // What reflects as if it were infinitely dense.
            0.0 => 1e6,
            index if index >= 1.0 && index.is_finite() => index,
            _ => {
                self.note("ior", "ior is below 1: taken for 1.5");
                DEFAULT_INDEX
            }
        }
    }

    /// What a dielectric of this index reflects at normal incidence.
    fn normal_reflectance(&mut self, index: f32) -> [f32; 3] {
        let by_index = ((index - 1.0) / (index + 1.0)).powi(2);
        let Some(specular) = self.stated.specular() else { return [by_index; 3] };
        if specular.specular_texture().is_some() || specular.specular_color_texture().is_some() {
            self.note("specular", "KHR_materials_specular: its textures are without effect here");
        }
        let factor = specular.specular_factor().clamp(0.0, 1.0);
        specular.specular_color_factor().map(|v| (by_index * v.max(0.0)).min(1.0) * factor)
    }

    /// Says how much of the surface is there.
    fn cut_out(&mut self, material: &mut Material) {
        let stated = self.stated;
        let pbr = stated.pbr_metallic_roughness();
        let factor = pbr.base_color_factor()[3].clamp(0.0, 1.0);
        let cutoff = match stated.alpha_mode() {
            AlphaMode::Opaque => return,
            AlphaMode::Mask => Some(stated.alpha_cutoff().unwrap_or(0.5)),
            AlphaMode::Blend => None,
        };
        if material.scattering == Scattering::Dielectric {
            self.note("alpha", "glass is all there, whatever its alphaMode");
            return;
        }
        if let Some(info) = pbr.base_color_texture() {
            let purpose = Purpose::Alpha(factor, cutoff);
            if let Some(texture) = self.texture("baseColorTexture", &info, purpose) {
                material.opacity_texture = texture;
                return;
            }
        }
        material.opacity *= match cutoff {
            Some(cutoff) => f32::from(u8::from(factor >= cutoff)),
            None => factor,
        };
        if material.opacity == 0.0 {
            self.note("invisible", "its alpha is 0: nothing is seen of it");
        }
    }

    /// Lets the surface shine.
    fn glow(&mut self, material: &mut Material) {
        let stated = self.stated;
        let strength = stated.emissive_strength().unwrap_or(1.0).max(0.0);
        let factor = stated.emissive_factor().map(|v| v.max(0.0) * strength);
        let factor = factor.map(|v| v.min(BRIGHTEST));
        if factor == [0.0; 3] {
            return;
        }
        if stated.double_sided() {
            self.note("both sides", "what is emissive and doubleSided shines on its front alone");
        }
        if material.scattering == Scattering::Dielectric {
            self.note("glass lamp", "glass does not shine");
            return;
        }
        match stated.emissive_texture() {
            None => material.emission = factor,
            Some(info) => {
                if let Some(texture) = self.texture("emissiveTexture", &info, Purpose::Light(factor)) {
                    material.emission_texture = texture;
                } else {
                    let mean = self.mean("emissiveTexture", &info, true);
                    material.emission = [0, 1, 2].map(|i| factor[i] * mean[i]);
                }
            }
        }
    }

    /// The normal map, if there is one.
    fn bend(&mut self, material: &Material) -> Option<u32> {
        let normal = self.stated.normal_texture()?;
        if material.scattering == Scattering::Dielectric {
            self.note("normal", "normalTexture is without effect on glass");
            return None;
        }
        let scale = if normal.scale().is_finite() { normal.scale() } else { 1.0 };
        self.laid_texture("normalTexture", Stated::from(&normal), Purpose::Normal(scale), "left out")
    }

    /// Names what has no effect.
    fn name_others(&mut self) {
        if self.stated.occlusion_texture().is_some() {
            self.note(
                "occlusion",
                "occlusionTexture is not needed: what is in the way of light is found out",
            );
        }
    }

    fn unit<const N: usize>(&mut self, key: &'static str, value: [f32; N]) -> [f32; N] {
        let clamped = value.map(|v| v.clamp(0.0, 1.0));
        if clamped != value {
            self.note(key, &format!("{key} is outside 0 to 1: clamped"));
        }
        clamped
    }

    /// A texture by the coordinates of the textures before it, or none with a note.
    fn texture(&mut self, key: &'static str, info: &Info<'_>, purpose: Purpose) -> Option<u32> {
        self.laid_texture(key, Stated::from(info), purpose, "its mean is taken")
    }

    /// The same, and what becomes of one that lies by other coordinates.
    fn laid_texture(
        &mut self,
        key: &'static str,
        stated: Stated<'_>,
        purpose: Purpose,
        otherwise: &str,
    ) -> Option<u32> {
        let used = self.pictures.used(stated, self.notes)?;
        let coordinates = (used.set, used.turn);
        if *self.laid.get_or_insert(coordinates) != coordinates {
            self.note(
                "sets",
                &format!("{key}: textures of one material lie by different coordinates: {otherwise}"),
            );
            return None;
        }
        match self.pictures.load(&mut self.assembly.textures, &used, purpose) {
            Ok(loaded) => Some(loaded.texture),
            Err(reason) => {
                self.note(key, &format!("{key}: {reason}: left out"));
                None
            }
        }
    }

    /// The mean of a texture, 1 if it cannot be read, which is noted.
    fn mean(&mut self, key: &'static str, info: &Info<'_>, of_colours: bool) -> [f32; 4] {
        let used: Option<Use> = self.pictures.used(Stated::from(info), self.notes);
        match used.map(|used| self.pictures.mean(used.image, of_colours)) {
            Some(Ok(mean)) => mean,
            Some(Err(reason)) => {
                self.note(key, &format!("{key}: {reason}: left out"));
                [1.0; 4]
            }
            None => [1.0; 4],
        }
    }
}
