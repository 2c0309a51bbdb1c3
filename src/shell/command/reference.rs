//! The command `reference`: a picture that others are measured against.

use super::arguments::Reference;
use super::common::{Failure, admit, bad, failed, print, settings, work};
use super::load::load;
use super::print::Rendered;
use pmcip::frame::settings::Method;
use pmcip::picture::{frame_io, output};

pub fn render_reference(arguments: &Reference) -> Result<(), Failure> {
    let scene = load(&arguments.common, None)?.into_scene();
    output::check(&arguments.output).map_err(bad)?;
    let settings = settings(&scene, &arguments.common, Method::Uniform, Some(arguments.spp))?;
    let frame = work(
        &scene,
        &settings,
        &arguments.common,
        arguments.watch.form(arguments.json, arguments.common.quiet),
    )?;
    frame_io::write_exr(&arguments.output, &frame.picture(&settings, &scene)).map_err(failed)?;
    let report = Rendered::new(&scene, &settings, &frame, std::slice::from_ref(&arguments.output));
    print(&arguments.common, arguments.json, &report);
    admit(arguments.common.quiet, frame.tally)
}
