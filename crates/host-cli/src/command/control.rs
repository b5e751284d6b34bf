//! `control`: fractional controllers, from a plant to a loop that runs.

mod analyze;
mod design;
mod draw;
mod identify;
mod loops;
mod simulate;

use crate::command::run_each;
use crate::output::Output;
use clap::Subcommand;
use haptic_experiment::Failure;

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Design(design::Arguments),
    Simulate(simulate::Arguments),
    Analyze(analyze::Arguments),
    Identify(identify::Arguments),
}

impl Command {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        run_each!(self, output, [Design Simulate Analyze Identify])
    }
}
