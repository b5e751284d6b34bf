//! Values of the libraries as Python's, and back, by JSON: the names and units are those of the command's output.

use crate::refused::OrRefused as _;
use haptic_quantity::{WrittenUnit, did_you_mean, doubt, is_meant, label, parse_for_key};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::IntoPyDict as _;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// A dictionary of these items.
macro_rules! dict {
    ($py:expr; $($key:literal: $value:expr,)*) => {{
        let dict = pyo3::types::PyDict::new($py);
        $(dict.set_item($key, $value)?;)*
        dict
    }};
}
pub(crate) use dict;

/// Dictionaries, lists and numbers.
pub(crate) fn to_python<'py>(
    py: Python<'py>,
    value: &impl Serialize,
) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).or_refused()?;
    py.import("json")?.call_method1("loads", (text,))
}

/// The rows of a report, as the command prints them.
#[pyfunction]
pub(crate) fn lines<'py>(report: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let rows: serde_json::Value = from_python("report", report)?;
    to_python(report.py(), &haptic_experiment::lines(&rows))
}

/// The name of a key in words and the unit of its numbers: of `peak_force_n` `peak force` and `N`.
#[pyfunction]
pub(crate) fn name_and_unit(key: &str) -> (String, String) {
    (label(key), WrittenUnit::of_key(key, 1.0).symbol)
}

/// The number in SI units of a text with a unit, or of a number, for a key among these that is named with its unit or without, or
/// found by its place; with its key.
#[pyfunction]
pub(crate) fn quantity(
    keys: Vec<String>,
    name: &str,
    value: &Bound<'_, PyAny>,
    by_place: bool,
) -> PyResult<(String, f64)> {
    let Some(key) = keys.iter().find(|key| is_meant(key, name)) else {
        let advice = did_you_mean(name, keys.iter().map(String::as_str));
        let unknown = format!("unexpected keyword {name}: {advice}");
        return Err(PyTypeError::new_err(unknown));
    };
    let says_unit = name == key && !by_place;
    Ok((key.clone(), number_for(key, says_unit, value)?))
}

/// A number for a key: of a text with a unit; without one it is asked for where no device has such a number and nobody has said the unit.
pub(crate) fn number_for(key: &str, says_unit: bool, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    let refused = |error: String| crate::refused::refused(format_args!("{key}: {error}"));
    let (number, text) = match value.extract::<String>() {
        Ok(text) => {
            let number = parse_for_key(key, &text).map_err(|error| refused(error.to_string()))?;
            (number, text)
        }
        Err(_) => {
            let number: f64 = value.extract()?;
            (number, number.to_string())
        }
    };
    if !says_unit {
        doubt(key, &text).map_err(refused)?;
    }
    Ok(number)
}

/// A value of a library from dictionaries, lists and numbers.
pub(crate) fn from_python<T: DeserializeOwned>(
    name: &str,
    value: &Bound<'_, PyAny>,
) -> PyResult<T> {
    let py = value.py();
    // A number of NumPy as Python's.
    let default = py
        .import("operator")?
        .call_method1("methodcaller", ("item",))?;
    let options = [("default", default)].into_py_dict(py)?;
    let text = (py.import("json")?).call_method("dumps", (value,), Some(&options))?;
    let text: String = text.extract()?;
    serde_json::from_str(&text)
        .map_err(|error| crate::refused::refused(format_args!("{name}: {error}")))
}
