//! What the commands print: the same facts as words and as JSON.

use pmcip::frame::photons::Shot;
use pmcip::frame::render::Frame;
use pmcip::frame::settings::{Settings, word};
use pmcip::picture::metrics::{Metrics, luminance};
use pmcip::scene::LoadedScene;
use serde::{Serialize, Serializer};
use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

/// A finished render.
#[derive(Debug, Serialize)]
pub struct Rendered<'a> {
    scene: &'a str,
    #[serde(serialize_with = "list")]
    settings: &'a Settings,
    threads: usize,
    seconds: f64,
    samples: u64,
    samples_per_second: f64,
    rejected: u64,
    estimated_relative_error: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    estimated_err: Option<f64>,
    spent_spp: f64,
    lane_occupancy: f64,
    #[serde(flatten)]
    photons: Option<Photons>,
    files: &'a [PathBuf],
    warnings: &'a [String],
}

impl<'a> Rendered<'a> {
    /// Collects the facts.
    pub fn new(scene: &'a LoadedScene, settings: &'a Settings, frame: &Frame, files: &'a [PathBuf]) -> Self {
        Rendered {
            scene: &scene.name,
            settings,
            threads: frame.threads,
            seconds: frame.seconds,
            samples: frame.tally.samples,
            samples_per_second: frame.tally.samples as f64 / frame.seconds,
            rejected: frame.tally.rejected,
            estimated_relative_error: relative_error(frame),
            estimated_err: frame.estimated_err,
            spent_spp: frame.spp(),
            lane_occupancy: frame.lane_occupancy,
            photons: frame.photons.map(Photons::from),
            files,
            warnings: &scene.warnings,
        }
    }
}

/// The photon maps of a frame.
#[derive(Debug, Serialize)]
struct Photons {
    global_photons: usize,
    caustic_photons: usize,
    photon_seconds: f64,
}

impl From<Shot> for Photons {
    fn from(shot: Shot) -> Photons {
        Photons { global_photons: shot.global, caustic_photons: shot.caustic, photon_seconds: shot.seconds }
    }
}

impl Display for Photons {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Photons { global_photons, caustic_photons, photon_seconds } = self;
        write!(
            f,
            "{photon_seconds:.2} s of them for {global_photons} photons and {caustic_photons} caustic ones"
        )
    }
}

/// The settings as an object of names and values.
fn list<S: Serializer>(settings: &&Settings, serializer: S) -> Result<S::Ok, S::Error> {
    settings.list().serialize(serializer)
}

/// Root mean square over pixels of the standard error over the luminance, as relMSE weighs dark pixels.
fn relative_error(frame: &Frame) -> f64 {
    let terms = frame.rgb.iter().zip(&frame.variance).map(|(&rgb, &variance)| {
        let value = luminance(rgb);
        f64::from(variance) / (value * value + 0.01)
    });
    (terms.sum::<f64>() / frame.rgb.len() as f64).sqrt()
}

impl Display for Rendered<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Settings { spp, iterations, method, sampler, .. } = self.settings;
        let (width, height, estimator) = (sampler.width, sampler.height, word(sampler.estimator));
        writeln!(
            f,
            "{}: {width}×{height} pixels, {}",
            self.scene,
            match (self.settings.grows(), self.settings.seconds) {
                (false, _) => format!("{spp} samples per pixel in {iterations} iterations"),
                (true, None) => format!("at most {spp} samples per pixel"),
                (true, Some(time)) => {
                    format!("{} samples per pixel in the {time} seconds that there were", self.spent_spp)
                }
            }
        )?;
        if let (Some(target), Some(err)) = (self.settings.target, self.estimated_err) {
            let (spent, aim) = (self.spent_spp, target.err);
            writeln!(f, "{spent} samples per pixel spent, estimated Err {err:.4} of {aim} asked for")?;
        }
        writeln!(f, "sampler {method}, estimator {estimator}, seed {}", sampler.seed)?;
        let rate = self.samples_per_second / 1e6;
        let (seconds, occupancy) = (self.seconds, 100.0 * self.lane_occupancy);
        write!(f, "{seconds:.2} s on {} threads, {rate:.2} million samples/s, ", self.threads)?;
        writeln!(f, "{occupancy:.0} % of the lanes in use")?;
        if let Some(photons) = &self.photons {
            writeln!(f, "{photons}")?;
        }
        let error = 100.0 * self.estimated_relative_error;
        writeln!(f, "estimated relative error {error:.2} % (RMS), {} samples rejected", self.rejected)?;
        let files: Vec<_> = self.files.iter().map(|file| file.display().to_string()).collect();
        writeln!(f, "wrote {}", files.join(" and "))
    }
}

/// An image measured against a reference.
#[derive(Debug, Serialize)]
pub struct Compared {
    /// Luminance of radiance 1 in cd/m².
    pub cd_per_unit: f64,
    /// The measures.
    #[serde(flatten)]
    pub metrics: Metrics,
}

