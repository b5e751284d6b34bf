//! Experiments: what experiment files describe, from arguments by name.

mod run;
mod search;

pub(crate) use run::{experiment_parameters, run_experiment};
pub(crate) use search::{design, zwidth};

use crate::refused::{refused, unread};
use haptic_experiment::{ExperimentFile, Failure};
use pyo3::PyErr;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};
use std::path::Path;

/// Bad input is a `ValueError`; a run, device or disk that failed a `RuntimeError`.
fn failed(failure: &Failure) -> PyErr {
    match failure {
        Failure::Input(error) => unread(error.as_ref()),
        _ => PyRuntimeError::new_err(failure.to_string()),
    }
}

/// The parameters of a kind as the file that would have them.
///
/// # Errors
/// `ValueError` for a value that no file can have.
fn written(kind: &str, parameters: &Bound<'_, PyDict>) -> PyResult<String> {
    let mut table = toml::Table::new();
    for (key, value) in parameters.iter() {
        let key: String = key.extract()?;
        let value = toml_value(&key, &value)?;
        table.insert(key, value);
    }
    let mut file = toml::Table::new();
    file.insert(kind.to_owned(), toml::Value::Table(table));
    Ok(file.to_string())
}

/// The experiment of a kind from that file.
///
/// # Errors
/// `ValueError` in the words of the reader of files, without the name of a file.
fn parsed(kind: &str, text: &str) -> PyResult<ExperimentFile> {
    ExperimentFile::parse(Path::new(kind), text).map_err(|error| {
        let text = error.to_string();
        let reason = text.strip_prefix(kind).and_then(|rest| {
            let rest = rest
                .strip_prefix(':')?
                .trim_start_matches(|c: char| c.is_ascii_digit());
            rest.strip_prefix(": ")
        });
        refused(reason.unwrap_or(&text))
    })
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
