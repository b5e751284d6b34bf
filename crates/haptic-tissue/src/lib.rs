#![doc = include_str!("../README.md")]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod export;
#[cfg(feature = "identify")]
pub mod identify;
mod library;
mod material;
mod model;
mod rendering;
mod text_file;

pub use export::{ExportError, ExportFormat, PronyFit};
pub use library::Library;
pub use material::{Material, MaterialError, Source, ValidRange};
pub use model::{
    Form, MaxwellBranch, Model, ModelError, ModelKind, Parameter, ParameterRange, SpringPot,
};
pub use rendering::{FullHistory, SampledModel};
pub use text_file::{TEXT_MOST, open_file, read_text};
