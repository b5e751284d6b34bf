//! Controller files: TOML, one table for the controller, `[loop]` for how it runs, `[source]` for where it comes from.
//!
//! ```toml
//! [pid]                               # or [tid], [crone], [lead_lag], [transfer_function]
//! proportional_gain = 2.0
//! integral_gain_per_s_lambda = 1.0
//! integral_order = 0.8
//! derivative_gain_s_mu = 0.1
//! derivative_order = 0.6
//!
//! [loop]
//! sample_time_s = 0.01
//! output_low = -3.0
//! output_high = 3.0
//!
//! [source]
//! plant = "1/(0.8s^2.2+0.5s^0.9+1)"
//! ```

mod content;
mod read;
mod write;

pub use content::{ControllerFile, ControllerOrigin};

use crate::document::error::{FileError, text_of};
use std::path::Path;

impl ControllerFile {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// If it cannot be read or is wrong: in one line, with file and line.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::parse(path, &text_of(path, "controller")?)
    }

    /// Reads and checks the text of a file; `path` is for messages.
    ///
    /// # Errors
    /// If it is wrong: in one line, with file and line.
    pub fn parse(path: &Path, text: &str) -> Result<Self, FileError> {
        read::parse(path, text)
    }

    /// The text of a file that reads back to the same.
    #[must_use]
    pub fn to_toml(&self) -> String {
        write::toml(self)
    }
}

#[cfg(test)]
mod tests;
