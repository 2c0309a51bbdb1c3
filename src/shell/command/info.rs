//! The command `info`: what is in a scene.

use super::arguments::Info;
use super::common::{Failure, bad, print_json, say};
use super::print::Contents;
use pmcip::scene;

pub fn info(arguments: &Info) -> Result<(), Failure> {
    let scene = scene::load(&arguments.scene).map_err(bad)?;
    let report = Contents::new(&scene);
    if arguments.json {
        print_json(&report)
    } else {
        say(&report.to_string())
    }
    Ok(())
}
