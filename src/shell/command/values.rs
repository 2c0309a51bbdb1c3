//! What options take, read from their text: the value, or what was expected.

use std::path::PathBuf;

/// How a render tells how far it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Form {
    /// A bar on stderr, if that is a terminal
    Bar,
    /// Lines on stderr, each a JSON object with "event": "progress"
    Json,
    /// Lines on stdout as queues that run Open Job Descriptions read them
    Openjd,
}

/// The name of an EXR file.
pub fn exr_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_exr = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
    if is_exr { Ok(path) } else { Err("the name must end in .exr".into()) }
}

/// The name of a picture of the sky.
pub fn sky_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_one = |e: &std::ffi::OsStr| e.eq_ignore_ascii_case("exr") || e.eq_ignore_ascii_case("hdr");
    if path.extension().is_some_and(is_one) {
        Ok(path)
    } else {
        Err("the name must end in .exr or .hdr".into())
    }
}

/// The name of a video.
pub fn mp4_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_mp4 = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mp4"));
    if is_mp4 { Ok(path) } else { Err("the name must end in .mp4".into()) }
}

/// Frames a second.
pub fn fps(text: &str) -> Result<f32, String> {
    let number = finite(text).ok().filter(|number| (0.01..=1000.0).contains(number));
    number.ok_or_else(|| "expected a number from 0.01 to 1000".into())
}

/// Columns and rows.
pub fn size(text: &str) -> Result<(u32, u32), String> {
    let numbers = text.split_once(['x', 'X', '×']).map(|(width, height)| (width.parse(), height.parse()));
    match numbers {
        Some((Ok(width @ 1..=pmcip::scene::MAX_SIZE), Ok(height @ 1..=pmcip::scene::MAX_SIZE))) => {
            Ok((width, height))
        }
        _ => Err(format!("expected WxH with numbers from 1 to {}, such as 640x480", pmcip::scene::MAX_SIZE)),
    }
}

/// Three numbers.
pub fn vector(text: &str) -> Result<[f32; 3], String> {
    point(text).map(|point| point.map(|v| v as f32))
}

/// Three numbers of double precision.
pub fn point(text: &str) -> Result<[f64; 3], String> {
    let number = |text: &str| text.trim().parse().ok().filter(|v: &f64| v.abs() <= f64::from(f32::MAX));
    let numbers: Vec<f64> = text.split(',').filter_map(number).collect();
    let wanted = "expected three numbers X,Y,Z, such as 0,1.5,-2";
    if text.split(',').count() == 3 {
        numbers.try_into().map_err(|_| wanted.into())
    } else {
        Err(wanted.into())
    }
}

/// Any number.
pub fn finite(text: &str) -> Result<f32, String> {
    let number = text.parse().ok().filter(|number: &f32| number.is_finite());
    number.ok_or_else(|| "expected a number".into())
}

/// A number above 0.
pub fn positive(text: &str) -> Result<f32, String> {
    let number = finite(text).ok().filter(|number| *number > 0.0);
    number.ok_or_else(|| "expected a number above 0".into())
}

/// A number of 0 or more.
pub fn not_negative(text: &str) -> Result<f32, String> {
    let number = finite(text).ok().filter(|number| *number >= 0.0);
    number.ok_or_else(|| "expected a number of 0 or more".into())
}

/// A power of weights.
pub fn gamma(text: &str) -> Result<f32, String> {
    let number = finite(text).ok().filter(|number| (0.0..=4.0).contains(number));
    number.ok_or_else(|| "expected a number from 0 to 4".into())
}

/// An angle of view in degrees.
pub fn fov(text: &str) -> Result<f32, String> {
    let number = finite(text).ok().filter(|number| *number > 0.0 && *number < 180.0);
    number.ok_or_else(|| "expected degrees between 0 and 180".into())
}

/// A number of threads.
pub fn threads(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|number| (1..=1024).contains(number));
    number.ok_or_else(|| "expected a number from 1 to 1024".into())
}
