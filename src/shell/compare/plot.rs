//! Plots with error bars, logarithmic upwards, as SVG to put into a page.

use super::digits::significant;
use crate::error::Error;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;
use std::ops::Range;

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

/// What runs to the right.
#[derive(Clone, Debug)]
pub struct Axis {
    /// What it is.
    pub title: &'static str,
    /// How its numbers are spaced.
    pub scale: Spacing,
}

/// How an axis is spaced.
#[derive(Clone, Debug)]
pub enum Spacing {
    /// Logarithmic, labelled at these numbers or else at round ones.
    Logarithmic(Option<Vec<f64>>),
    /// Even.
    Even,
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
pub fn svg(title: &str, axis: &Axis, lines: &[Line]) -> Result<String, Error> {
    let mut text = String::new();
    draw(&mut text, title, axis, &placeable(axis, lines))
        .map_err(|reason| Error::Work(format!("cannot draw a plot: {reason}")))?;
    Ok(text)
}

fn placeable(axis: &Axis, lines: &[Line]) -> Vec<Line> {
    let above = |x: f64| x > 0.0 || matches!(axis.scale, Spacing::Even);
    let fits = |p: &Point| above(p.x) && p.y > 0.0 && p.x.is_finite() && p.y.is_finite();
    lines
        .iter()
        .map(|line| Line { points: line.points.iter().copied().filter(fits).collect(), ..*line })
        .collect()
}

/// From the lowest value to the highest, with a margin; something sensible if there is none.
fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
    if low <= high { low / 1.25..high * 1.25 } else { 0.1..10.0 }
}

/// Round numbers in a range: 1, 2 and 5 times powers of ten, or the powers alone where those are many.
fn round_numbers(range: &Range<f64>) -> Vec<f64> {
    let decades = range.start.log10().floor() as i32..=range.end.log10().ceil() as i32;
    let steps: &[f64] = if (range.end / range.start).log10() < 3.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let numbers = decades.flat_map(|decade| steps.iter().map(move |step| step * 10.0_f64.powi(decade)));
    numbers.filter(|number| range.contains(number)).collect()
}

fn draw(
    text: &mut String,
    title: &str,
    axis: &Axis,
    lines: &[Line],
) -> Result<(), Box<dyn std::error::Error>> {
    let x = || lines.iter().flat_map(|line| &line.points).map(|p| p.x);
    match &axis.scale {
        Spacing::Logarithmic(ticks) => {
            let range = range(x());
            let ticks = ticks.clone().unwrap_or_else(|| round_numbers(&range));
            draw_over(text, title, axis, lines, range.log_scale().with_key_points(ticks))
        }
        Spacing::Even => {
            let (low, high) = x().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
            let range = if low < high { low..high } else { 0.0..1.0 };
            draw_over(text, title, axis, lines, range)
        }
    }
}

/// Draws over the horizontal coordinate `x`.
fn draw_over<X>(
    text: &mut String,
    title: &str,
    axis: &Axis,
    lines: &[Line],
    x: X,
) -> Result<(), Box<dyn std::error::Error>>
where
    X: AsRangedCoord<Value = f64>,
    X::CoordDescType: ValueFormatter<f64>,
{
    let y_range = range(lines.iter().flat_map(|line| &line.points).flat_map(|p| [p.y, p.y + p.error]));
    let y_ticks = round_numbers(&y_range);
    let floor = y_range.start;
    let even = matches!(axis.scale, Spacing::Even);
    let root = SVGBackend::with_string(text, SIZE).into_drawing_area();
    let mut chart = ChartBuilder::on(&root)
        .caption(title, (FACE, 19))
        .margin_right(16)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d(x, y_range.log_scale().with_key_points(y_ticks))?;
    chart
        .configure_mesh()
        .x_desc(axis.title)
        .axis_desc_style((FACE, 16))
        .label_style((FACE, 15))
        .x_label_formatter(&|value| if even { value.to_string() } else { significant(*value, 1) })
        .y_label_formatter(&|value| significant(*value, 1))
        .bold_line_style(RGBColor(222, 222, 222))
        .light_line_style(TRANSPARENT)
        .axis_style(RGBColor(90, 90, 90))
        .draw()?;
    for line in lines {
        let colour = RGBColor(line.colour.0, line.colour.1, line.colour.2);
        let places: Vec<(f64, f64)> = line.points.iter().map(|p| (p.x, p.y)).collect();
        chart.draw_series(LineSeries::new(places.iter().copied(), colour.stroke_width(2)))?;
        if !even {
            chart.draw_series(places.iter().map(|place| Circle::new(*place, 4, colour.filled())))?;
        }
        let bars = line.points.iter().filter(|p| p.error > 0.0).map(|p| {
            let low = (p.y - p.error).max(floor);
            ErrorBar::new_vertical(p.x, low, p.y, p.y + p.error, colour.stroke_width(1), 9)
        });
        chart.draw_series(bars)?;
    }
    root.present()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let near = |found: Vec<f64>, wanted: &[f64]| {
            assert_eq!(found.len(), wanted.len(), "{found:?}");
            found.iter().zip(wanted).for_each(|(a, b)| assert!((a / b - 1.0).abs() < 1e-12, "{found:?}"));
        };
        near(round_numbers(&(0.3..30.0)), &[0.5, 1.0, 2.0, 5.0, 10.0, 20.0]);
        near(round_numbers(&(0.5e-4..2.0)), &[1e-4, 1e-3, 1e-2, 1e-1, 1.0]);
    }

    #[test]
    fn nothing_to_draw_is_an_empty_plot() {
        let axis = Axis { title: "seconds", scale: Spacing::Logarithmic(None) };
        let line = Line { colour: colour(0), points: vec![Point { x: 1.0, y: 0.0, error: 0.0 }] };
        assert!(svg("Err", &axis, &[line]).unwrap().contains("</svg>"));
    }
}
