//! Tissues: models, the library, and models from records.

mod identified;
mod material;
mod model;
mod parameters;
mod records;

pub(crate) use identified::identify_record;
pub(crate) use material::{PyMaterial, find_material, library};
pub(crate) use model::{PyModel, restore_model};
pub(crate) use parameters::model_table;
