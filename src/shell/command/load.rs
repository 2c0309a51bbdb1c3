//! Scenes as the command line wants them: files, and what lights them.

use super::arguments::{Common, Source};
use super::common::{Failure, bad, blame, eye, path_settings};
use pmcip::frame::probe;
use pmcip::frame::settings::{Method, Settings};
use pmcip::scene::{Animation, Eye, LightChoice, LoadedScene, Options, SkyMap};
use std::path::Path;

/// Loads a scene that can be rendered, and passes on what the loader noticed. One that its own light leaves in the dark, at
/// an exposure that is the scene's where none is given, gets a light of last resort, if it is no scene file and may have one.
pub fn load(common: &Common, exposure: Option<f32>) -> Result<Animation, Failure> {
    let loader = Loader { source: &common.source, eye: eye(common), quiet: common.quiet };
    loader.load(exposure, |scene| path_settings(scene, common, Method::Uniform, None))
}

/// What is loaded.
pub struct Loader<'a> {
    pub source: &'a Source,
    /// From where the lamp by the camera shines.
    pub eye: Eye,
    /// Whether warnings are kept back.
    pub quiet: bool,
}

impl Loader<'_> {
    /// As [`load`]; `trial` are the settings of a picture that shows whether the scene is dark.
    pub fn load(
        &self,
        exposure: Option<f32>,
        trial: impl Fn(&LoadedScene) -> Settings,
    ) -> Result<Animation, Failure> {
        let Source { scene: path, light, strict, sky } = self.source;
        let mut options = Options { strict: *strict, light: *light, eye: self.eye, ..Options::default() };
        if let Some(file) = sky {
            return self.under_sky(options, file);
        }
        let open = |options: &Options| {
            let animation = Animation::open(path, options).map_err(bad)?;
            animation.scene().require_light().map(|()| animation).map_err(bad)
        };
        let mut animation = open(&options)?;
        let mut dark = None;
        if *light == LightChoice::Auto && !animation.scene().has_lamp {
            let scene = animation.scene();
            if probe::is_dark(scene, &trial(scene), exposure.unwrap_or(scene.exposure)).map_err(blame)? {
                let why = format!("{}: its own light leaves the picture nearly black", path.display());
                if animation.scene().is_bare() {
                    options.light = LightChoice::Sky;
                    animation = open(&options)?;
                    dark = Some(format!("{why}: {LAST_RESORT} is added (--light own: without)"));
                } else {
                    dark = Some(format!("{why}: --light sky adds {LAST_RESORT}"));
                }
            }
        }
        self.warn(animation.scene().warnings.iter().chain(&dark));
        Ok(animation)
    }

    /// Loads a scene under the sky of a file.
    fn under_sky(&self, mut options: Options, file: &Path) -> Result<Animation, Failure> {
        if options.light == LightChoice::Auto {
            options.light = LightChoice::Own;
        }
        let (sky, warnings) = SkyMap::load(file).map_err(bad)?;
        let animation = Animation::open(&self.source.scene, &options).map_err(bad)?.under(sky);
        self.warn(animation.scene().warnings.iter().chain(&warnings));
        Ok(animation)
    }

    fn warn<'a>(&self, warnings: impl Iterator<Item = &'a String>) {
        if !self.quiet {
            warnings.for_each(|warning| eprintln!("warning: {warning}"));
        }
    }
}

/// What lights a scene that nothing else does.
const LAST_RESORT: &str = "a soft sky and a key light, in a room a lamp by the camera,";
