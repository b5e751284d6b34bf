//! Errors of the libraries as Python's `ValueError`, with their own text.

use pyo3::PyErr;
use pyo3::exceptions::PyValueError;
use std::fmt::Display;

/// A `ValueError` with the text of an error.
pub(crate) fn refused(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// The value, or a `ValueError` with the text of the error.
pub(crate) trait OrRefused<T> {
    /// The value, or a `ValueError` with the text of the error.
    fn or_refused(self) -> pyo3::PyResult<T>;
}

impl<T, E: Display> OrRefused<T> for Result<T, E> {
    fn or_refused(self) -> pyo3::PyResult<T> {
        self.map_err(refused)
    }
}
