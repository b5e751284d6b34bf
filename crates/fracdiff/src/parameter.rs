//! A quantity outside its range, and the checks that find it: one place for every crate that has parameters with units.
//! ```
//! use fracdiff::parameter::positive;
//!
//! let refused = positive("mass", -1.0, "kg").unwrap_err();
//! assert_eq!(refused.to_string(), "mass -1 kg is not above 0 kg");
//! ```

use core::fmt::{self, Write as _};

/// A quantity outside its documented range. Prints as one line: name, rejected value, allowed range, unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeError {
    /// Name of the quantity, with which the message begins.
    pub what: &'static str,
    /// The rejected value, in `unit`.
    pub value: f64,
    /// The allowed range in words, such as "above 0 {}": ` {}` is replaced by the unit, and dropped
    /// with its space if there is no unit.
    pub allowed: &'static str,
    /// The unit; empty for a pure number.
    pub unit: &'static str,
}

impl RangeError {
    /// The error for a value that the caller has found to be outside its range.
    #[must_use]
    pub const fn new(
        what: &'static str,
        value: f64,
        allowed: &'static str,
        unit: &'static str,
    ) -> Self {
        Self {
            what,
            value,
            allowed,
            unit,
        }
    }
}

impl fmt::Display for RangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, value, unit) = (self.what, Shown(self.value), self.unit);
        let space = if unit.is_empty() { "" } else { " " };
        write!(f, "{what} {value}{space}{unit} is not ")?;
        if self.value.is_infinite() && !self.allowed.contains("finite") {
            f.write_str("finite and ")?;
        }
        match self.allowed.split_once(" {}") {
            Some((before, behind)) => write!(f, "{before}{space}{unit}{behind}"),
            None => f.write_str(self.allowed),
        }
    }
}

impl core::error::Error for RangeError {}

/// Accepts a finite value that the caller has found to be in its range.
///
/// # Errors
/// Any other value.
#[inline(never)]
pub fn range(
    what: &'static str,
    value: f64,
    accepted: bool,
    allowed: &'static str,
    unit: &'static str,
) -> Result<f64, RangeError> {
    if accepted && value.is_finite() {
        Ok(value)
    } else {
        Err(RangeError::new(what, value, allowed, unit))
    }
}

/// Accepts a finite value above zero.
///
/// # Errors
/// Any other value.
#[inline(never)]
pub fn positive(what: &'static str, value: f64, unit: &'static str) -> Result<f64, RangeError> {
    range(what, value, value > 0.0, "above 0 {}", unit)
}

/// Accepts a finite value of at least zero.
///
/// # Errors
/// Any other value.
#[inline(never)]
pub fn not_negative(what: &'static str, value: f64, unit: &'static str) -> Result<f64, RangeError> {
    range(what, value, value >= 0.0, "at least 0 {}", unit)
}

/// A number in a message: to six significant digits, with an exponent where it would have many zeros.
///
/// One that six digits would make a round number, of three digits or fewer, keeps all of its own: a number just above 1 that "is not at
/// most 1" has to look like one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown(pub f64);

