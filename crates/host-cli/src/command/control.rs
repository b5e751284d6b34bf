//! `control`: fractional controllers, from a plant to a loop that runs.

mod analyze;
mod design;
mod draw;
mod identify;
mod simulate;

use crate::options::Options;
use crate::options::keys::Named;
use crate::output::Output;
use clap::Subcommand;
use haptic_experiment::Failure;
use haptic_experiment::question::control_loop::{ControlLoop, LoopForm};
use serde_json::{Value, json};

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Design(design::Arguments),
    Simulate(simulate::Arguments),
    Analyze(analyze::Arguments),
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

/// The loop of the options of a command.
fn asked<N: Named>(options: Options<N>) -> Result<ControlLoop, Failure> {
    let form: LoopForm = options.given()?.form()?;
    let held = form.files()?;
    ControlLoop::of(form, held)
}

/// Prints the report of a loop and says its warnings, as on every line of the command.
fn told(mut report: Value, files: &[String], output: Output) -> Result<(), Failure> {
    let warnings = report["warnings"].as_array().into_iter().flatten();
    warnings
        .filter_map(Value::as_str)
        .for_each(|said| output.warn(said));
    report["files"] = json!(files);
    output.report(&report)
}
