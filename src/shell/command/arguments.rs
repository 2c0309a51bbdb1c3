//! The command line as data.

use super::layers::Wish;
use super::values::{
    Form, exr_path, finite, fov, fps, gamma, mp4_path, not_negative, point, positive, size, sky_path,
    threads, vector,
};
use clap::error::ErrorKind;
use clap::{Args, Parser, Subcommand, ValueEnum};
use pmcip::animation::sequence;
use pmcip::compare::{Other, Variant};
use pmcip::frame::settings::{
    DEFAULT_LIGHT_SAMPLES, DEFAULT_PHOTONS, Estimate, Integrator, MAX_DEPTH, MAX_LIGHT_SAMPLES, MAX_PHOTONS,
    Method, Startup,
};
use pmcip::scene::{LightChoice, MAX_SIZE};
use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::ExitCode;

/// Renders scenes with samples where the eye would see noise.
#[derive(Debug, Parser)]
#[command(name = "pmcip", version)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene, or frames of an animation, to EXR and PNG files
    Render(Box<Render>),
    /// Give a denoised picture the energy of the frame it was made of
    ///
    /// The frame needs the layer `unbiased`: render it with --layers unbiased, or with albedo,normal,unbiased for the
    /// denoiser's sake. What was denoised may be of any program, and of any quality: the result has the energy of the
    /// unbiased samples in every neighbourhood. It keeps the frame's other layers and its settings.
    #[command(verbatim_doc_comment)]
    Guide(Guide),
    /// Merge films of one frame that were rendered apart, with different seeds
    ///
    /// Each comes from `render --film --seed N`, with all other settings the same. Their picture is that of all samples, and as
    /// free of bias as each. The order of the films does not matter, to the bit. Beside OUT.exr and its PNG stands OUT.film,
    /// the merged film: it can be merged on, and `render --resume` with the settings of the first seed filters it (with
    /// --estimator guided, which needs the scene).
    #[command(verbatim_doc_comment)]
    Merge(Merge),
    /// Print a render as the tasks of a queue: a script for Slurm, or an Open Job Description
    ///
    /// An animation is divided into chunks of frames, one frame into films of different seeds, which `merge` puts together.
    /// A task that is killed goes on where it was when it is queued again. For any other queue: each task is one
    /// `render --frames LIST`, or one `render --film --seed N`, with --resume and --checkpoint.
    #[command(verbatim_doc_comment)]
    Farm(Farm),
    /// Bake the light that falls on a scene's surfaces into a lightmap
    ///
    /// Surfaces are laid out anew, unless a glTF file's second texture coordinates can be used: inside 0 to 1, no two places on
    /// one another. Beside LIGHTMAP.exr (irradiance, `mask`, `count`) and its PNG stands LIGHTMAP.obj, whose texture coordinates
    /// belong to it. Only fronts are baked, and nothing that mirrors or refracts.
    #[command(verbatim_doc_comment)]
    Bake(Bake),
    /// Render a reference: uniform samples, EXR only, with the variance of every pixel
    Reference(Reference),
    /// Measure methods against each other: error against time and samples, as a page, JSON and CSV
    Compare(Box<Compare>),
    /// Measure the error of an image against a reference
    Error(Measure),
    /// Say what is in a scene
    Info(Info),
}