/// Digits of a number that is rounded.
const DIGITS: usize = 6;
/// Most digits of a round number.
const ROUND: usize = 3;

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (value, size) = (self.0, self.0.abs());
        if size == 0.0 || !size.is_finite() {
            return value.fmt(f);
        }
        let plain = (1e-6..1e6).contains(&size);
        let (mut shortest, mut rounded) = (Text::EMPTY, Text::EMPTY);
        write!(shortest, "{value:e}")?;
        write!(rounded, "{value:.*e}", DIGITS - 1)?;
        let (mantissa, exponent) = rounded.halves();
        let is_short = digits(shortest.halves().0) <= DIGITS || digits(mantissa) <= ROUND;
        match (plain, is_short) {
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

/// Number without zeros at the end, behind a decimal point.
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

/// An enumeration whose `ALL` has every variant, in this order; with a text behind each variant also its `name`, and with another one
/// for people `CHOICES`, which has both. A variant that a list of its own would lack compiles and is never offered.
///
/// ```
/// fracdiff::enumerated! {
///     /// The side on which a force acts.
///     #[derive(Debug, PartialEq)]
///     pub enum Side {
///         /// Towards lower positions.
///         Low "low",
///         /// Towards higher positions.
///         High "high",
///     }
/// }
/// assert_eq!(Side::ALL.map(|side| side.name()), ["low", "high"]);
/// ```
#[macro_export]
macro_rules! enumerated {
    ($(#[$meta:meta])* $vis:vis enum $name:ident {
        $($(#[$about:meta])* $variant:ident $(= $code:literal)?,)+
    }) => {
        $(#[$meta])*
        $vis enum $name {
            $($(#[$about])* $variant $(= $code)?,)+
        }

        impl $name {
            /// Every one, in the order in which they are declared.
            $vis const ALL: [Self; [$(Self::$variant),+].len()] = [$(Self::$variant),+];
        }
    };
    ($(#[$meta:meta])* $vis:vis enum $name:ident {
        $($(#[$about:meta])* $variant:ident $text:literal,)+
    }) => {
        $crate::enumerated! {
            $(#[$meta])*
            $vis enum $name {
                $($(#[$about])* $variant,)+
            }
        }

        impl $name {
            /// Its name in files, options and messages.
            #[must_use]
            $vis const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $text,)+
                }
            }
        }
    };
    ($(#[$meta:meta])* $vis:vis enum $name:ident {
        $($(#[$about:meta])* $variant:ident $text:literal $words:literal,)+
    }) => {
        $crate::enumerated! {
            $(#[$meta])*
            $vis enum $name {
                $($(#[$about])* $variant $text,)+
            }
        }

        impl $name {
            /// Each with its name and a few words for people.
            $vis const CHOICES: [(Self, &'static str, &'static str); Self::ALL.len()] =
                [$((Self::$variant, $text, $words)),+];
        }
    };
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::string::ToString as _;

    #[test]
    fn a_refusal_prints_value_range_and_unit_in_one_line() {
        let text = |value, allowed, unit| {
            RangeError {
                what: "stiffness",
                value,
                allowed,
                unit,
            }
            .to_string()
        };
        assert_eq!(
            text(-2.5, "at least 0 {}", "N/m"),
            "stiffness -2.5 N/m is not at least 0 N/m"
        );
        assert_eq!(
            text(3.0, "in [0, 1] {}", ""),
            "stiffness 3 is not in [0, 1]"
        );
        assert_eq!(
            text(4.0, "above 0 and at most π {}", "rad"),
            "stiffness 4 rad is not above 0 and at most π rad"
        );
        // A range in words has no unit behind it; a number with hundreds of digits is written with an exponent.
        assert_eq!(
            text(1e300, "finite", "N/m"),
            "stiffness 1e300 N/m is not finite"
        );
        assert_eq!(text(1e-9, "above 1", ""), "stiffness 1e-9 is not above 1");
        assert_eq!(
            text(f64::INFINITY, "above 0 {}", "N/m"),
            "stiffness inf N/m is not finite and above 0 N/m"
        );
        assert_eq!(
            text(f64::NAN, "above 0 {}", "N/m"),
            "stiffness NaN N/m is not above 0 N/m"
        );
    }

    #[test]
    fn what_is_not_finite_is_in_no_range() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(range("x", value, true, "finite", "").is_err());
            assert!(positive("x", value, "").is_err() && not_negative("x", value, "").is_err());
        }
        assert_eq!(
            positive("x", 0.0, "").map_err(|error| error.allowed),
            Err("above 0 {}")
        );
        assert_eq!(not_negative("x", 0.0, ""), Ok(0.0));
        assert_eq!(positive("x", 1e-300, ""), Ok(1e-300));
    }

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
