//! Options of the controller that holds the indenter.

use crate::within::within;
use clap::Args;
use haptic_experiment::failure::Failure;
use haptic_experiment::{Drive, parameters};
use haptic_quantity::Force;
use std::path::PathBuf;

/// Arguments of every experiment on the rig.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Rig")]
pub struct DriveArguments {
    #[arg(long, help = parameters::CONTROLLER.help, value_name = "FILE.toml")]
    drive: Option<PathBuf>,
    #[arg(long, value_parser = within::<Force>(parameters::DRIVE_FORCE_LIMIT.range()), help = crate::parameter::help_with_default(&parameters::DRIVE_FORCE_LIMIT), value_name = "FORCE", allow_hyphen_values = true)]
    drive_force_limit: Option<Force>,
}

impl DriveArguments {
    /// The drive; what is not given is as in `file`.
    ///
    /// # Errors
    /// A controller file that is wrong; a limit of no drive.
    pub fn over(&self, file: Option<Drive>) -> Result<Option<Drive>, Failure> {
        let read = self.drive.as_deref().map(Drive::read).transpose();
        let given = read.map_err(Failure::input)?;
        // The limit of the motor stays with another controller.
        let drive = match (given, file) {
            (Some(given), Some(file)) => Some(Drive {
                force_limit_n: file.force_limit_n,
                ..given
            }),
            (given, file) => given.or(file),
        };
        match (drive, self.drive_force_limit) {
            (Some(drive), Some(limit)) => Ok(Some(Drive {
                force_limit_n: limit.0,
                ..drive
            })),
            (None, Some(_)) => Err(Failure::bad_input(
                "--drive-force-limit has no effect without a drive: add --drive FILE.toml, or leave it out",
            )),
            (drive, None) => Ok(drive),
        }
    }
}
