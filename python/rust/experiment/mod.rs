//! Experiments: what experiment files describe, from arguments by name.

mod question;
mod run;

pub(crate) use question::{answer, calibrate};
pub(crate) use run::{experiment_parameters, run_experiment, table};

use crate::json::number_for;
use crate::refused::{OrRefused as _, refused, unread};
use haptic_document::Document;
use haptic_experiment::Failure;
use haptic_experiment::parameters::{Value, of_kind};
use haptic_quantity::is_meant;
use pyo3::PyErr;
use pyo3::exceptions::{PyFileNotFoundError, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Mutex;

/// Sentences for the user, in their order.
#[derive(Debug, Default)]
struct Heard(Mutex<Vec<String>>);

impl Heard {
    fn hear(&self, text: &str) {
        if let Ok(mut all) = self.0.lock() {
            all.push(text.to_owned());
        }
    }

    fn all(self) -> Vec<String> {
        self.0.into_inner().unwrap_or_default()
    }
}

/// Bad input is a `ValueError`; a run, device or disk that failed a `RuntimeError`.
pub(crate) fn failed(failure: &Failure) -> PyErr {
    match failure {
        Failure::Input(cause) => unread(cause),
        Failure::Run(_) | Failure::Device(_) | Failure::DataLost(_) => {
            PyRuntimeError::new_err(failure.to_string())
        }
    }
}

/// The maker of a file.
pub(crate) const PROGRAM: &str = concat!("fractional-haptics (Python) ", env!("CARGO_PKG_VERSION"));

/// The maker of a log.
pub(crate) fn provenance() -> BTreeMap<String, String> {
    BTreeMap::from([("program".to_owned(), PROGRAM.to_owned())])
}

/// The document of a kind with these parameters.
pub(crate) fn document(kind: &str, parameters: &Bound<'_, PyDict>) -> PyResult<Document> {
    over(Document::new(kind), kind, parameters)
}

/// A document with these parameters over it.
fn over(mut document: Document, kind: &str, parameters: &Bound<'_, PyDict>) -> PyResult<Document> {
    let tables = of_kind(kind);
    for (written, value) in parameters.iter() {
        let written: String = written.extract()?;
        let mut known = tables.iter().flat_map(|(_, table)| *table);
        let meant = known.find(|known| is_meant(known.key, &written));
        let key = meant.map_or(&*written, |known| known.key);
        let is_number =
            meant.is_some_and(|known| matches!(known.value, Value::Number(..) | Value::List(_)));
        let numbers = is_number.then(|| written == key);
        let value = toml_value(key, &value, numbers)?;
        let names = |text: &&str| meant.is_some_and(|known| known.is_path(text));
        let file = value.as_str().filter(names);
        if let Some(missing) = file.filter(|file| !Path::new(file).exists()) {
            let missing = format!("{key} = \"{missing}\": there is no such file or folder");
            return Err(PyFileNotFoundError::new_err(missing));
        }
        // The keyword is in the message.
        document.set(kind, key, value, "").or_refused()?;
    }
    Ok(document)
}

/// A value as TOML has it; a text is a number with its unit where a number is wanted, for a key that was written with its unit or
/// without.
fn toml_value(key: &str, value: &Bound<'_, PyAny>, number: Option<bool>) -> PyResult<toml::Value> {
    if value.cast::<PyBool>().is_ok() {
        return Ok(toml::Value::Boolean(value.extract()?));
    }
    let is_text = value.cast::<PyString>().is_ok();
    if let Some(says_unit) = number
        && (is_text || value.extract::<f64>().is_ok())
    {
        return number_for(key, says_unit, value).map(toml::Value::Float);
    }
    if let Ok(integer) = value.extract::<i64>() {
        return Ok(toml::Value::Integer(integer));
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(toml::Value::Float(number));
    }
    if is_text {
        return Ok(toml::Value::String(value.extract()?));
    }
    if let Ok(items) = value.try_iter() {
        let items = items.map(|item| toml_value(key, &item?, number));
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
