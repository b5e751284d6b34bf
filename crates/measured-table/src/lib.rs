#![doc = include_str!("../README.md")]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]
//!
//! The numbers are found first: `decoded` makes text of bytes, `find` blocks of numbers of text, `above` its `heading` among the
//! lines above it, `header` a quantity of a name, `errors` a column of errors beside it, `segments` the rows that belong together. `numbers` reads a record's
//! columns by what they mean, which `explain` tells, `text` columns by their names, of which that of the times may hold `instants`.

mod above;
mod column;
mod columns;
mod error;
mod errors;
mod explain;
mod find;
mod header;
mod heading;
mod instants;
mod keys;
mod lines;
mod numbers;
mod response;
mod segments;
mod text;
mod text_file;
mod unit;
#[cfg(feature = "workbook")]
mod workbook;

pub use column::{Choice, Column};
pub use columns::Columns;
pub use error::TableError;
pub use explain::ColumnRead;
pub use find::ROWS_MOST;
pub use header::words;
pub use keys::{COLUMNS, FROM, SKIP_BAD_ROWS};
pub use lines::{are_few, passed, rows_named};
pub use numbers::{Reader, Segment};
pub use response::{ResponseColumn, ResponseTable, has_frequencies, read_response};
pub use text::{RecordColumns, TextTable, read_record, read_table};
pub use text_file::{TABLE_MOST, TEXT_MOST, files_in, is_file, read_bytes, read_text};
