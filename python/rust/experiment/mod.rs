//! Experiments: what experiment files describe, from arguments by name.

mod question;
mod run;

pub(crate) use question::answer;
pub(crate) use run::{experiment_parameters, run_experiment, table};

use crate::refused::{OrRefused as _, refused, unread};
use haptic_experiment::Failure;
use haptic_experiment::document::Document;
use pyo3::PyErr;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};

/// Bad input is a `ValueError`; a run, device or disk that failed a `RuntimeError`.
fn failed(failure: &Failure) -> PyErr {
    match failure {
        Failure::Input(cause) => unread(cause),
        Failure::Run(_) | Failure::Device(_) | Failure::DataLost(_) => {
            PyRuntimeError::new_err(failure.to_string())
        }
    }
}

/// The document of a kind with these parameters.
fn document(kind: &str, parameters: &Bound<'_, PyDict>) -> PyResult<Document> {
    let mut document = Document::new(kind);
    for (key, value) in parameters.iter() {
        let key: String = key.extract()?;
        let value = toml_value(&key, &value)?;
        // The keyword is in the message.
        document.set(kind, &key, value, "").or_refused()?;
    }
    Ok(document)
}

fn toml_value(key: &str, value: &Bound<'_, PyAny>) -> PyResult<toml::Value> {
    if value.cast::<PyBool>().is_ok() {
        return Ok(toml::Value::Boolean(value.extract()?));
    }
    if let Ok(integer) = value.extract::<i64>() {
        return Ok(toml::Value::Integer(integer));
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(toml::Value::Float(number));
    }
    if let Ok(text) = value.extract::<String>() {
        return Ok(toml::Value::String(text));
    }
    if let Ok(items) = value.try_iter() {
        let items = items.map(|item| toml_value(key, &item?));
        return items.collect::<PyResult<_>>().map(toml::Value::Array);
    }
    let text = value
        .call_method0("__fspath__")
        .and_then(|path| path.extract::<String>());
    text.map(toml::Value::String).map_err(|_| {
        refused(format_args!(
            "{key} is neither a number, a text, a list nor True or False"
        ))
    })
}
