//! Parameters outside their documented range.

use core::fmt;
use fracdiff::Real;

/// A parameter outside its documented range: name, rejected value, allowed range, unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ParameterError {
    /// A quantity.
    Range {
        /// What it is.
        what: &'static str,
        /// The rejected value, in `unit`.
        value: f64,
        /// The allowed range in words, without the unit.
        allowed: &'static str,
        /// The unit; empty for a pure number.
        unit: &'static str,
    },
    /// A parameter of the operator.
    Operator(fracdiff::ParameterError),
}

impl From<fracdiff::ParameterError> for ParameterError {
    fn from(error: fracdiff::ParameterError) -> Self {
        Self::Operator(error)
    }
}

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range {
                what,
                value,
                allowed,
                unit,
            } => {
                let space = if unit.is_empty() { "" } else { " " };
                write!(
                    f,
                    "{what} {value}{space}{unit} is not {allowed}{space}{unit}"
                )
            }
            Self::Operator(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for ParameterError {}

#[inline(never)]
pub(crate) fn range(
    what: &'static str,
    value: f64,
    accepted: bool,
    allowed: &'static str,
    unit: &'static str,
) -> Result<f64, ParameterError> {
    if accepted && value.is_finite() {
        Ok(value)
    } else {
        Err(ParameterError::Range {
            what,
            value,
            allowed,
            unit,
        })
    }
}

/// Rounds a checked value to the loop's precision; refuses one that overflows or vanishes there.
#[inline(never)]
pub(crate) fn rounded<F: Real>(
    what: &'static str,
    value: f64,
    unit: &'static str,
) -> Result<F, ParameterError> {
    let rounded = F::from_f64(value);
    let kept = rounded.is_finite() && (rounded.abs() > F::ZERO || value.abs() == 0.0);
    range(
        what,
        value,
        kept,
        "within the range of the loop's number type, in",
        unit,
    )?;
    Ok(rounded)
}

/// Accepts a finite value above zero.
#[inline(never)]
pub(crate) fn positive(
    what: &'static str,
    value: f64,
    unit: &'static str,
) -> Result<f64, ParameterError> {
    range(what, value, value > 0.0, "above 0", unit)
}

/// Accepts a finite value of at least zero.
#[inline(never)]
pub(crate) fn not_negative(
    what: &'static str,
    value: f64,
    unit: &'static str,
) -> Result<f64, ParameterError> {
    range(what, value, value >= 0.0, "at least 0", unit)
}
