//! Plant files: TOML, one table that says what is to be controlled, and perhaps `[source]`.
//!
//! ```toml
//! [transfer_function]                 # a function in notation, perhaps with a dead time
//! function = "1/(0.8s^2.2+0.5s^0.9+1)"
//! delay_s = 0.2
//! ```
//! `[device]` has the keys of a `[wall]`: mass, damping, hand, delay, current lag, friction, encoder, noise; force in, position out. Beside it
//! `[intervals]` says between which numbers its values lie, as a measurement writes it, see [`DeviceModel`]. `[state_space]` has `a`, `b`, `c`,
//! `delay_s` and `current_lag_s`. `[measured_response]` names a CSV, see [`read_response`].

mod device;
mod model;
mod read;
mod response;

use crate::document::error::FileError;
use crate::document::error::text_of;
use crate::document::parameters as p;
pub use device::DeviceModel;
use fractional_control::{ControlError, Plant};
pub use model::{DeviceValues, Interval, PlantFile, PlantModel};
pub use response::read_response;
use std::path::Path;

impl PlantFile {
    /// A plant without a story.
    #[must_use]
    pub const fn new(model: PlantModel) -> Self {
        Self {
            model,
            intervals: Vec::new(),
            program: String::new(),
            note: String::new(),
        }
    }

    /// Reads and checks a file.
    ///
    /// # Errors
    /// If it cannot be read or is wrong: in one line, with file and line.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::parse(path, &text_of(path, "plant")?)
    }

    /// Reads and checks the text of a file; `path` is for messages and for the table of a measured response.
    ///
    /// # Errors
    /// If it is wrong: in one line, with file and line.
    pub fn parse(path: &Path, text: &str) -> Result<Self, FileError> {
        read::parse(path, text)
    }

    /// The plant.
    ///
    /// # Errors
    /// As [`PlantModel::plant`].
    pub fn plant(&self) -> Result<Plant, ControlError> {
        self.model.plant()
    }

    /// The text of a file of a transfer function or of a device; `None` of anything else, which people write.
    #[must_use]
    pub fn to_toml(&self) -> Option<String> {
        let quoted = |words: &str| toml::Value::from(words).to_string();
        let mut text = match &self.model {
            PlantModel::Function { function, delay_s } => format!(
                "[transfer_function]\n{} = \"{function}\"\n{} = {delay_s:?}\n",
                p::FUNCTION.key,
                p::DEAD_TIME.key
            ),
            PlantModel::Device(values) => device::tables(values, &self.intervals),
            PlantModel::StateSpace { .. } | PlantModel::Measured(_) => return None,
        };
        let source = [
            (&p::SOURCE_PROGRAM, &self.program),
            (&p::SOURCE_NOTE, &self.note),
        ];
        let source = source.into_iter().filter(|(_, words)| !words.is_empty());
        let lines: String = source
            .map(|(parameter, words)| format!("{} = {}\n", parameter.key, quoted(words)))
            .collect();
        if !lines.is_empty() {
            text += &format!("\n[source]\n{lines}");
        }
        Some(text)
    }
}

#[cfg(test)]
mod tests;
