//! `creep`: strain under a held force.

use super::experiment::RunArguments;
use crate::keys;
use crate::options::Options;
use crate::output::Output;
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::document::Document;

pub(crate) const LONG_ABOUT: &str = "\
Creep: the indenter pushes a virtual tissue with a constant force. The strain is recorded, drawn and compared \
with its closed form (a Mittag-Leffler function, or a power law without elastic modulus).

Writes creep.mcap, creep.csv, creep.svg and creep.png. Mass and damping of the simulated rig slow the first \
second down; the report says by how much.";

/// Arguments of `creep`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli creep --tissue prostate-healthy --stress 50Pa --duration 60s"
)]
pub struct Arguments {
    #[command(flatten)]
    options: Options<keys::Creep>,
    #[command(flatten)]
    run: RunArguments,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// Any failure, with its exit code.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let document = self.options.over(Document::new("creep"))?;
        self.run.run(&document, output)
    }
}
