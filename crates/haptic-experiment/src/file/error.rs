//! A document that is wrong, and the place where it is.

use haptic_tissue::read_text;
use std::fmt;
use std::path::{Path, PathBuf};

/// A document that is wrong: where, and what about it. Prints as one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    place: Place,
    reason: String,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Place {
    /// Line of a file, from 1.
    Line(PathBuf, usize),
    /// An option or assignment, in the words of whoever gave it; empty for nowhere in particular.
    Said(String),
}

/// The text of a file; `kind` is that of the file, as in `experiment`.
///
/// # Errors
/// If it could not be read at all.
pub(crate) fn text_of(path: &Path, kind: &str) -> Result<String, FileError> {
    read_text(path).map_err(|error| {
        let reason = format!(
            "cannot read the {kind} file `{}`: {error}; give the path of a TOML file",
            path.display()
        );
        FileError::said("", reason)
    })
}

impl FileError {
    /// An error about what was said, as in `--strain 500%`.
    pub(crate) fn said(said: &str, reason: String) -> Self {
        Self {
            place: Place::Said(said.to_owned()),
            reason,
        }
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reason = &self.reason;
        match &self.place {
            Place::Line(path, line) => write!(f, "{}:{line}: {reason}", path.display()),
            Place::Said(said) if said.is_empty() => f.write_str(reason),
            Place::Said(said) => write!(f, "{said}: {reason}"),
        }
    }
}

impl std::error::Error for FileError {}

/// The text of a file, or of what was given, for messages.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a> {
    /// Empty where there is no file.
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
    /// How each line was said; empty for a file.
    pub(super) said: &'a [String],
}

impl Source<'_> {
    /// Lines before an offset.
    fn line(self, offset: usize) -> usize {
        let before = &self.text.as_bytes()[..offset.min(self.text.len())];
        before.iter().filter(|byte| **byte == b'\n').count()
    }

    /// How that was said; empty in a file or a form.
    pub(super) fn said_at(&self, offset: usize) -> &str {
        let said = self.said.get(self.line(offset));
        said.map_or("", String::as_str)
    }

    pub(super) fn fail(self, offset: usize, reason: impl Into<String>) -> FileError {
        let in_file = !self.path.as_os_str().is_empty();
        FileError {
            place: match in_file {
                true => Place::Line(self.path.to_owned(), 1 + self.line(offset)),
                false => Place::Said(self.said_at(offset).to_owned()),
            },
            // One line, whatever somebody wrote.
            reason: reason.into().replace('\n', "\\n"),
        }
    }
}
