//! The refusals of an analysis.

use fracdiff::parameter::RangeError;
use std::fmt;

/// A question that has no answer, in words.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum AnalysisError {
    /// A parameter outside its range: name, rejected value, allowed range, unit (empty for 1).
    Range(RangeError),
    /// Something that could not be computed to the accuracy promised.
    Unresolved {
        /// The subject.
        what: &'static str,
        /// Why.
        why: &'static str,
    },
    /// A question that only makes sense for a stable loop.
    NotStable {
        /// The thing asked for.
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

impl From<RangeError> for AnalysisError {
    fn from(error: RangeError) -> Self {
        Self::Range(error)
    }
}

impl fmt::Display for AnalysisError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Range(ref error) => error.fmt(f),
            Self::Unresolved { what, why } => write!(f, "{what} cannot be computed: {why}"),
            Self::NotStable { what } => write!(f, "the loop is not stable: it has no {what}"),
            Self::Operator(ref error) => error.fmt(f),
        }
    }
}

impl std::error::Error for AnalysisError {}
