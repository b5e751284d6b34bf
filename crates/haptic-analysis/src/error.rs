//! The refusals of an analysis.

use fracdiff::parameter::RangeError;
use fracdiff::{ParameterError, SchemeError};

/// Why an analysis has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AnalysisError {
    /// A parameter outside its range: name, rejected value, allowed range, unit (empty for 1).
    #[error(transparent)]
    Range(#[from] RangeError),
    /// Something that could not be computed to the accuracy promised.
    #[error("{what} cannot be computed: {why}")]
    Unresolved {
        /// The subject of the error's sentence.
        what: &'static str,
        /// The reason, with the remedy where there is one.
        why: &'static str,
    },
    /// A question that only makes sense for a stable loop.
    #[error("the loop is not stable: it has no {what}")]
    NotStable {
        /// The quantity that only a stable loop has.
        what: &'static str,
    },
    /// A parameter of the operator.
    #[error(transparent)]
    Operator(#[from] SchemeError),
}

impl From<ParameterError> for AnalysisError {
    fn from(error: ParameterError) -> Self {
        Self::Operator(error.into())
    }
}
