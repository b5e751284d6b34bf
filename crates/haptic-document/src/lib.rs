#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(unreachable_pub)]

mod document;
mod error;
mod failure;
mod named;
pub mod parameters;
mod reader;
mod rows;

pub use document::{Document, IN_LOG, Parsed, ReadDocument, choice, lines_of};
pub use error::{Excerpt, FileError, text_of};
pub use failure::{Cause, Failure, Warn, is_full};
pub use haptic_quantity::short;
pub use named::Named;
pub use reader::{Interval, Table};
pub use rows::{ReportLine, ReportTable, Row, Rows, lines, rows};
