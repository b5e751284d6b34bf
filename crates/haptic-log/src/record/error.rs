//! Errors of a log.

use std::{
    io,
    path::{Path, PathBuf},
};

use super::{NewFileError, SpanError};
use haptic_message::MessageError;

/// An error of the run log. The message is one line and says what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The file could not be created or could not get its name.
    #[error(transparent)]
    File(#[from] NewFileError),
    /// Writing failed while the run went on, as on a full disk. The file named stays.
    #[error("writing the log `{}` failed: {source}; {}", .path.display(), rest(*.samples_safe))]
    Write {
        /// The unfinished file, which keeps what is safe.
        path: PathBuf,
        /// Samples up to the last chunk the operating system took.
        samples_safe: u64,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The unfinished file was removed, emptied or cut by somebody else while the run went on.
    #[error(
        "the log `{}` is lost: it was {what} while the run wrote to it, {samples} samples in all; leave the folder of a run alone until it has ended, and \
         make the run again",
        .path.display()
    )]
    Lost {
        /// The name that it has until it is complete, under which it stays.
        path: PathBuf,
        /// Damage to the file, as "removed".
        what: &'static str,
        /// Samples that were written to it.
        samples: u64,
    },
    /// A copy could not be written; the log it was made from is as it was.
    #[error("writing `{}` failed: {source}; nothing was left behind under that name, the log it was made from is untouched: make space and try again", .path.display())]
    Copy {
        /// The file that the message names.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// Reading failed, as on a damaged disk; not used for damage inside a log.
    #[error("cannot read `{}`: {source}", .path.display())]
    Read {
        /// The file that the message names.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The file is something else.
    #[error("`{}` is not an MCAP log: {found}; give a file that host-cli has written (NAME.mcap or NAME.mcap.part)", .path.display())]
    NotMcap {
        /// The file that the message names.
        path: PathBuf,
        /// Start of the file instead.
        found: String,
    },
    /// There are messages in it, but none that could go into a table of ticks.
    #[error("`{}` has no ticks: its topics are {}; give a log that host-cli has written, with `/haptics/tick`", .path.display(), .topics.join(", "))]
    NoTicks {
        /// The file that the message names.
        path: PathBuf,
        /// The topics that it has instead.
        topics: Vec<String>,
    },
    /// No columns of numbers could be taken from a log of others.
    #[error("`{}` {why}; its topics are {}", .path.display(), .topics.join(", "))]
    Topics {
        /// The file that the message names.
        path: PathBuf,
        /// Reason, as "has several topics".
        why: &'static str,
        /// Its topics, each with what is known of it.
        topics: Vec<String>,
    },
    /// A message carries a time no log can hold.
    #[error(
        "device time {time_s} s is not in [0, 1.8e10] s; the log keeps it as unsigned nanoseconds"
    )]
    Time {
        /// The time that was given, s.
        time_s: f64,
    },
    /// A log has no such span.
    #[error(transparent)]
    Span(#[from] SpanError),
    /// A message could not be encoded.
    #[error(transparent)]
    Message(#[from] MessageError),
    /// The CSV could not be written.
    #[error("writing `{}` failed: {source}; nothing was left behind under that name", .path.display())]
    Csv {
        /// The file that the message names.
        path: PathBuf,
        /// Error of the CSV writer.
        source: csv::Error,
    },
}

/// Samples that are safe in a log, and the remedy.
fn rest(samples_safe: u64) -> String {
    match samples_safe {
        0 => "no sample is in it: remove it, make space and try again".to_owned(),
        count => format!(
            "{count} samples are safe in it; make space, then save them with `host-cli log recover`"
        ),
    }
}

impl RecordError {
    pub(crate) fn read(path: &Path, source: io::Error) -> Self {
        let path = path.to_owned();
        Self::Read { path, source }
    }
}

/// The I/O error inside an error of the MCAP library, so that one line says the cause.
pub(crate) fn io_error(error: mcap::McapError) -> io::Error {
    let reason = error.to_string();
    if let mcap::McapError::Io(error) = error {
        return error;
    }
    io::Error::other(reason)
}
