//! `relax`: stress relaxation, the main job.

use super::experiment::RunArguments;
use crate::keys;
use crate::options::Options;
use crate::output::Output;
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::document::Document;

pub(crate) const LONG_ABOUT: &str = "\
Stress relaxation: an indenter compresses a virtual tissue and holds it. The loop renders the tissue; \
its force is recorded, drawn and compared with theory.

Writes relax.mcap (for PlotJuggler or Foxglove), relax.csv, relax.svg and relax.png. In the log the \
tissue pushes back with a negative force; in the CSV, the picture and the report reaction forces are positive.";

/// Arguments of `relax`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  host-cli relax --tissue prostate-healthy \
                  --strain 3% --duration 60s --out healthy\n  host-cli relax --scheme grunwald:1000   \
                  # short memory fails\n  host-cli relax encoder_resolution=1um safety.stop_time=50ms")]
pub struct Arguments {
    #[command(flatten)]
    options: Options<keys::Relax>,
    #[command(flatten)]
    run: RunArguments,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// Any failure, with its exit code.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let document = self.options.over(Document::new("relax"))?;
        self.run.run(&document, output)
    }
}
