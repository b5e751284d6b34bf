//! `relax`: stress relaxation, the main job.

use super::experiment::RunArguments;
use crate::keys;
use crate::options::Options;
use crate::output::Output;
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::document::Document;

pub(crate) const LONG_ABOUT: &str = "\
Stress relaxation: an indenter compresses a virtual tissue to a strain and holds it; the loop \
renders the tissue, and the force it commands is recorded, drawn, and held against theory.

Writes relax.mcap (open it in PlotJuggler or Foxglove), relax.csv, relax.svg and relax.png. \
In the log a force is positive along the position, so the tissue pushes back with a negative one; \
in the CSV, the picture and the summary reaction forces are positive.";

/// Arguments of `relax`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  host-cli relax\n  host-cli relax --tissue prostate-healthy \
                  --strain 3% --duration 60s --out healthy\n  host-cli relax --controller experiments/indenter.toml \
                  # the indenter a mass, held by a controller\n  host-cli relax --scheme grunwald:1000   \
                  # see short memory fail\n  host-cli relax encoder_resolution=1um safety.stop_time=50ms   # any other key"
)]
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
