#![doc = include_str!("../README.md")]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

#[cfg(feature = "identify")]
pub mod identify;
mod library;
mod model;
mod text_file;

pub use library::{Library, Material, MaterialError, Source};
pub use model::{Form, MaxwellBranch, Model, ModelError, SpringPot};
pub use text_file::{TEXT_MOST, read_text};
