#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod library;
mod model;
mod rendering;
mod text_file;

pub use library::{Library, Material, MaterialError, Source};
pub use model::{Form, MaxwellBranch, Model, ModelError, SpringPot};
pub use rendering::{FullHistory, SampledModel};
pub use text_file::{TEXT_MOST, read_text};
