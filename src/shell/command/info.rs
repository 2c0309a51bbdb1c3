//! The command `info`: what is in a scene.

use super::arguments::Info;
use super::common::{Failure, bad, print_json, say};
use super::print::Contents;
use pmcip::scene::{Animation, LightChoice, Options};

pub fn info(arguments: &Info) -> Result<(), Failure> {
    let options = Options { light: LightChoice::Own, strict: arguments.strict, ..Options::default() };
    let scene = Animation::open(&arguments.scene, &options).map_err(bad)?.into_scene();
    let report = Contents::new(&scene);
    if arguments.json {
        print_json(&report)
    } else {
        say(&report.to_string())
    }
    Ok(())
}
