//! Answers of questions in the folder of the runs.

use haptic_experiment::Failure;
use haptic_experiment::lines;
use serde_json::{Value, json};
use std::path::Path;

/// Of an answer's file.
pub(super) const EXTENSION: &str = "answer.json";
/// The same behind its name.
pub(super) const SUFFIX: &str = ".answer.json";
/// Longest file that is read, bytes: some thousand points are a megabyte.
const LONGEST: u64 = 64 << 20;

/// True for the file of an answer.
pub(super) fn is_one(path: &Path) -> bool {
    path.to_str().is_some_and(|path| path.ends_with(SUFFIX))
}

/// Reads an answer: `kind`, `verdict`, `report`, its `lines`, `experiment`.
///
/// # Errors
/// A file that cannot be read or is none.
pub(super) fn read(path: &Path) -> Result<Value, Failure> {
    let none = |why: &dyn std::fmt::Display| {
        Failure::bad_input(format_args!(
            "{} is no answer: {why}; ask again",
            path.display()
        ))
    };
    let length = std::fs::metadata(path).map_err(|error| none(&error))?.len();
    if length > LONGEST {
        return Err(none(&format_args!("it is {length} bytes long")));
    }
    let text = std::fs::read(path).map_err(|error| none(&error))?;
    let mut answer: Value = serde_json::from_slice(&text).map_err(|error| none(&error))?;
    if answer["kind"].is_string() && answer["report"].is_object() {
        answer["lines"] = json!(lines(&answer["report"]));
        Ok(answer)
    } else {
        Err(none(&"it has no `kind` and `report`"))
    }
}
