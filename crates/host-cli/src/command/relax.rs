//! `relax`: stress relaxation, the main job.

use super::experiment::RenderingArguments;
use crate::output::Output;
use crate::within::within;
use clap::Args;
use haptic_experiment::Relaxation;
use haptic_experiment::failure::Failure;
use haptic_experiment::parameters;
use haptic_quantity::{Strain, Time};

pub(crate) const LONG_ABOUT: &str = "\
Stress relaxation: an indenter compresses a virtual tissue to a strain and holds it; the loop \
renders the tissue, and the force it commands is recorded, drawn, and held against theory.

Writes relax.mcap (open it in PlotJuggler or Foxglove), relax.csv, relax.svg and relax.png. \
In the log a force is positive along the position, so the tissue pushes back with a negative one; \
in the CSV, the picture and the summary reaction forces are positive.

Columns of the CSV: time_s; ideal_position_m, the indentation asked for; position_m, as the loop read it; \
simulated_force_n, the reaction force as commanded (rendered_force_n with a device that is no simulation); \
full_history_force_n, the force that the full history of position_m asks for; closed_form_force_n; \
closed_form_error, relative, of the commanded force; empty where the closed form is 0. With --drive also indenter_position_m and \
drive_force_n.";

/// Arguments of `relax`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  host-cli relax\n  host-cli relax --tissue prostate-healthy \
                  --strain 3% --duration 60s --out healthy\n  host-cli relax --drive experiments/indenter.toml \
                  # the indenter a mass, held by a controller\n  host-cli relax --scheme grunwald:1000   \
                  # see short memory fail"
)]
pub struct Arguments {
    #[arg(long, value_parser = within::<Strain>(parameters::STRAIN.range()), help = parameters::STRAIN.help, default_value = parameters::STRAIN.shown, allow_hyphen_values = true)]
    strain: Strain,
    #[arg(long, value_parser = within::<Time>(parameters::RAMP_TIME.range()), help = parameters::RAMP_TIME.help, default_value = parameters::RAMP_TIME.shown, allow_hyphen_values = true)]
    ramp_time: Time,
    #[arg(long, value_parser = within::<Time>(parameters::RELAX_DURATION.range()), help = parameters::RELAX_DURATION.help, default_value = parameters::RELAX_DURATION.shown, allow_hyphen_values = true)]
    duration: Time,
    #[command(flatten)]
    rendering: RenderingArguments,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// Any failure, with its exit code.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let experiment = Relaxation {
            rendering: self.rendering.rendering()?,
            strain: self.strain.0,
            ramp_time_s: self.ramp_time.0,
            duration_s: self.duration.0,
        };
        let samples = experiment.check()?;
        self.rendering
            .conduct("relax", samples, output, |request, supervisor| {
                experiment.run(request, supervisor)
            })
    }
}
