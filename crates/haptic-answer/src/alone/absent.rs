//! Refusals of what a page alone has not: files, and a machine.

use crate::form::Files;
use haptic_document::{Failure, FileError};

/// Files that a form names are not there.
pub(super) const NO_FILES: Files = Files {
    check: |key, path| {
        Err(Failure::bad_input(format_args!(
            "`{key}`: this page opens no file {}: use `host-cli serve`",
            path.display()
        )))
    },
    read: |path| {
        Err(FileError::wording(
            &path.display().to_string(),
            "no file in this page",
        ))
    },
};

/// A refusal of what needs a machine.
pub(super) fn needs(what: &str) -> Failure {
    Failure::bad_input(format_args!(
        "this page has nothing but the browser, and {what}"
    ))
}