impl Display for Compared {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let m = &self.metrics;
        let rows = [
            ("Err", m.err, "mean of e²/tvi, radiance 1 is"),
            ("low-pass Err", m.err_lowpass, "after an 8×8 box average"),
            ("MSE", m.mse, ""),
            ("trimmed", m.mse_trimmed, "without the worst 0.1 % of pixels"),
            ("relMSE", m.rel_mse, "mean of e²/(ref² + 0.01)"),
            ("trimmed", m.rel_mse_trimmed, "without the worst 0.1 % of pixels"),
        ];
        for (i, (name, value, note)) in rows.into_iter().enumerate() {
            let unit = if i == 0 { format!(" {} cd/m²", self.cd_per_unit) } else { String::new() };
            writeln!(f, "{}", format!("{name:<13} {value:<11.4e} {note}{unit}").trim_end())?;
        }
        let (bias, stderr) = (100.0 * m.energy_bias, 100.0 * m.energy_bias_stderr);
        writeln!(f, "energy bias   {bias:+.4} % ± {stderr:.4}")?;
        match m.oracle_ratio {
            Some(ratio) => writeln!(f, "oracle ratio  {ratio:<11.2} what known variances would gain in Err"),
            None => Ok(()),
        }
    }
}

/// What is in a scene.
#[derive(Debug, Serialize)]
pub struct Contents<'a> {
    scene: &'a str,
    triangles: usize,
    emitting_triangles: usize,
    materials: usize,
    textures: usize,
    nodes: usize,
    megabytes: f64,
    bounds: Option<[[f64; 3]; 2]>,
    width: u32,
    height: u32,
    cd_per_unit: f32,
    spp: Option<u32>,
    max_depth: Option<u32>,
    look_from: [f64; 3],
    look_at: [f64; 3],
    up: [f32; 3],
    fov: f32,
    /// Where light from outside comes from.
    sky: Option<&'a str>,
    warnings: Vec<String>,
}

impl<'a> Contents<'a> {
    /// Collects the facts.
    pub fn new(scene: &'a LoadedScene) -> Self {
        let no_light = scene.require_light().err().map(|error| error.to_string());
        Contents {
            scene: &scene.name,
            triangles: scene.triangles.len(),
            emitting_triangles: scene.lights.len(),
            materials: scene.materials.len(),
            textures: scene.textures.len(),
            nodes: scene.nodes.len(),
            megabytes: bytes(scene) as f64 / 1e6,
            bounds: bounds(scene).map(|corners| corners.map(|corner| in_file(scene, corner))),
            width: scene.width,
            height: scene.height,
            cd_per_unit: scene.cd_per_unit,
            spp: scene.spp,
            max_depth: scene.max_depth,
            look_from: in_file(scene, scene.view.from),
            look_at: in_file(scene, scene.view.at),
            up: scene.view.up,
            fov: scene.view.fov,
            sky: scene.sky.as_ref().map(|sky| &*sky.source),
            warnings: scene.warnings.iter().cloned().chain(no_light).collect(),
        }
    }
}

/// Bytes of the arrays that the core borrows.
fn bytes(scene: &LoadedScene) -> usize {
    let data = scene.data();
    size_of_val(data.nodes)
        + size_of_val(data.leaves)
        + size_of_val(data.triangles)
        + size_of_val(data.surfaces)
        + size_of_val(data.colours)
        + size_of_val(data.materials)
        + size_of_val(data.textures)
        + size_of_val(data.texels)
        + size_of_val(data.lights)
        + size_of_val(data.light_nodes)
        + data.sky.map_or(0, |sky| size_of_val(sky.texels) + size_of_val(sky.rows) + size_of_val(sky.cells))
}

/// Lower and upper corner of the box around all triangles.
fn bounds(scene: &LoadedScene) -> Option<[[f32; 3]; 2]> {
    let corners = scene.triangles.iter().flat_map(|triangle| triangle.corners);
    corners.map(|corner| [corner, corner]).reduce(|[low, high], [corner, _]| {
        let pick = |f: fn(f32, f32) -> f32, a: [f32; 3]| [0, 1, 2].map(|i| f(a[i], corner[i]));
        [pick(f32::min, low), pick(f32::max, high)]
    })
}

/// A point in the file's coordinates, in as few digits as it has in the scene's.
fn in_file(scene: &LoadedScene, point: [f32; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| point[i].to_string().parse().unwrap_or(f64::from(point[i])) + scene.origin[i])
}

fn point<T: Display>([x, y, z]: [T; 3]) -> String {
    format!("{x},{y},{z}")
}

impl Display for Contents<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}: {} triangles, {} of them shine",
            self.scene, self.triangles, self.emitting_triangles
        )?;
        writeln!(f, "{} materials, {} textures", self.materials, self.textures)?;
        writeln!(f, "{} nodes in the hierarchy, {:.1} MB in all", self.nodes, self.megabytes)?;
        if let Some([low, high]) = self.bounds {
            writeln!(f, "from {} to {}", point(low), point(high))?;
        }
        writeln!(f, "{}×{} pixels, radiance 1 is {} cd/m²", self.width, self.height, self.cd_per_unit)?;
        if let Some(sky) = self.sky {
            writeln!(f, "under a sky: {sky}")?;
        }
        let (from, at, up) = (point(self.look_from), point(self.look_at), point(self.up));
        writeln!(f, "camera --look-from {from} --look-at {at} --up {up} --fov {}", self.fov)?;
        self.warnings.iter().try_for_each(|warning| writeln!(f, "warning: {warning}"))
    }
}
