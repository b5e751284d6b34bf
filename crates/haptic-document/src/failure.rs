//! Failure of a command: an error, by whom to be mended.

use crate::FileError;
use haptic_quantity::renamed;
use std::{fmt, io, path::Path};
use thiserror::Error;

/// A command that did not succeed: what kind of failure it is, and its [`Cause`]. If several apply,
/// a device failure takes precedence over a failed run, and that over lost data.
#[derive(Debug, Error)]
pub enum Failure {
    /// The run failed, was interrupted, or a latched fault ended it.
    #[error("{0}")]
    Run(Cause),
    /// The input cannot be used.
    #[error("{0}")]
    Input(Cause),
    /// The device or the link to it cannot be used, or was lost.
    #[error("{0}")]
    Device(Cause),
    /// Data was lost; what could be kept was kept.
    #[error("{0}")]
    DataLost(Cause),
}

/// The cause of a [`Failure`]. Prints as one line.
#[derive(Debug, Error)]
pub enum Cause {
    /// A sentence, which names keys as [`haptic_quantity::Key`] does.
    #[error("{0}")]
    Words(String),
    /// A document is wrong; it knows the place.
    #[error(transparent)]
    Document(Box<FileError>),
    /// A log or another file cannot be read or written.
    #[error(transparent)]
    File(Box<dyn std::error::Error + Send + Sync>),
    /// Something that cannot be made, by the name that somebody gave it, and the remedy, as a sentence.
    #[error("{0}: {1}")]
    Name(String, String),
    /// The operating system refused this, which may have a name that somebody gave; advice, from its colon on, is a sentence.
    #[error("{0}{1}: {2}")]
    System(String, String, #[source] io::Error),
}

/// Bad input, in the words of a format string: [`Failure::bad_input`].
#[macro_export]
macro_rules! bad_input {
    ($($words:tt)+) => {
        $crate::Failure::bad_input(format_args!($($words)+))
    };
}

impl Failure {
    /// A run that failed, in these words.
    pub fn run(words: impl fmt::Display) -> Self {
        Self::Run(Cause::Words(words.to_string()))
    }

    /// Bad input, in the error's own words.
    pub fn input(error: impl std::error::Error) -> Self {
        Self::bad_input(error)
    }

    /// Bad input, in these words.
    pub fn bad_input(words: impl fmt::Display) -> Self {
        Self::Input(Cause::Words(words.to_string()))
    }

    /// Bad input, in the error's own words, and what to do about it.
    pub fn input_with_advice(error: impl fmt::Display, advice: impl fmt::Display) -> Self {
        Self::bad_input(format_args!("{error}: {advice}"))
    }

    /// A device that cannot be used, in these words.
    pub fn device(words: impl fmt::Display) -> Self {
        Self::Device(Cause::Words(words.to_string()))
    }

    /// Data that was lost, in these words.
    pub fn data_lost(words: impl fmt::Display) -> Self {
        Self::DataLost(Cause::Words(words.to_string()))
    }

    /// The failure of an output that could not be written: lost data on a full disk, otherwise bad
    /// input, such as a path that is not writable. `what` names the output.
    pub fn writing(error: io::Error, what: impl fmt::Display) -> Self {
        Self::writing_with_advice(error, what, String::new())
    }

    /// Failure as by [`writing`](Self::writing), with advice behind the name of the output.
    pub fn writing_with_advice(error: io::Error, what: impl fmt::Display, advice: String) -> Self {
        let full = is_full(&error);
        let kind = if full { Self::DataLost } else { Self::Input };
        kind(Cause::System(what.to_string(), advice, error))
    }

    /// A file is there already.
    pub fn exists(path: &Path, advice: String) -> Self {
        let exists = format!("`{}` already exists", path.display());
        Self::Input(Cause::Name(exists, advice))
    }

    /// Appends these words to the failure.
    #[must_use]
    pub fn and(self, words: &str) -> Self {
        let more = Cause::Words(format!("{self}: {words}"));
        match self {
            Self::Run(_) => Self::Run(more),
            Self::Input(_) => Self::Input(more),
            Self::Device(_) => Self::Device(more),
            Self::DataLost(_) => Self::DataLost(more),
        }
    }

    /// A run that somebody stopped.
    pub fn interrupted() -> Self {
        Self::run("interrupted")
    }

    /// The cause, whatever kind of failure it is.
    #[must_use]
    pub const fn cause(&self) -> &Cause {
        let (Self::Run(cause) | Self::Input(cause) | Self::Device(cause) | Self::DataLost(cause)) =
            self;
        cause
    }
}

impl Cause {
    /// The message, with keys renamed by `names`, see [`renamed`].
    pub fn named(&self, names: impl Fn(&str) -> Option<String>) -> String {
        match self {
            Self::Words(words) => renamed(words, names),
            Self::Document(error) => error.named(names),
            Self::Name(what, advice) => format!("{what}: {}", renamed(advice, names)),
            Self::System(what, advice, error) => {
                format!("{what}{}: {error}", renamed(advice, names))
            }
            Self::File(_) => self.to_string(),
        }
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::Input(Cause::Document(Box::new(error)))
    }
}

/// True if the disk, or the share of it that one may use, is full.
#[must_use]
pub fn is_full(error: &io::Error) -> bool {
    use io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull, WriteZero};
    matches!(
        error.kind(),
        StorageFull | QuotaExceeded | FileTooLarge | WriteZero
    )
}

/// Hears what a user should know before a run or an answer is over, a sentence each.
pub type Warn<'a> = &'a (dyn Fn(&str) + Sync);
