//! `analyze`: what is stable, passive and transparent, before any hardware.

mod arguments;
mod coupling;
mod effective;
mod passivity;
mod path;
mod region;
mod sensitivity;
mod stability;
mod teleoperation;

use crate::output::Output;
pub use arguments::Files;
use clap::Subcommand;
use haptic_experiment::Failure;

/// The question asked.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Effective stiffness and damping of a virtual environment
    Environment(effective::EnvironmentArguments),
    /// Is this wall stable?
    Stability(stability::VerdictArguments),
    /// All stable walls: the region in the alpha-beta plane
    StabilityRegion(region::RegionArguments),
    /// Is this wall passive, and how much damping does that take?
    Passivity(passivity::PassivityArguments),
    /// Is a virtual coupler passive on both sides, and how much damping does that take?
    Coupling(coupling::CouplingArguments),
    /// Two hands over a line: stable up to which delay, what is felt, and the best coupler
    #[command(long_about = teleoperation::LONG_ABOUT)]
    Teleoperation(teleoperation::TeleoperationArguments),
    /// Effective stiffness and damping of the closed loop, as the hand feels them
    Transparency(effective::TransparencyArguments),
    /// Gain of the loop on errors of its model: |1/(1 + GH)|
    Sensitivity(sensitivity::SensitivityArguments),
}

impl Command {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range; files that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        match self {
            Self::Environment(arguments) => arguments.run(output),
            Self::Stability(arguments) => arguments.run(output),
            Self::StabilityRegion(arguments) => arguments.run(output),
            Self::Passivity(arguments) => arguments.run(output),
            Self::Coupling(arguments) => arguments.run(output),
            Self::Teleoperation(arguments) => arguments.run(output),
            Self::Transparency(arguments) => arguments.run(output),
            Self::Sensitivity(arguments) => arguments.run(output),
        }
    }
}
