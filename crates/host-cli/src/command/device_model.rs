//! The device file of an experiment or analysis.

use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::run::DeviceModel;
use std::path::PathBuf;

/// A device whose values are in a file.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Device")]
pub struct DeviceModelArguments {
    /// Device file, as host-cli device measure writes it, or `laboratory`, a usual device; an option of one of its values wins over it
    #[arg(long, value_name = "FILE.toml")]
    device_model: Option<PathBuf>,
}

impl DeviceModelArguments {
    /// True if a file was named.
    #[must_use]
    pub const fn is_given(&self) -> bool {
        self.device_model.is_some()
    }

    /// The device of the file, if one was named.
    ///
    /// # Errors
    /// A file that cannot be read or is wrong.
    pub fn read(&self) -> Result<Option<DeviceModel>, Failure> {
        let read = |name: &PathBuf| DeviceModel::find(name).map_err(Failure::input);
        self.device_model.as_ref().map(read).transpose()
    }
}
