//! Failure of a command: an error, and an exit code that scripts can rely on.

use crate::document::parameters::OVERWRITE;
use haptic_log::record::{NewFileError, RecordError};
use std::fmt;

/// A command that did not succeed: what went wrong, in one line, by whom to be mended.
///
/// Exit codes: 0 done (also when the reader of our output went away) · 1 the run failed, was
/// interrupted, or a latched fault ended it · 2 bad usage or bad input · 3 device or link not
/// usable, or lost · 4 data was lost, what could be kept was kept. 3 goes before 1, and 1 before 4.
#[derive(Debug)]
pub enum Failure {
    /// Exit code 1.
    Run(anyhow::Error),
    /// Exit code 2.
    Input(anyhow::Error),
    /// Exit code 3.
    Device(anyhow::Error),
    /// Exit code 4.
    DataLost(anyhow::Error),
    /// Exit code 0: nobody reads our output any more.
    BrokenPipe,
}

impl Failure {
    /// Bad input, in the error's own words.
    pub fn input(error: impl Into<anyhow::Error>) -> Self {
        Self::Input(error.into())
    }

    /// Bad input, in these words.
    pub fn bad_input(message: impl fmt::Display) -> Self {
        Self::Input(anyhow::anyhow!("{message}"))
    }

    /// Bad input, in the error's own words, and what to do about it.
    pub fn input_with_advice(error: impl fmt::Display, advice: impl fmt::Display) -> Self {
        Self::bad_input(format_args!("{error}: {advice}"))
    }

    /// Output that could not be written: data lost on a full disk, else bad input, as a place that is not
    /// writable. `what` says which.
    pub fn writing(error: std::io::Error, what: impl fmt::Display) -> Self {
        let full = is_full(&error);
        let error = anyhow::Error::new(error).context(what.to_string());
        if full {
            Self::DataLost(error)
        } else {
            Self::Input(error)
        }
    }

    /// The same, and these words behind its own.
    #[must_use]
    pub fn and(self, words: &str) -> Self {
        let more = anyhow::anyhow!("{self}: {words}");
        match self {
            Self::Run(_) => Self::Run(more),
            Self::Input(_) => Self::Input(more),
            Self::Device(_) => Self::Device(more),
            Self::DataLost(_) => Self::DataLost(more),
            Self::BrokenPipe => Self::BrokenPipe,
        }
    }

    /// A run that somebody stopped.
    pub(crate) fn interrupted() -> Self {
        Self::Run(anyhow::anyhow!("interrupted"))
    }

    /// The exit code.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::BrokenPipe => 0,
            Self::Run(_) => 1,
            Self::Input(_) => 2,
            Self::Device(_) => 3,
            Self::DataLost(_) => 4,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Run(error) | Self::Input(error) | Self::Device(error) | Self::DataLost(error) => {
                // The whole chain in one line; many an error already says its cause.
                let mut text = error.to_string();
                for cause in error.chain().skip(1).map(ToString::to_string) {
                    if !text.contains(&cause) {
                        text = format!("{text}: {cause}");
                    }
                }
                f.write_str(&text)
            }
            Self::BrokenPipe => f.write_str("nobody reads the output"),
        }
    }
}

// The text has the whole chain, so there is no source beside it.
impl std::error::Error for Failure {}

impl From<RecordError> for Failure {
    fn from(error: RecordError) -> Self {
        match error {
            RecordError::Write { .. }
            | RecordError::Lost { .. }
            | RecordError::Copy { .. }
            | RecordError::Csv { .. } => Self::DataLost(error.into()),
            RecordError::File(error) => error.into(),
            RecordError::Message(_) | RecordError::Time { .. } => Self::Run(error.into()),
            _ => Self::Input(error.into()),
        }
    }
}

/// True if the disk, or the share of it that one may use, is full.
fn is_full(error: &std::io::Error) -> bool {
    use std::io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull, WriteZero};
    matches!(
        error.kind(),
        StorageFull | QuotaExceeded | FileTooLarge | WriteZero
    )
}

impl From<NewFileError> for Failure {
    fn from(error: NewFileError) -> Self {
        match &error {
            NewFileError::Io { source, .. } if is_full(source) => Self::DataLost(error.into()),
            NewFileError::Exists(path) => Self::bad_input(format_args!(
                "`{}` already exists: choose another name, move it away, or give {OVERWRITE}",
                path.display()
            )),
            _ => Self::Input(error.into()),
        }
    }
}