/// Arguments of `render`.
#[derive(Debug, Args)]
pub struct Render {
    #[command(flatten)]
    pub common: Common,
    /// EXR file to write, with a PNG beside it [default: the scene's name, in the current folder]
    #[arg(short, long, value_name = "OUT.exr", value_parser = exr_path)]
    pub output: Option<PathBuf>,
    /// Samples per pixel on average [default: the scene's, or 64]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    /// Rounds of sampling and adapting, the first one uniform [default: one for each 2 spp, at most 16]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub iterations: Option<u32>,
    /// Where samples go: adaptive (pmc), everywhere the same (uniform), or as first published (paper)
    #[arg(long, value_enum, default_value = "pmc")]
    pub sampler: Method,
    /// How samples become pixels [default: balanced for pmc, else pooled]
    #[arg(long, value_enum)]
    pub estimator: Option<Estimate>,
    /// Power of the kernel's weights: 0 is uniform, 1/2 least error, 1 evenest error [default: the sampler's]
    #[arg(long, value_name = "G", value_parser = gamma, allow_negative_numbers = true)]
    pub gamma: Option<f32>,
    /// Brightness of the PNG in stops: each doubles it [default: the scene's, or 0]
    #[arg(long, value_name = "EV", allow_hyphen_values = true, value_parser = finite)]
    pub exposure: Option<f32>,
    /// Layers of the EXR file beside the picture, one or more
    #[arg(
        long,
        value_enum,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "variance,count,kernel"
    )]
    pub layers: Vec<Wish>,
    /// Estimated perceptual error (Err) below which a frame ends, with --spp samples per pixel at most
    #[arg(long, value_name = "E", value_parser = positive, allow_negative_numbers = true, conflicts_with = "iterations")]
    pub target_err: Option<f32>,
    /// Seconds that a frame may take, with --spp samples per pixel at most [default of that: none]
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_negative_numbers = true, conflicts_with = "iterations")]
    pub time: Option<f32>,
    /// Write what there is of a frame every so many seconds, beside it as NAME.film; --resume goes on from that
    #[arg(long, value_name = "SECONDS", value_parser = not_negative, allow_negative_numbers = true)]
    pub checkpoint: Option<f32>,
    /// Go on from NAME.film, if there is one: what --checkpoint or an interrupt (Ctrl-C) have left
    #[arg(long)]
    pub resume: bool,
    /// Show the picture while it is rendered in the viewer that listens there: tev, or what speaks its protocol (tev: 14158)
    #[arg(long, value_name = "HOST:PORT")]
    pub live: Option<String>,
    /// Write the film, too, as NAME.film: what `pmcip merge` takes
    #[arg(long)]
    pub film: bool,
    /// Frames of an animation: A..B, first and last included, an open end being the scene's, or a list of numbers and
    /// ranges such as 2,4,10-20
    ///
    /// Frame 7 goes to NAME.0007.exr and NAME.0007.png. Frames that are there already, made with the same settings
    /// of the same scene, are kept: an interrupted run goes on where it stopped. Frames made otherwise are an error.
    #[arg(long, value_name = "A..B", verbatim_doc_comment)]
    pub frames: Option<sequence::List>,
    /// List those of the frames that are not on disk, or are damaged, and render nothing
    #[arg(long, requires = "frames")]
    pub missing: bool,
    /// What a frame starts from that follows another one
    #[arg(long, value_enum, value_name = "START", default_value = "uniform", requires = "frames")]
    pub startup: Startup,
    /// Blend filtered frames with those before them (with --estimator guided): less flicker
    #[arg(long, requires = "frames")]
    pub history: bool,
    /// Overwrite frames that were made with other settings
    #[arg(long, requires = "frames")]
    pub overwrite: bool,
    /// Video of the frames to make with ffmpeg, if that is installed (H.264)
    #[arg(long, value_name = "OUT.mp4", value_parser = mp4_path, requires = "frames")]
    pub video: Option<PathBuf>,
    /// Frames a second of the video [default: the scene's, or 24]
    #[arg(long, value_name = "N", value_parser = fps, requires = "video")]
    pub fps: Option<f32>,
    /// Print one JSON object instead of words; with --frames one line for each frame
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub watch: Watch,
}

/// Arguments of `guide`.
#[derive(Debug, Args)]
pub struct Guide {
    /// Frame of `render` with the layer `unbiased`
    #[arg(value_name = "FRAME.exr")]
    pub frame: PathBuf,
    /// Picture that was made of it, of the same size
    #[arg(long, value_name = "DENOISED.exr")]
    pub with: PathBuf,
    /// EXR file to write, with a PNG beside it
    #[arg(short, long, value_name = "OUT.exr", value_parser = exr_path)]
    pub output: PathBuf,
    /// Brightness of the PNG in stops: each doubles it
    #[arg(long, value_name = "EV", allow_hyphen_values = true, value_parser = finite, default_value_t = 0.0)]
    pub exposure: f32,
    /// Print one JSON object instead of words
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `merge`.
#[derive(Debug, Args)]
pub struct Merge {
    /// Film files of `render --film` or `merge`
    #[arg(value_name = "FILM", required = true)]
    pub films: Vec<PathBuf>,
    /// EXR file to write, with a PNG and the merged film beside it
    #[arg(short, long, value_name = "OUT.exr", value_parser = exr_path)]
    pub output: PathBuf,
    /// Brightness of the PNG in stops: each doubles it
    #[arg(long, value_name = "EV", allow_hyphen_values = true, value_parser = finite, default_value_t = 0.0)]
    pub exposure: f32,
    /// Print one JSON object instead of words
    #[arg(long)]
    pub json: bool,
}

/// A queue of jobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Queue {
    /// A job array, for sbatch
    Slurm,
    /// An Open Job Description template (2023-09)
    Openjd,
}

