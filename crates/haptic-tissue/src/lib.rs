#![doc = include_str!("../README.md")]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod export;
mod full_history;
pub mod indentation;
mod library;
mod material;
mod model;
mod sampled;

pub use export::{Card, ExportError, ExportFormat, PronyFit};
pub use full_history::FullHistory;
pub use library::Library;
pub use material::{Material, MaterialError, MeasuredLoading, STIFFENING, Source, ValidRange};
pub use model::{MaxwellBranch, Model, ModelError, ModelKind, ModelParameter, ParameterRange};
pub use sampled::SampledModel;
