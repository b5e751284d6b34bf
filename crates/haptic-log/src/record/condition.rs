//! Condition of a log: whole, or with parts that could not be read.

use std::fmt;
use std::path::PathBuf;

/// A part of a log that could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Damage {
    /// The file ends in the middle, as after a crash or with `.part` files.
    Cut {
        /// Bytes in the file.
        at_byte: u64,
    },
    /// One chunk, up to 100 ms of samples, is damaged; reading went on behind it.
    Chunk {
        /// End of the chunk, bytes from the start of the file; near enough to look at.
        at_byte: u64,
        /// Cause of the damage.
        cause: String,
    },
    /// One record is damaged; reading went on behind it.
    Record {
        /// End of the record, bytes from the start of the file.
        at_byte: u64,
        /// Cause of the damage.
        cause: String,
    },
    /// The records no longer follow each other; nothing behind this place could be read.
    Structure {
        /// Bytes read up to here.
        at_byte: u64,
        /// Cause of the damage.
        cause: String,
    },
    /// A file that the log goes on in is not there.
    Missing {
        /// The file.
        file: PathBuf,
    },
    /// Everything could be read, but the checksum of the whole says that some byte has changed.
    Checksum {
        /// The two sums.
        cause: String,
    },
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cut { at_byte } => write!(f, "the file ends unfinished after {at_byte} bytes"),
            Self::Chunk { at_byte, cause } => {
                write!(
                    f,
                    "a chunk of samples near byte {at_byte} is damaged: {cause}"
                )
            }
            Self::Record { at_byte, cause } => {
                write!(f, "a record near byte {at_byte} is damaged: {cause}")
            }
            Self::Structure { at_byte, cause } => {
                write!(f, "nothing after about byte {at_byte} can be read: {cause}")
            }
            Self::Missing { file } => {
                write!(
                    f,
                    "the log goes on in `{}`, which is not there",
                    file.display()
                )
            }
            Self::Checksum { cause } => write!(f, "some byte has changed: {cause}"),
        }
    }
}

/// Condition of a log that has been read to its end.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Condition {
    /// The log was finished by its writer and no part of it is damaged.
    pub complete: bool,
    /// Damage: parts that could not be read.
    pub damage: Vec<Damage>,
    /// Messages on topics that are not ours; they are passed over.
    pub foreign_messages: u64,
}
