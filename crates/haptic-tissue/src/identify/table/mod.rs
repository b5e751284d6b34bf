//! Records out of tables as rheometers and testing machines write them.

mod assemble;
mod column;
mod header;
mod numbers;
mod text;
mod unit;

pub use assemble::{Columns, Reading, Understood};
pub use column::{Choice, Column};
pub use numbers::Reader;
pub use text::{
    RecordColumns, Signal, TABLE_MOST, TextTable, read_chosen, read_record, read_signal,
    read_table, rows_named,
};
