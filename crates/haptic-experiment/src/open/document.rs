//! What a document is, as somebody sees it who knows all kinds: which of them it names, and the file that it makes.

use super::parameters::{
    DEVICE_MODEL, DEVICE_PLANT, DRIVE, DRIVE_TABLE, KINDS, MEASUREMENT, QUESTIONS, of_kind,
    takes_device,
};
use crate::document::error::FileError;
use crate::document::parameters::{Parameter, Value};
use crate::document::reader::Table;
use crate::document::{Document, IN_LOG, choice, line};
use crate::experiment::reading::with_devices;
use std::collections::BTreeMap;

impl Document {
    /// The kind of the experiment or question: the name of its table.
    ///
    /// # Errors
    /// A file that is not TOML, or has no table of a kind.
    pub fn kind(&self) -> Result<&'static str, FileError> {
        let parsed = self.parse()?;
        let kinds = KINDS.into_iter().chain(QUESTIONS);
        kinds
            .chain([MEASUREMENT])
            .find(|kind| parsed.has(kind))
            .ok_or_else(|| parsed.fail(format!("no experiment: {}", choice(&KINDS))))
    }

    /// The document as one file: what was given, here or in the file, and the other defaults as comments. Paths are absolute, so it may lie anywhere.
    ///
    /// # Errors
    /// As those of [`kind`](Self::kind).
    pub fn to_toml(&self) -> Result<String, FileError> {
        let kind = self.kind()?;
        let parsed = self.parse()?;
        let mut text = String::new();
        for (name, table) in parsed.tables(&[kind, DRIVE_TABLE], "")? {
            text += &format!("[{name}]\n");
            let known = match name {
                DRIVE_TABLE => vec![(name, DRIVE)],
                kind => of_kind(kind),
            };
            for parameter in known.iter().flat_map(|(_, parameters)| *parameters) {
                // What a device file above it says is not read.
                let of_device = takes_device(kind) && DEVICE_PLANT.contains(parameter);
                if !(of_device && table.lies_below(parameter, &DEVICE_MODEL)) {
                    text += &line(&table, parameter);
                }
            }
        }
        Ok(text)
    }

    /// Puts the document among the provenance of a log, from which [`read`](Self::read) reads it, and beside it the kind and each
    /// key with its value, given or by default.
    ///
    /// # Errors
    /// As those of [`kind`](Self::kind); a value that is not of its kind.
    pub fn keep_in(&self, provenance: &mut BTreeMap<String, String>) -> Result<(), FileError> {
        let kind = self.kind()?;
        let mut keep = |key: &str, value: String| provenance.insert(key.to_owned(), value);
        keep("experiment", kind.to_owned());
        let parsed = self.parse()?;
        for (name, table) in parsed.tables(&[kind, DRIVE_TABLE], "")? {
            let table = match takes_device(name) {
                true => with_devices(table)?,
                false => table,
            };
            let known = match name {
                DRIVE_TABLE => vec![(name, DRIVE)],
                kind => of_kind(kind),
            };
            for parameter in known.iter().flat_map(|(_, parameters)| *parameters) {
                if let Some(value) = in_words(&table, parameter)? {
                    keep(parameter.key, value);
                }
            }
        }
        keep(IN_LOG.1, self.to_toml()?);
        Ok(())
    }
}

/// The value of a parameter as a log has it: numbers with spaces between them, rows with semicolons.
fn in_words(table: &Table<'_>, parameter: &Parameter) -> Result<Option<String>, FileError> {
    let row = |numbers: Vec<f64>| {
        let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
        numbers.join(" ")
    };
    Ok(match parameter.value {
        Value::Number(default, _) => {
            let number = table.number_if(parameter)?.or(default);
            number.map(|number| number.to_string())
        }
        Value::Count(_) => Some(table.count(parameter)?.to_string()),
        Value::Flag(_) => Some(table.flag(parameter)?.to_string()),
        Value::Text(_) => Some(table.text(parameter)?.to_owned()).filter(|text| !text.is_empty()),
        Value::List(_) => match table.numbers_if(parameter) {
            Ok(numbers) => numbers.map(row),
            Err(_) => {
                let rows = table.matrix_if(parameter)?;
                rows.map(|rows| rows.into_iter().map(row).collect::<Vec<_>>().join("; "))
            }
        },
    })
}
