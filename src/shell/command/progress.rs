//! A progress bar on a terminal, nothing elsewhere.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::fmt::Write;

/// A bar for frames of `pixels` pixels with `spp` samples in each of them in all, none if nobody knows how many; silent if
/// `quiet` or not on a terminal.
pub fn bar(pixels: u64, spp: Option<u64>, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let rate = move |state: &ProgressState, out: &mut dyn Write| {
        // A terminal that cannot be written to has nobody to tell.
        let _ = write!(out, "{:.1} spp/s", state.per_sec() / pixels as f64);
    };
    let template = match spp {
        Some(_) => "{bar:40} {percent:>3} %  {rate}  {eta} left  {msg}",
        None => "{spinner} {elapsed}  {rate}  {msg}",
    };
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::with_draw_target(spp.map(|spp| pixels * spp), ProgressDrawTarget::stderr());
    bar.with_style(style.with_key("rate", rate))
}