/// Arguments of `farm`.
#[derive(Debug, Args)]
pub struct Farm {
    /// The queue
    #[arg(value_enum)]
    pub queue: Queue,
    /// Frames of a task
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), default_value_t = 10)]
    pub chunk: u32,
    /// Films of one frame, each with a seed of its own
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub seeds: Option<u32>,
    /// Seconds between the checkpoints of a task
    #[arg(long, value_name = "SECONDS", value_parser = not_negative, allow_negative_numbers = true, default_value_t = 300.0)]
    pub checkpoint: f32,
    /// The render, after `--`: render SCENE …
    #[arg(last = true, required = true, value_name = "render SCENE …")]
    pub render: Vec<String>,
}

/// Arguments of `bake`.
#[derive(Debug, Args)]
pub struct Bake {
    #[command(flatten)]
    pub source: Source,
    /// EXR file to write, with a PNG and an OBJ beside it
    #[arg(short, long, value_name = "LIGHTMAP.exr", value_parser = exr_path)]
    pub output: PathBuf,
    /// Texels a side [default: 1024, or with --texels-per-unit as many as that takes]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SIZE)))]
    pub size: Option<u32>,
    /// Texels per scene unit [default: as many as fit]
    #[arg(long, value_name = "T", value_parser = positive, allow_negative_numbers = true)]
    pub texels_per_unit: Option<f32>,
    /// Samples per texel in use, on average [default: the scene's, or 64]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    /// Where samples go: adaptive (pmc), everywhere the same (uniform), or as first published (paper)
    #[arg(long, value_enum, default_value = "pmc")]
    pub sampler: Method,
    /// How samples become texels [default: guided for pmc, else pooled]
    #[arg(long, value_enum)]
    pub estimator: Option<Estimate>,
    /// Longest path in segments, counted as if the texel were seen: 2 is direct light only [default: the scene's, or 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_DEPTH)))]
    pub max_depth: Option<u32>,
    /// Number that picks the random points: the same seed makes the same lightmap
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    pub seed: u32,
    /// Threads to work with [default: all]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,
    /// Also render what the scene's camera sees, lit by the lightmap and beside it by the path tracer, to LIGHTMAP.check.png
    #[arg(long)]
    pub check: bool,
    /// Brightness of PNGs in stops: each doubles it [default: the scene's, or 0]
    #[arg(long, value_name = "EV", allow_hyphen_values = true, value_parser = finite)]
    pub exposure: Option<f32>,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
    /// Print one JSON object instead of words
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub watch: Watch,
}

/// Arguments of `reference`.
#[derive(Debug, Args)]
pub struct Reference {
    #[command(flatten)]
    pub common: Common,
    /// Samples per pixel
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,
    /// EXR file to write
    #[arg(short, long, value_name = "REF.exr", value_parser = exr_path)]
    pub output: PathBuf,
    /// Print one JSON object instead of words
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub watch: Watch,
}

/// How what takes long is watched.
#[derive(Debug, Args)]
pub struct Watch {
    /// How to tell how far the work is [default: bar, or json with --json where stderr is no terminal]
    ///
    /// A line of JSON has "event": "progress", the number of the frame (of `render --frames`), `done` of the whole work (0 to
    /// 1), `samples` and `spp` of this frame, `seconds`, `seconds_left` and `estimated_err`, which are null as long as they are
    /// not known: at each frame's begin and end, and at most once a second. What is estimated is what --target-err means, now
    /// and then, and of pictures up to 8 megapixels, by `render` and `reference`. The whole of `bake` are the samples of the
    /// lightmap, that of `compare` those of the reference and all methods together.
    #[arg(long, value_enum, value_name = "FORM", conflicts_with = "quiet", verbatim_doc_comment)]
    pub progress: Option<Form>,
}

