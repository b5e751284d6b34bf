#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod error;
mod form;
mod header;
mod law;
mod name;
mod number;

pub use error::HeaderError;
pub use header::Header;
pub use law::Law;
pub use number::CNumber;
