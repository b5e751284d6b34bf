//! A document that is wrong, and the place where it is.

use haptic_quantity::renamed;
use measured_table::read_text;
use std::{
    collections::BTreeMap,
    fmt,
    ops::Range,
    path::{Path, PathBuf},
};

/// An error in a document, with its place. It prints as one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    place: Place,
    /// Words of the file, before the reason: keys in them are those of the file, whatever a program calls them.
    of_file: String,
    reason: String,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Place {
    /// Line of a file, from 1, for what concerns a table or the file as a whole.
    Line(PathBuf, usize),
    Character(Excerpt),
    /// An option or assignment, in the words of whoever gave it; empty for nowhere in particular.
    Said(String),
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excerpt {
    /// The name as the user typed it, for messages.
    pub path: PathBuf,
    /// Line, from 1.
    pub line: usize,
    /// The text of that line.
    pub text: String,
    /// Byte offset of the character within it; none at its end.
    pub at: Range<usize>,
}

/// The text of a file; `kind` is that of the file, as in `experiment`.
///
/// # Errors
/// A file that cannot be read, or is no text.
pub fn text_of(path: &Path, kind: &str) -> Result<String, FileError> {
    read_text(path).map_err(|error| {
        let as_in = match path.extension() {
            None if error.kind() == std::io::ErrorKind::NotFound => {
                format!(", as {}", path.with_extension("toml").display())
            }
            _ => String::new(),
        };
        let reason = format!(
            "cannot read the {kind} file `{}`: {error}; give the path of a TOML file{as_in}",
            path.display()
        );
        FileError::wording("", reason)
    })
}

impl FileError {
    /// The position in the file, if the error has one.
    #[must_use]
    pub fn excerpt(&self) -> Option<&Excerpt> {
        match &self.place {
            Place::Character(excerpt) => Some(excerpt),
            Place::Line(..) | Place::Said(_) => None,
        }
    }

    /// An error about what was said, as in `--strain 500%`.
    pub fn wording(wording: &str, reason: impl fmt::Display) -> Self {
        Self {
            place: Place::Said(wording.to_owned()),
            of_file: String::new(),
            reason: reason.to_string(),
        }
    }

    /// Marks the reason as words of the file and puts this one behind it.
    pub fn of_file(self, reason: String) -> Self {
        Self {
            of_file: self.reason,
            reason,
            ..self
        }
    }

    /// Its line, with keys of the reason as `names` calls them, see [`renamed`].
    pub fn named(&self, names: impl Fn(&str) -> Option<String>) -> String {
        let reason = format!("{}{}", self.of_file, renamed(&self.reason, names));
        match &self.place {
            Place::Line(path, line) | Place::Character(Excerpt { path, line, .. }) => {
                format!("{}:{line}: {reason}", path.display())
            }
            Place::Said(wording) if wording.is_empty() => reason,
            Place::Said(wording) => format!("{wording}: {reason}"),
        }
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.named(|_| None))
    }
}

impl std::error::Error for FileError {}

/// The text of a file, or of what was given, for messages.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source<'a> {
    /// Empty where there is no file.
    pub path: &'a Path,
    pub text: &'a str,
    /// The words in which each line was given; empty for a file.
    pub wording: &'a [String],
    /// Metadata from the log of this document's run.
    pub logged: Option<&'a BTreeMap<String, String>>,
}

impl Source<'_> {
    fn line(self, offset: usize) -> usize {
        let before = &self.text.as_bytes()[..offset.min(self.text.len())];
        before.iter().filter(|byte| **byte == b'\n').count()
    }

    /// The words in which the value at this offset was given; empty in a file or a form.
    pub(crate) fn said_at(&self, offset: usize) -> &str {
        let wording = self.wording.get(self.line(offset));
        wording.map_or("", String::as_str)
    }

    fn excerpt(self, offset: usize) -> Excerpt {
        let line = self.line(offset);
        let text = self.text.lines().nth(line).unwrap_or_default();
        let before = self.text.get(..offset).unwrap_or_default();
        let start = before.rfind('\n').map_or(0, |end| end + 1);
        let before = text.get(..offset - start).unwrap_or(text).len();
        let at = text[before..].chars().next();
        let at = before..before + at.map_or(0, char::len_utf8);
        Excerpt {
            path: self.path.to_owned(),
            line: 1 + line,
            text: text.to_owned(),
            at,
        }
    }

    /// An error about the character there.
    pub(crate) fn fail(self, offset: usize, reason: impl fmt::Display) -> FileError {
        self.failed(offset, reason, || Place::Character(self.excerpt(offset)))
    }

    /// An error about what begins there.
    pub(crate) fn fail_from(self, offset: usize, reason: impl fmt::Display) -> FileError {
        let line = || Place::Line(self.path.to_owned(), 1 + self.line(offset));
        self.failed(offset, reason, line)
    }

    fn failed(
        self,
        offset: usize,
        reason: impl fmt::Display,
        in_file: impl FnOnce() -> Place,
    ) -> FileError {
        let reason = reason.to_string();
        FileError {
            place: if self.path.as_os_str().is_empty() {
                Place::Said(self.said_at(offset).to_owned())
            } else {
                in_file()
            },
            of_file: String::new(),
            // One line, whatever somebody wrote.
            reason: reason.replace('\n', "\\n"),
        }
    }
}
