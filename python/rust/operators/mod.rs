//! Fractional operators: of whole records, and of streams.

mod records;
mod response;
mod stream;

use crate::refused::OrRefused as _;
use fracdiff::{Channel, Operator, Scheme};
use pyo3::prelude::*;
pub(crate) use records::{differintegrate, grunwald_weights};
pub(crate) use response::frequency_response;
pub(crate) use stream::PyOperator;

/// The axis of a stream.
type Axis = Channel<f64, Operator<f64>>;

/// A scheme from its words.
///
/// # Errors
/// `ValueError` for words that are none.
pub(crate) fn scheme_of(text: &str) -> PyResult<Scheme> {
    text.parse().or_refused()
}
