//! A quantity outside its range, and the checks that find it: one place for every crate that has parameters with units.
//!
//! ```
//! use fracdiff::parameter::positive;
//!
//! let refused = positive("mass", -1.0, "kg").unwrap_err();
//! assert_eq!(refused.to_string(), "mass -1 kg is not above 0 kg");
//! ```

mod shown;

pub use shown::Shown;

use core::fmt;

/// A quantity outside its documented range. Prints as one line: name, rejected value, allowed range, unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeError {
    /// Name of the quantity.
    pub what: &'static str,
    /// The rejected value, in `unit`.
    pub value: f64,
    /// The allowed range in words, without the unit.
    pub allowed: &'static str,
    /// The unit; empty for a pure number.
    pub unit: &'static str,
}

impl RangeError {
    /// From all four.
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
        let Self {
            what,
            value,
            allowed,
            unit,
        } = self;
        let space = if unit.is_empty() { "" } else { " " };
        let finite = if value.is_infinite() && !allowed.contains("finite") {
            "finite and "
        } else {
            ""
        };
        let value = Shown(*value);
        write!(f, "{what} {value}{space}{unit} is not {finite}{allowed}")?;
        // A range in words has no unit behind it.
        if allowed.ends_with(|last: char| last.is_ascii_digit() || "])π".contains(last)) {
            write!(f, "{space}{unit}")?;
        }
        Ok(())
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
    range(what, value, value > 0.0, "above 0", unit)
}

/// Accepts a finite value of at least zero.
///
/// # Errors
/// Any other value.
#[inline(never)]
pub fn not_negative(what: &'static str, value: f64, unit: &'static str) -> Result<f64, RangeError> {
    range(what, value, value >= 0.0, "at least 0", unit)
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
            text(-2.5, "at least 0", "N/m"),
            "stiffness -2.5 N/m is not at least 0 N/m"
        );
        assert_eq!(text(3.0, "in [0, 1]", ""), "stiffness 3 is not in [0, 1]");
        assert_eq!(
            text(4.0, "above 0 and at most π", "rad"),
            "stiffness 4 rad is not above 0 and at most π rad"
        );
        // A range in words has no unit behind it; a number with hundreds of digits is written with an exponent.
        assert_eq!(
            text(1e300, "finite", "N/m"),
            "stiffness 1e300 N/m is not finite"
        );
        assert_eq!(text(1e-9, "above 1", ""), "stiffness 1e-9 is not above 1");
        assert_eq!(
            text(f64::INFINITY, "above 0", "N/m"),
            "stiffness inf N/m is not finite and above 0 N/m"
        );
        assert_eq!(
            text(f64::NAN, "above 0", "N/m"),
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
            Err("above 0")
        );
        assert_eq!(not_negative("x", 0.0, ""), Ok(0.0));
        assert_eq!(positive("x", 1e-300, ""), Ok(1e-300));
    }
}
