#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(unreachable_pub)]

mod end;
pub mod flaw;
mod message;
mod tick;

pub use end::{DRIVE_END, END, EndKind, RunEnd};
pub use message::{
    ColumnValue, Encoding, EventMessage, Item, Layout, LogMessage, MessageError, MetadataRecord,
};
pub use tick::{AXES, PerAxis, TickColumn, TickMessage, TickSlot, column_name};
