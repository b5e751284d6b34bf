//! A document from a file, or from the log of a run.

use haptic_document::{Document, FileError, IN_LOG, text_of};
use haptic_log::record::inspect;
use std::path::Path;

/// A file, or the document in a run's log, `.mcap`, with the files that it names as they were
/// then.
///
/// # Errors
/// If it cannot be read, or a log is not whole or has none.
pub fn read_document(path: &Path) -> Result<Document, FileError> {
    let name = path.to_string_lossy().to_lowercase();
    let log = path.display();
    let refuse = |reason: String| FileError::wording("", reason);
    let is_table = |end: &str| name.ends_with(end) && path.exists();
    if [".csv", ".tsv", ".xls", ".xlsx"].into_iter().any(is_table) {
        return Err(refuse(format!(
            "`{log}` is a table, no experiment: `identify` makes a tissue of a record, `control identify` a plant"
        )));
    }
    if ![".mcap", ".mcap.part"]
        .iter()
        .any(|end| name.ends_with(end))
    {
        return Ok(Document::of_text(path, &text_of(path, "experiment")?));
    }
    let summary = inspect(path).map_err(|error| refuse(error.to_string()))?;
    let reasons = summary.reasons().join("; ");
    if !reasons.is_empty() {
        return Err(refuse(format!(
            "{log} is not whole, so it is not run again: {reasons}; give the file that it was run from"
        )));
    }
    let mut records = summary.metadata.into_iter();
    let record = records.find(|record| record.name == IN_LOG.0);
    let logged = record.map(|record| record.values).unwrap_or_default();
    match logged.get(IN_LOG.1).cloned() {
        Some(text) => Ok(Document::of_log(path, &text, logged)),
        None => Err(refuse(format!(
            "{log} does not hold the document of a run: give the file that it was run from"
        ))),
    }
}