impl Watch {
    /// How the work tells how far it is: where nobody says, in lines for programs if the result is for them and stderr is read by
    /// no person.
    pub fn form(&self, json: bool, quiet: bool) -> Option<Form> {
        let is_for_programs = json && !std::io::stderr().is_terminal();
        match (self.progress, quiet) {
            (None, true) => None,
            (None, false) if is_for_programs => Some(Form::Json),
            (chosen, _) => chosen.or(Some(Form::Bar)),
        }
    }
}

/// A scene and its light.
#[derive(Debug, Args)]
pub struct Source {
    /// Scene file (.toml), or a bare .obj, .gltf or .glb
    pub scene: PathBuf,
    /// What lights the scene
    #[arg(long, value_enum, default_value = "auto")]
    pub light: LightChoice,
    /// Picture of the sky instead of the scene's: equirectangular, +y up, +z in the middle
    #[arg(long, value_name = "FILE.exr|.hdr", value_parser = sky_path)]
    pub sky: Option<PathBuf>,
    /// Refuse mesh and material files with lines that mean nothing, instead of leaving these out
    #[arg(long)]
    pub strict: bool,
}

/// Arguments that every render takes.
#[derive(Debug, Args)]
pub struct Common {
    #[command(flatten)]
    pub source: Source,
    /// How light is followed
    #[arg(long, value_enum, default_value = "path")]
    pub integrator: IntegratorName,
    /// Points on lights that direct lighting aims at for each pixel sample [default: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_LIGHT_SAMPLES)))]
    pub light_samples: Option<u32>,
    /// Directions that direct lighting draws from the surface's scattering for each pixel sample: more of them help
    /// where polished surfaces reflect large lights [default: as many as light samples]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_LIGHT_SAMPLES)))]
    pub bsdf_samples: Option<u32>,
    /// Photon paths that gather shoots for a frame; more of them blur less [default: 200000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_PHOTONS)))]
    pub photons: Option<u32>,
    /// Longest path in segments, counted from the eye: 2 is direct light only [default: the scene's, or 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_DEPTH)))]
    pub max_depth: Option<u32>,
    /// Image size in pixels [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(u32, u32)>,
    /// Number that picks the random points: the same seed makes the same picture
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    pub seed: u32,
    /// Threads to work with [default: all]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,
    /// Eye position in scene units
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub look_from: Option<[f64; 3]>,
    /// Point in the middle of the image, in scene units
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub look_at: Option<[f64; 3]>,
    /// Direction that points up in the image
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    pub up: Option<[f32; 3]>,
    /// Vertical field of view in degrees, between 0 and 180
    #[arg(long, value_name = "DEG", value_parser = fov, allow_negative_numbers = true)]
    pub fov: Option<f32>,
    /// Diameter of the lens in scene units: 0 is a pinhole, by which everything is sharp [default: the scene's, or 0]
    #[arg(long, value_name = "D", value_parser = not_negative, allow_negative_numbers = true)]
    pub aperture: Option<f32>,
    /// Distance along the view at which the picture is sharp [default: the scene's, or that of --look-at]
    #[arg(long, value_name = "D", value_parser = positive, allow_negative_numbers = true)]
    pub focus: Option<f32>,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
}

