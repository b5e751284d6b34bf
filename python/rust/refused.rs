//! Errors of the libraries as Python's, with their own text.

use pyo3::PyErr;
use pyo3::exceptions::{PyOSError, PyValueError};
use std::error::Error;
use std::fmt::Display;
use std::io;

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

/// An error of a reader of files: `FileNotFoundError`, `PermissionError` and the like where the system refused one, whatever
/// is around it; else a `ValueError`.
pub(crate) fn unread(error: &(dyn Error + 'static)) -> PyErr {
    let text = error.to_string();
    let mut cause = Some(error);
    while let Some(error) = cause {
        let system = error.downcast_ref::<io::Error>();
        if let Some(number) = system.and_then(io::Error::raw_os_error) {
            // Python chooses the kind of `OSError` by the number.
            return PyOSError::new_err((number, text));
        }
        cause = error.source();
    }
    refused(text)
}
