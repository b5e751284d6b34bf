//! Numbers as programs and people write them.
//! ```text
//! sign digits [decimal sign digits] [e exponent]       sign: +, -, − (U+2212)
//! ```
//! The decimal sign is a point or a comma. Thousands may be apart by the other of the two, by spaces or by apostrophes, in
//! groups of three.
//!
//! - *Errors*: `None` for what is not a finite number, such as `NaN`, `1,2,3` and `10:15`.
//! - *Cost*: that of the standard library for a number with a point, a copy of the text for any other.

/// The sign before the decimals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DecimalSign {
    /// Point, as in 1.5 and 1,234.5.
    Point,
    /// Comma, as in 1,5 and 1.234,5.
    Comma,
}

use DecimalSign::{Comma, Point};

/// A finite number of any spelling. A lone comma is taken for that of decimals, a lone point too: 1,234 is 1.234.
///
/// ```
/// use haptic_quantity::number;
///
/// assert_eq!(number("1,234E-03"), Some(1.234e-3));
/// assert_eq!(number("−2.5"), Some(-2.5));
/// assert_eq!(number("1.234.567,5"), Some(1_234_567.5));
/// assert_eq!(number("1,23,4"), None);
/// ```
#[must_use]
pub fn number(text: &str) -> Option<f64> {
    let sign = sign_of(text).unwrap_or(if text.contains(',') { Comma } else { Point });
    number_with(text, sign)
}

/// A finite number with this decimal sign.
#[must_use]
pub fn number_with(text: &str, decimal_sign: DecimalSign) -> Option<f64> {
    let text = text.trim();
    // Most cells of most tables.
    if decimal_sign == Point
        && let Some(value) = plain(text)
    {
        return Some(value);
    }
    let text = text.replace('\u{2212}', "-");
    let (mantissa, exponent) = match text.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, Some(exponent)),
        None => (&*text, None),
    };
    // The decimal mark, and that of thousands.
    let (mark, other) = match decimal_sign {
        Point => ('.', ','),
        Comma => (',', '.'),
    };
    let (whole, decimals) = match mantissa.split_once(mark) {
        Some((_, "")) => return None,
        Some((whole, decimals)) => (whole, Some(decimals)),
        None => (mantissa, None),
    };
    let mut number = in_groups(whole, other)?;
    if let Some(decimals) = decimals {
        number.push('.');
        number += decimals;
    }
    if let Some(exponent) = exponent {
        number.push('e');
        number += exponent;
    }
    plain(&number)
}

/// The decimal sign that a number shows beyond doubt: a comma and a point identify each other, as do groups of three
/// from decimals. `None` of `1.234`, `1,234` and `1234`.
#[must_use]
pub fn sign_of(text: &str) -> Option<DecimalSign> {
    let mantissa = text.split(['e', 'E']).next().unwrap_or_default().trim();
    let digits = mantissa.trim_start_matches(['+', '-', '\u{2212}']);
    let marks: Vec<(usize, &str)> = digits.match_indices(['.', ',']).collect();
    let &(at, mark) = marks.last()?;
    let (sign, other) = if mark == "." {
        (Point, Comma)
    } else {
        (Comma, Point)
    };
    let (whole, decimals) = (&digits[..at], &digits[at + 1..]);
    let may_be_group =
        matches!(whole.len(), 1..=3) && !whole.starts_with('0') && decimals.len() == 3;
    match marks.iter().filter(|place| place.1 == mark).count() {
        1 if marks.len() > 1 => Some(sign),
        1 => (!may_be_group).then_some(sign),
        _ => Some(other),
    }
}

/// A number as the standard library reads it, if it is finite.
fn plain(text: &str) -> Option<f64> {
    text.parse().ok().filter(|value: &f64| value.is_finite())
}

/// Digits whose groups of three are joined; `None` of other groups.
fn in_groups(digits: &str, mark: char) -> Option<String> {
    let is_mark =
        |c: char| c == mark || matches!(c, ' ' | '\u{a0}' | '\u{2009}' | '\u{202f}' | '\'');
    let mut groups = digits.split(is_mark);
    let mut joined = groups.next()?.to_owned();
    for (n, group) in groups.enumerate() {
        let before = joined.trim_start_matches(['+', '-']).len();
        if group.len() != 3 || (n == 0 && !(1..=3).contains(&before)) {
            return None;
        }
        joined += group;
    }
    Some(joined)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_read_however_it_is_spelt() {
        for (text, value) in [
            ("1.5", 1.5),
            (" 1,5 ", 1.5),
            ("1.234e-3", 1.234e-3),
            ("1,234E-03", 1.234e-3),
            ("1.2E+03", 1200.0),
            ("−0,25", -0.25),
            ("−1e−3", -1e-3),
            ("1,234.5", 1234.5),
            ("1.234,5", 1234.5),
            ("1,234,567", 1_234_567.0),
            ("1.234.567", 1_234_567.0),
            ("12 345,6", 12_345.6),
            ("12\u{202f}345", 12_345.0),
            ("1'234.5", 1234.5),
            ("1,234", 1.234),
            ("1.234", 1.234),
            (",5", 0.5),
            (".5", 0.5),
            ("5.", 5.0),
            ("+7", 7.0),
            ("1.234,5e2", 123_450.0),
        ] {
            assert_eq!(number(text), Some(value), "{text:?}");
        }
        assert_eq!(number_with("1,234", Point), Some(1234.0));
        assert_eq!(number_with("1.234", Comma), Some(1234.0));
        assert_eq!(number_with("1234,5", Point), None);
    }

    #[test]
    fn what_is_no_number_is_none() {
        for text in [
            "",
            "-",
            "nan",
            "inf",
            "-inf",
            "infinity",
            "1e999",
            "1,",
            "1,2,3",
            "1.2.3",
            "12,34.5",
            "10:15:00",
            "1.2.2026",
            "1 2",
            "1 23",
            "5 s",
            "e5",
            "1e",
            "0x1",
            "1,234.5,6",
            "--1",
            "− 1",
            "1,234,56",
            "5%",
        ] {
            assert_eq!(number(text), None, "{text:?}");
        }
    }
}
