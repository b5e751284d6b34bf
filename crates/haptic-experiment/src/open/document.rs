//! What a document is, as somebody sees it who knows all kinds: which of them it names, and the file that it makes.

use super::parameters::{
    DEVICE_MODEL, DEVICE_PLANT, DRIVE, DRIVE_TABLE, KINDS, MEASUREMENT, QUESTIONS, of_kind,
    takes_device,
};
use crate::document::error::FileError;
use crate::document::{Document, IN_LOG, choice, line};
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

    /// Puts the document among the provenance of a log, from which [`read`](Self::read) reads it.
    ///
    /// # Errors
    /// As those of [`kind`](Self::kind).
    pub fn keep_in(&self, provenance: &mut BTreeMap<String, String>) -> Result<(), FileError> {
        provenance.insert(IN_LOG.1.to_owned(), self.to_toml()?);
        Ok(())
    }
}
