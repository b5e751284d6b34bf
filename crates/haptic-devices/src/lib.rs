#![doc = include_str!("../README.md")]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod at_line;
mod foreign;
pub mod haply;
pub mod moteus;
mod name;
mod near_line;

pub use at_line::AtLine;
pub use foreign::{ForeignName, OpenError};
pub use name::{NameError, Settings};
pub use near_line::NearLine;
