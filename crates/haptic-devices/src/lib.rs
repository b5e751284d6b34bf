#![doc = include_str!("../README.md")]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod foreign;
pub mod haply;
pub mod inverse3;
pub mod moteus;
mod name;

pub use foreign::{ForeignName, OpenError};
pub use name::NameError;
