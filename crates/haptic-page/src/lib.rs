#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

pub mod frame;
pub mod pyramid;
