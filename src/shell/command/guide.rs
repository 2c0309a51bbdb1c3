//! The command `guide`: a denoised picture with the energy of the frame it was made of.

use super::arguments::Guide;
use super::common::{Failure, bad, blame, failed, print_json, say};
use pmcip::frame::restore::{Restored, Source, restore};
use pmcip::picture::{frame_io, output};
use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::path::Path;

/// What was done.
#[derive(Serialize)]
struct Report<'a> {
    frame: &'a Path,
    with: &'a Path,
    /// Mean luminance of the frame's layer `unbiased`.
    energy: f64,
    /// How far the energies were off, over that.
    energy_bias_before: f64,
    energy_bias_after: f64,
    files: [&'a Path; 2],
}

pub fn guide_picture(arguments: &Guide) -> Result<(), Failure> {
    let Guide { frame: frame_file, with, output: exr, .. } = arguments;
    let png = exr.with_extension("png");
    [exr, &png].into_iter().try_for_each(|path| output::check(path)).map_err(bad)?;
    [frame_file, with].into_iter().try_for_each(|input| differ(input, exr))?;
    let mut frame = frame_io::read_exr(frame_file).map_err(bad)?;
    let denoised = frame_io::read_exr(with).map_err(bad)?;
    let source = Source { path: frame_file, picture: &frame };
    let Restored { rgb, energy, bias_before, bias_after } =
        restore(source, Source { path: with, picture: &denoised }).map_err(blame)?;
    frame.rgb = rgb;
    frame.attributes.insert("guided_by".into(), with.display().to_string());
    frame_io::write_png(&png, &frame, arguments.exposure).map_err(failed)?;
    frame_io::write_exr(exr, &frame).map_err(failed)?;
    let report = Report {
        frame: frame_file,
        with,
        energy,
        energy_bias_before: bias_before,
        energy_bias_after: bias_after,
        files: [exr, &png],
    };
    if arguments.json {
        print_json(&report)
    } else {
        say(&report.to_string())
    }
    Ok(())
}

/// Makes sure that `input` is not lost under the output.
fn differ(input: &Path, output: &Path) -> Result<(), Failure> {
    let same = match (input.canonicalize(), output.canonicalize()) {
        (Ok(input), Ok(output)) => input == output,
        _ => false,
    };
    if same { Err(bad(format!("{} would be overwritten: give another -o", input.display()))) } else { Ok(()) }
}

impl Display for Report<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let [exr, png] = self.files.map(Path::display);
        writeln!(f, "mean luminance of the unbiased picture {:.6}", self.energy)?;
        let (before, after) = (100.0 * self.energy_bias_before, 100.0 * self.energy_bias_after);
        writeln!(f, "{} had {before:+.4} %, has {after:+.4} % now", self.with.display())?;
        writeln!(f, "wrote {exr} and {png}")
    }
}
