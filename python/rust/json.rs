//! Values of the libraries as Python's, and back, by JSON: the names and units are those of the command's output.

use crate::refused::OrRefused as _;
use pyo3::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Dictionaries, lists and numbers.
pub(crate) fn to_python<'py>(
    py: Python<'py>,
    value: &impl Serialize,
) -> PyResult<Bound<'py, PyAny>> {
    read_json(py, &serde_json::to_string(value).or_refused()?)
}

/// The same of their text.
pub(crate) fn read_json<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (text,))
}

/// A value of a library from dictionaries, lists and numbers.
pub(crate) fn from_python<T: DeserializeOwned>(
    name: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<T> {
    let text = value.py().import("json")?.call_method1("dumps", (value,))?;
    let text: String = text.extract()?;
    serde_json::from_str(&text)
        .map_err(|error| crate::refused::refused(format_args!("{name}: {error}")))
}
