//! Values that are not read, and how their writers would have had to write them.
//! ```text
//! 0,05 → 0.05     2mins → 2min     4cm^2 → 4cm2     1/2 → 0.5     6dB → 1.995     1kHz, where a time is asked → 1ms
//! ```
//! - *Errors*: `None` where nobody can tell; of `1,234` both numbers that it may be.

use crate::{
    DecimalSign, FREQUENCY, NUMBER, TIME, Unit, digits, number, number_with, read, sign_of, written,
};

pub(crate) fn meant(units: &[Unit], text: &str) -> Option<String> {
    otherwise_spelt(units, text).or_else(|| of_another_kind(units, text))
}

/// The same quantity with a point for its comma, and its unit as it is read.
fn otherwise_spelt(units: &[Unit], text: &str) -> Option<String> {
    let mut ends = (0..=text.len()).rev();
    let end = ends.find(|&end| text.get(..end).is_some_and(|text| number(text).is_some()))?;
    let (figures, unit) = (&text[..end], text[end..].trim());
    let unit = known_unit(units, unit).or(Some("").filter(|_| end == text.len()))?;
    let spelt = |sign| Some(format!("{}{unit}", number_with(figures, sign)?));
    let signs = match sign_of(figures) {
        Some(sign) => vec![sign],
        None if figures.contains(',') => vec![DecimalSign::Comma, DecimalSign::Point],
        None => vec![DecimalSign::Point],
    };
    let readings: Vec<String> = signs.into_iter().filter_map(spelt).collect();
    let comma = Some(", without a comma").filter(|_| figures.contains(','));
    let is_read = |text: &String| read(units, text).is_some();
    let all = readings.iter().all(is_read);
    all.then(|| format!("{}{}", readings.join(" or "), comma.unwrap_or_default()))
}

fn known_unit(units: &[Unit], written: &str) -> Option<&'static str> {
    let plain = written.to_lowercase().replace('^', "");
    let single = plain.strip_suffix('s').unwrap_or(&plain);
    let alike = |unit: &str| unit.eq_ignore_ascii_case(&plain) || unit.eq_ignore_ascii_case(single);
    let mut known = units.iter().map(|(unit, _)| *unit);
    known.find(|unit| !unit.is_empty() && alike(unit))
}

/// A quotient or decibels where a number is asked, a rate where a time is.
fn of_another_kind(units: &[Unit], text: &str) -> Option<String> {
    if units == TIME.1 {
        let rate_hz = read(FREQUENCY.1, text).filter(|rate| *rate > 0.0)?;
        return Some(written("_s", 1.0 / rate_hz).replace(' ', ""));
    }
    let value = match text.split_once('/') {
        Some((above, below)) => number(above)? / number(below)?,
        None => 10_f64.powf(number(text.trim().strip_suffix("dB")?)? / 20.0),
    };
    Some(digits(value, 4)).filter(|_| units == NUMBER.1 && value.is_finite())
}
