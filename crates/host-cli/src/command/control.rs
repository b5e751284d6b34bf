//! `control`: fractional controllers, from a plant to a loop that runs.

mod analyze;
mod design;
mod draw;
mod identify;
mod loops;
mod simulate;
mod words;

use crate::output::Output;
use clap::Subcommand;
use haptic_experiment::Failure;
pub(crate) use loops::ControllerOption;
pub(crate) use words::refused;

/// The task.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Tune a fractional PID and compare it with the best integer-order PID
    #[command(long_about = design::LONG_ABOUT)]
    Design(design::Arguments),
    /// Run a step or a record through a loop, or a plant alone
    #[command(long_about = simulate::LONG_ABOUT)]
    Simulate(simulate::Arguments),
    /// Judge whether a loop is stable, why and by how much; or list the poles of a plant
    #[command(long_about = analyze::LONG_ABOUT)]
    Analyze(analyze::Arguments),
    /// Fit a fractional transfer function to a record
    #[command(long_about = identify::LONG_ABOUT)]
    Identify(identify::Arguments),
}

impl Command {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        match self {
            Self::Design(arguments) => arguments.run(output),
            Self::Simulate(arguments) => arguments.run(output),
            Self::Analyze(arguments) => arguments.run(output),
            Self::Identify(arguments) => arguments.run(output),
        }
    }
}
