#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(unreachable_pub)]

pub mod alone;
pub mod channels;
pub mod control;
pub mod dropped;
pub mod feel;
pub mod form;
pub mod hello;
pub mod identify;
pub mod live;
pub mod pyramid;
pub mod question;
pub mod request;
mod scheme;
pub mod surface;
pub mod wall;
pub mod words;

pub use words::{Number, TextFile};
