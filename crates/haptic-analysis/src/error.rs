//! What an analysis refuses.

use std::fmt;

/// A question that has no answer, in words.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum AnalysisError {
    /// A parameter outside its range: name, rejected value, allowed range, unit (empty for 1).
    Range {
        /// What it is.
        what: &'static str,
        /// The rejected value.
        value: f64,
        /// The allowed range in words, as in `at least 0`.
        allowed: &'static str,
        /// The unit; empty for a pure number.
        unit: &'static str,
    },
    /// Something that could not be computed to the accuracy promised.
    Unresolved {
        /// What.
        what: &'static str,
        /// Why.
        why: &'static str,
    },
    /// A question that only makes sense for a stable loop.
    NotStable {
        /// What was asked for.
        what: &'static str,
    },
    /// A parameter of the operator.
    Operator(fracdiff::SchemeError),
}

impl From<fracdiff::SchemeError> for AnalysisError {
    fn from(error: fracdiff::SchemeError) -> Self {
        Self::Operator(error)
    }
}

impl From<fracdiff::ParameterError> for AnalysisError {
    fn from(error: fracdiff::ParameterError) -> Self {
        Self::Operator(error.into())
    }
}

impl fmt::Display for AnalysisError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range {
                what,
                value,
                allowed,
                unit,
            } => {
                let space = if unit.is_empty() { "" } else { " " };
                // A number that `{}` writes with hundreds of digits is written with an exponent.
                let short = *value == 0.0 || (1e-6..1e15).contains(&value.abs());
                if short {
                    write!(f, "{what} {value}{space}{unit} is not {allowed}")?;
                } else {
                    write!(f, "{what} {value:e}{space}{unit} is not {allowed}")?;
                }
                // A range in words has no unit behind it.
                if allowed.ends_with(|last: char| last.is_ascii_digit() || "])π".contains(last)) {
                    write!(f, "{space}{unit}")?;
                }
                Ok(())
            }
            Self::Unresolved { what, why } => write!(f, "{what} cannot be computed: {why}"),
            Self::NotStable { what } => write!(f, "the loop is not stable: it has no {what}"),
            Self::Operator(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for AnalysisError {}

/// Accepts a finite value above zero.
pub(crate) fn positive(
    what: &'static str,
    value: f64,
    unit: &'static str,
) -> Result<f64, AnalysisError> {
    check(what, value, value > 0.0, "above 0", unit)
}

/// Accepts a finite value of at least zero.
pub(crate) fn not_negative(
    what: &'static str,
    value: f64,
    unit: &'static str,
) -> Result<f64, AnalysisError> {
    check(what, value, value >= 0.0, "at least 0", unit)
}

/// Accepts a finite value that was found to be in its range.
pub(crate) fn check(
    what: &'static str,
    value: f64,
    accepted: bool,
    allowed: &'static str,
    unit: &'static str,
) -> Result<f64, AnalysisError> {
    if accepted && value.is_finite() {
        Ok(value)
    } else {
        Err(AnalysisError::Range {
            what,
            value,
            allowed,
            unit,
        })
    }
}
