//! Records out of tables as rheometers and testing machines write them.
//!
//! The numbers are found first: `decoded` makes text of bytes, `find` blocks of numbers of text, `above` its `heading` among the
//! lines above it, `header` a quantity of a name, `segments` the rows that belong together. `numbers` reads a record's
//! columns by what they mean, `text` columns by their names.

mod above;
mod assemble;
mod column;
mod find;
mod header;
mod heading;
mod lines;
mod numbers;
mod segments;
mod text;
mod unit;

pub use assemble::{Columns, Reading, Understood};
pub use column::{Choice, Column};
pub use lines::rows_named;
pub use numbers::{Reader, Segment};
pub use text::{RecordColumns, TABLE_MOST, TextTable, read_chosen, read_record, read_table};
