//! Numbers in messages.

use core::fmt::{self, Write as _};

/// A number in a message: to six significant digits, with an exponent where it would have many zeros.
///
/// One that six digits would make a round number, of three digits or fewer, keeps all of its own: a number just above 1 that "is not at
/// most 1" has to look like one.
///
/// ```
/// use fracdiff::parameter::Shown;
///
/// assert_eq!(format!("{} {} {}", Shown(0.25), Shown(1e300), Shown(-2e-9)), "0.25 1e300 -2e-9");
/// assert_eq!(format!("{} {}", Shown(2.0 / 3.0), Shown(1.000_000_1)), "0.666667 1.0000001");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown(pub f64);

/// Digits of a number that is rounded.
const DIGITS: usize = 6;
/// A number of so many digits is a round one.
const ROUND: usize = 3;

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (value, size) = (self.0, self.0.abs());
        if size == 0.0 || !size.is_finite() {
            return value.fmt(f);
        }
        let plain = (1e-6..1e6).contains(&size);
        let (mut own, mut rounded) = (Text::EMPTY, Text::EMPTY);
        write!(own, "{value:e}")?;
        write!(rounded, "{value:.*e}", DIGITS - 1)?;
        let (mantissa, exponent) = rounded.halves();
        let keeps_its_own = digits(own.halves().0) <= DIGITS || digits(mantissa) <= ROUND;
        match (plain, keeps_its_own) {
            (true, true) => value.fmt(f),
            (false, true) => fmt::LowerExp::fmt(&value, f),
            (false, false) => write!(f, "{mantissa}e{exponent}"),
            (true, false) => {
                // The exponent is the place of the first digit.
                let place: usize = exponent.parse::<i32>().map_or(0, |place| {
                    usize::try_from(DIGITS as i32 - 1 - place).unwrap_or(0)
                });
                let mut text = Text::EMPTY;
                write!(text, "{value:.place$}")?;
                f.write_str(without_zeros(text.as_str()))
            }
        }
    }
}

/// A number as text, on the stack: no `f64` is longer with an exponent, or with six digits and no more than six zeros.
struct Text {
    bytes: [u8; 32],
    length: usize,
}

impl Text {
    const EMPTY: Self = Self {
        bytes: [0; 32],
        length: 0,
    };

    fn as_str(&self) -> &str {
        core::str::from_utf8(&self.bytes[..self.length]).unwrap_or_default()
    }

    /// Mantissa, without zeros at its end, and exponent.
    fn halves(&self) -> (&str, &str) {
        let (mantissa, exponent) = self.as_str().split_once('e').unwrap_or_default();
        (without_zeros(mantissa), exponent)
    }
}

impl fmt::Write for Text {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let end = self.length + text.len();
        let place = self.bytes.get_mut(self.length..end).ok_or(fmt::Error)?;
        place.copy_from_slice(text.as_bytes());
        self.length = end;
        Ok(())
    }
}

/// Without zeros at the end, behind a decimal point.
fn without_zeros(number: &str) -> &str {
    if number.contains('.') {
        number.trim_end_matches('0').trim_end_matches('.')
    } else {
        number
    }
}

fn digits(mantissa: &str) -> usize {
    mantissa.bytes().filter(u8::is_ascii_digit).count()
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::string::ToString as _;

    #[test]
    fn a_number_has_six_digits_and_an_exponent_where_it_would_have_many_zeros() {
        for (value, want) in [
            (0.0, "0"),
            (-0.25, "-0.25"),
            (2.0 / 3.0, "0.666667"),
            (123_456.789, "123457"),
            (-12.345_678_9, "-12.3457"),
            (0.000_012_345_678, "0.0000123457"),
            (123_456_789.123, "1.23457e8"),
            (-1.234_567_8e-7, "-1.23457e-7"),
            (1e300, "1e300"),
            (f64::MAX, "1.79769e308"),
            (f64::MIN_POSITIVE, "2.22507e-308"),
            (5e-324, "5e-324"),
            (f64::INFINITY, "inf"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(Shown(value).to_string(), want);
        }
    }

    #[test]
    fn what_would_look_like_a_bound_keeps_its_digits() {
        for (value, want) in [
            (1.000_000_1, "1.0000001"),
            (0.1 + 0.2, "0.30000000000000004"),
            (100_000_000.000_1, "1.000000000001e8"),
            (-0.999_999_99, "-0.99999999"),
            (99_999.96, "99999.96"),
        ] {
            assert_eq!(Shown(value).to_string(), want);
        }
    }

    #[test]
    fn a_rounded_number_reads_back_within_half_of_its_last_digit() {
        let mut value = 1.234_567_890_123e-305_f64;
        while value.abs() < 1e305 {
            let read: f64 = Shown(value).to_string().parse().expect("a number");
            assert!((read / value - 1.0).abs() <= 5e-6, "{value}: {read}");
            value *= -7.346_1;
        }
    }
}
