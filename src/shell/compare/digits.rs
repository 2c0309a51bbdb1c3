//! Numbers as text, with as many digits as mean something.

/// A ratio with as many digits as can mean something.
pub fn number(value: f64) -> String {
    match value {
        value if !value.is_finite() => "–".into(),
        value if value.abs() < 9.95 => format!("{value:.2}"),
        value => format!("{value:.1}"),
    }
}

/// A count, if there is one.
pub fn count(value: Option<u32>) -> String {
    value.map_or("–".into(), |value| value.to_string())
}

/// A number with so many digits after the point.
pub fn fixed(value: f64, digits: usize) -> String {
    if value.is_finite() { format!("{value:.digits$}") } else { "–".into() }
}

/// A number with so many significant digits, and an exponent only if it is very large or small.
pub fn significant(value: f64, digits: usize) -> String {
    let precision = digits.saturating_sub(1);
    let scientific = format!("{value:.precision$e}");
    let exponent = scientific.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok());
    match exponent {
        None => "–".into(),
        Some(exponent @ -3..=5) => format!("{value:.*}", (precision as i32 - exponent).max(0) as usize),
        Some(_) => scientific,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_were_asked_for() {
        for (value, digits, text) in [
            (50.6449, 4, "50.64"),
            (0.001, 1, "0.001"),
            (0.099_999, 2, "0.10"),
            (0.000_123, 2, "1.2e-4"),
            (20.0, 1, "20"),
            (123_456.0, 3, "123456"),
            (f64::NAN, 3, "–"),
        ] {
            assert_eq!(significant(value, digits), text);
        }
    }

    #[test]
    fn ratios_that_are_not_known_are_dashes() {
        assert_eq!([2.345, 12.34, f64::NAN, f64::INFINITY].map(number), ["2.35", "12.3", "–", "–"]);
    }
}
