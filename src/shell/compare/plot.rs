//! Log-log plots with error bars, as SVG to put into a page.

use crate::error::Error;
use plotters::prelude::*;

/// Width and height of a plot, in pixels of the page.
const SIZE: (u32, u32) = (560, 400);
/// The face of all text.
const FACE: &str = "sans-serif";

/// A point with the standard error of its height.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// To the right.
    pub x: f64,
    /// Upwards.
    pub y: f64,
    /// Half the length of its bar; 0 for none.
    pub error: f64,
}

/// The measurements of one method.
#[derive(Clone, Debug)]
pub struct Line {
    /// Its colour.
    pub colour: (u8, u8, u8),
    /// From left to right.
    pub points: Vec<Point>,
}

/// Colours that people with any kind of colour vision tell apart (Okabe and Ito 2008), the baseline's grey first.
pub fn colour(method: usize) -> (u8, u8, u8) {
    const COLOURS: [(u8, u8, u8); 7] = [
        (110, 110, 110),
        (213, 94, 0),
        (0, 114, 178),
        (0, 158, 115),
        (204, 121, 167),
        (230, 159, 0),
        (86, 180, 233),
    ];
    COLOURS[method % COLOURS.len()]
}

/// Draws `lines`, leaving out points that logarithms cannot place.
///
/// # Errors
/// [`Error::Work`] if the drawing fails.
pub fn svg(title: &str, x_title: &str, lines: &[Line]) -> Result<String, Error> {
    let mut text = String::new();
    draw(&mut text, title, x_title, &placeable(lines))
        .map_err(|reason| Error::Work(format!("cannot draw a plot: {reason}")))?;
    Ok(text)
}

fn placeable(lines: &[Line]) -> Vec<Line> {
    let fits = |p: &Point| p.x > 0.0 && p.y > 0.0 && p.x.is_finite() && p.y.is_finite();
    lines
        .iter()
        .map(|line| Line { points: line.points.iter().copied().filter(fits).collect(), ..*line })
        .collect()
}

/// From the lowest value to the highest, with a margin; something sensible if there is none.
fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
    if low <= high { low / 1.3..high * 1.3 } else { 0.1..10.0 }
}

fn draw(
    text: &mut String,
    title: &str,
    x_title: &str,
    lines: &[Line],
) -> Result<(), Box<dyn std::error::Error>> {
    let points = || lines.iter().flat_map(|line| &line.points);
    let (x_range, y_range) = (range(points().map(|p| p.x)), range(points().map(|p| p.y)));
    let root = SVGBackend::with_string(text, SIZE).into_drawing_area();
    let mut chart = ChartBuilder::on(&root)
        .caption(title, (FACE, 19))
        .margin_right(16)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d(x_range.log_scale(), y_range.clone().log_scale())?;
    chart
        .configure_mesh()
        .x_desc(x_title)
        .axis_desc_style((FACE, 14))
        .label_style((FACE, 13))
        .x_label_formatter(&|value| plain(*value))
        .y_label_formatter(&|value| format!("{value:.0e}"))
        .bold_line_style(RGBColor(205, 205, 205))
        .light_line_style(RGBColor(236, 236, 236))
        .axis_style(RGBColor(90, 90, 90))
        .draw()?;
    for line in lines {
        let colour = RGBColor(line.colour.0, line.colour.1, line.colour.2);
        let places: Vec<(f64, f64)> = line.points.iter().map(|p| (p.x, p.y)).collect();
        chart.draw_series(LineSeries::new(places.iter().copied(), colour.stroke_width(2)))?;
        chart.draw_series(places.iter().map(|place| Circle::new(*place, 4, colour.filled())))?;
        let bars = line.points.iter().filter(|p| p.error > 0.0).map(|p| {
            let low = (p.y - p.error).max(y_range.start);
            ErrorBar::new_vertical(p.x, low, p.y, p.y + p.error, colour.stroke_width(1), 9)
        });
        chart.draw_series(bars)?;
    }
    root.present()?;
    Ok(())
}

/// A number without digits that say nothing.
fn plain(value: f64) -> String {
    let digits = (-value.log10().floor()).max(0.0) as usize;
    format!("{value:.digits$}")
}
