//! `creep`: strain under a held force.

use super::experiment::RenderingArguments;
use crate::output::Output;
use crate::within::within;
use clap::Args;
use haptic_experiment::Creep;
use haptic_experiment::failure::Failure;
use haptic_experiment::parameters;
use haptic_quantity::{Stress, Time};

pub(crate) const LONG_ABOUT: &str = "\
Creep: the indenter pushes a virtual tissue with a constant force from t = 0 on; the strain is \
recorded, drawn, and held against its closed form (a Mittag-Leffler function; a power law for a \
tissue without elastic modulus).

Writes creep.mcap, creep.csv, creep.svg and creep.png. The masses and the damping of the simulated \
rig slow the first second down; the summary says by how much.

Columns of the CSV: time_s; ideal_position_m, by the closed form; position_m, as the loop read it; \
simulated_force_n, the reaction force as commanded; full_history_force_n, the force that the full history of \
position_m asks for; simulated_strain and closed_form_strain; closed_form_error, relative, of the strain; empty \
where the closed form is 0. With a device that is no simulation, simulated becomes rendered.";

/// Arguments of `creep`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli creep --tissue prostate-healthy --stress 50Pa --duration 60s"
)]
pub struct Arguments {
    #[arg(long, value_parser = within::<Stress>(parameters::STRESS.range()), help = parameters::STRESS.help, default_value = parameters::STRESS.shown, allow_hyphen_values = true)]
    stress: Stress,
    #[arg(long, value_parser = within::<Time>(parameters::CREEP_DURATION.range()), help = parameters::CREEP_DURATION.help, default_value = parameters::CREEP_DURATION.shown, allow_hyphen_values = true)]
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
        let experiment = Creep {
            rendering: self.rendering.rendering()?,
            stress_pa: self.stress.0,
            duration_s: self.duration.0,
        };
        let samples = experiment.check()?;
        self.rendering
            .conduct("creep", samples, output, |request, supervisor| {
                experiment.run(request, supervisor)
            })
    }
}
