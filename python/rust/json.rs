//! Values of the libraries as Python's, and back, by JSON: the names and units are those of the command's output.

use crate::refused::OrRefused as _;
use pyo3::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Dictionaries, lists and numbers.
///
/// # Errors
/// If Python's reader fails, which JSON from here rules out.
pub(crate) fn to_python<'py>(
    py: Python<'py>,
    value: &impl Serialize,
) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).or_refused()?;
    py.import("json")?.call_method1("loads", (text,))
}

/// A value of a library from dictionaries, lists and numbers.
///
/// # Errors
/// `ValueError` for fields that are missing, unknown or of another type.
pub(crate) fn from_python<T: DeserializeOwned>(
    name: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<T> {
    let text = value.py().import("json")?.call_method1("dumps", (value,))?;
    let text: String = text.extract()?;
    serde_json::from_str(&text)
        .map_err(|error| crate::refused::refused(format_args!("{name}: {error}")))
}
