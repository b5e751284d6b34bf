//! A file that is wrong, and the line where it is.

use haptic_tissue::read_text;
use std::fmt;
use std::path::{Path, PathBuf};

/// A file that is wrong: where, and what about it. Prints as one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    path: PathBuf,
    /// From 1; `None` for a file that could not be read.
    line: Option<usize>,
    reason: String,
}

/// The text of a file; `kind` is that of the file, as in `experiment`.
///
/// # Errors
/// If it could not be read at all.
pub(crate) fn text_of(path: &Path, kind: &str) -> Result<String, FileError> {
    read_text(path).map_err(|error| FileError {
        path: path.to_owned(),
        line: None,
        reason: format!(
            "cannot read the {kind} file `{}`: {error}; give the path of a TOML file",
            path.display()
        ),
    })
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (path, reason) = (self.path.display(), &self.reason);
        match self.line {
            Some(line) => write!(f, "{path}:{line}: {reason}"),
            None => f.write_str(reason),
        }
    }
}

impl std::error::Error for FileError {}

/// A file and its text, for messages.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a> {
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
}

impl Source<'_> {
    pub(super) fn fail(self, offset: usize, reason: impl Into<String>) -> FileError {
        let before = &self.text.as_bytes()[..offset.min(self.text.len())];
        FileError {
            path: self.path.to_owned(),
            line: Some(1 + before.iter().filter(|byte| **byte == b'\n').count()),
            reason: reason.into(),
        }
    }
}