/// Arguments of `compare`.
#[derive(Debug, Args)]
pub struct Compare {
    #[command(flatten)]
    pub common: Common,
    /// Folder for report.html, report.json, report.csv and the reference; made if it is not there
    #[arg(short, long, value_name = "REPORT_DIR")]
    pub output: PathBuf,
    /// Samples per pixel on average, one or more
    #[arg(long, value_name = "N,N,…", value_delimiter = ',', default_value = "4,8,16,32,64",
          value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Vec<u32>,
    /// Methods beside uniform: pmc, paper, or one of them with changes, as pmc:pooled or pmc:gamma=0.5+pooled
    #[arg(long, value_name = "NAME,NAME,…", value_delimiter = ',', default_value = "uniform,paper,pmc")]
    pub methods: Vec<Variant>,
    /// Picture of another program and the seconds it took, measured beside the methods; may be repeated
    #[arg(long = "other", value_name = "NAME=A.exr:SECONDS", conflicts_with = "frames")]
    pub others: Vec<Other>,
    /// Renders of each method at each sample count, all with different seeds
    #[arg(long, value_name = "R", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub runs: u32,
    /// Frames of an animation, first and last included: adds flicker and curves over frames
    #[arg(long, value_name = "A..B")]
    pub frames: Option<sequence::Range>,
    /// What a frame starts from that follows another one, where the method does not say
    #[arg(long, value_enum, value_name = "START", default_value = "uniform", requires = "frames")]
    pub startup: Startup,
    /// Image to judge by [default: rendered, and kept in the folder]; of frames the name without number
    #[arg(long, value_name = "REF.exr", conflicts_with = "reference_spp")]
    pub reference: Option<PathBuf>,
    /// Samples per pixel of the rendered reference
    #[arg(long, value_name = "N", default_value_t = 4096, value_parser = clap::value_parser!(u32).range(1..))]
    pub reference_spp: u32,
    /// Print the report as JSON instead of the table of ratios
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub watch: Watch,
}

/// Arguments of `error`.
#[derive(Debug, Args)]
pub struct Measure {
    /// Image to judge
    #[arg(value_name = "IMAGE.exr")]
    pub image: PathBuf,
    /// Image to judge by, of the same size
    #[arg(value_name = "REF.exr")]
    pub reference: PathBuf,
    /// Print one JSON object instead of words
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `info`.
#[derive(Debug, Args)]
pub struct Info {
    /// Scene file (.toml), or a bare .obj, .gltf or .glb
    pub scene: PathBuf,
    /// Refuse mesh and material files with lines that mean nothing, instead of leaving these out
    #[arg(long)]
    pub strict: bool,
    /// Print one JSON object instead of words
    #[arg(long)]
    pub json: bool,
}

/// How light is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum IntegratorName {
    /// Path tracing with next-event estimation
    Path,
    /// Direct lighting with multiple importance sampling, also through mirrors and glass
    Direct,
    /// Photon mapping with final gathering and a caustic map: less noise where light is indirect, but biased
    Gather,
}

impl Common {
    /// The integrator with its own options.
    ///
    /// # Errors
    /// If an option is given that belongs to another integrator.
    pub fn integrator(&self) -> Result<Integrator, String> {
        if self.integrator != IntegratorName::Direct {
            reject(self.light_samples, "--light-samples", "direct")?;
            reject(self.bsdf_samples, "--bsdf-samples", "direct")?;
        }
        if self.integrator != IntegratorName::Gather {
            reject(self.photons, "--photons", "gather")?;
        }
        Ok(match self.integrator {
            IntegratorName::Path => Integrator::Path,
            IntegratorName::Direct => {
                let light_samples = self.light_samples.unwrap_or(DEFAULT_LIGHT_SAMPLES);
                let bsdf_samples = self.bsdf_samples.unwrap_or(light_samples);
                Integrator::Direct { light_samples, bsdf_samples }
            }
            IntegratorName::Gather => {
                let photons = self.photons.unwrap_or(DEFAULT_PHOTONS);
                Integrator::Gather { photons, photon_seed: self.seed }
            }
        })
    }
}

/// Refuses an option that would have no effect.
fn reject<T>(given: Option<T>, option: &str, integrator: &str) -> Result<(), String> {
    match given {
        None => Ok(()),
        Some(_) => Err(format!("{option} needs --integrator {integrator}")),
    }
}

/// Prints help, or a refusal in one line, and picks the exit code.
pub fn refuse(refusal: &clap::Error) -> ExitCode {
    use ErrorKind::{DisplayHelp, DisplayHelpOnMissingArgumentOrSubcommand, DisplayVersion};
    match refusal.kind() {
        DisplayHelp | DisplayVersion | DisplayHelpOnMissingArgumentOrSubcommand => {
            // Whoever closed the stream does not want to read it.
            let _ = refusal.print();
        }
        _ => {
            let text = refusal.to_string();
            let sentence = text.split("\n\n").next().unwrap_or_default();
            eprintln!("{}", sentence.split_whitespace().collect::<Vec<_>>().join(" "));
        }
    }
    ExitCode::from(refusal.exit_code() as u8)
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        super::Arguments::command().debug_assert();
    }
}
