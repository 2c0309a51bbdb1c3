//! The command `error`: a picture against a reference.

use super::arguments::Measure;
use super::common::{Failure, bad, print_json, say};
use super::print::Compared;
use pmcip::picture::frame_io::{self, Picture};
use pmcip::picture::metrics;

/// Luminance of radiance 1 in cd/m², for images that do not say.
const DEFAULT_CD_PER_UNIT: f64 = 100.0;

pub fn measure(arguments: &Measure) -> Result<(), Failure> {
    let [image, reference] = [&arguments.image, &arguments.reference].map(|path| frame_io::read_exr(path));
    let (image, reference) = (image.map_err(bad)?, reference.map_err(bad)?);
    let cd_per_unit = cd_per_unit(&reference).or(cd_per_unit(&image)).unwrap_or(DEFAULT_CD_PER_UNIT);
    let metrics = metrics::measure(&image, &reference, cd_per_unit).map_err(bad)?;
    let report = Compared { cd_per_unit, metrics };
    if arguments.json {
        print_json(&report)
    } else {
        say(&report.to_string())
    }
    Ok(())
}

fn cd_per_unit(picture: &Picture) -> Option<f64> {
    picture.attributes.get("cd_per_unit")?.parse().ok().filter(|cd: &f64| cd.is_finite() && *cd > 0.0)
}
