//! `control simulate`: a step, or any record, through a loop or a plant alone.

use super::draw::draw_run;
use super::loops::{asked, print};
use crate::files::Files;
use crate::options::{Options, keys};
use crate::output::Output;
use crate::table;
use clap::Args;
use haptic_experiment::Failure;
use haptic_question::control_loop::run::{Reference, Simulated};
use serde::Serialize;
use serde_json::json;

/// Run a step or a record through a loop, or a plant alone
///
/// The loop starts at rest and runs as on hardware: sampled, with a command held between samples,
/// dead time, limits and anti-windup. The reference is a step or a CSV column. A fractional
/// controller is compared with the integer-order PID of the same crossover and phase margin. Exit
/// code 1 if the output does not end at its reference, or is NaN.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli control simulate --plant \"0.55exp(-s)/(62s+1)\" --controller \
                  design/controller.toml --out run"
)]
pub(crate) struct Arguments {
    #[command(flatten)]
    asked: Options<keys::ControlSimulate>,
    #[command(flatten)]
    files: Files,
}

#[derive(Clone, Copy, Serialize)]
struct Row {
    time_s: f64,
    reference: f64,
    output: f64,
    command: f64,
}

/// The signals, sample by sample.
fn rows(found: &Simulated) -> Vec<Row> {
    let run = &found.response;
    let samples = run.measured.iter().enumerate();
    let row = |(n, output): (usize, &f64)| Row {
        time_s: n as f64 * found.sample_time_s,
        reference: run.reference[n],
        output: *output,
        command: run.command[n],
    };
    samples.map(row).collect()
}

impl Arguments {
    pub(super) fn run(self, output: Output) -> Result<(), Failure> {
        let asked = asked(self.asked)?;
        let mut outputs = self.files.look("response", &[])?;
        let path = Some(&*asked.form.reference).filter(|path| !path.is_empty());
        let columns = Reference::COLUMNS.map(str::to_owned);
        let reference = path.map(|path| table::read(path.as_ref(), columns, Reference::read));
        let reference = reference.transpose()?;
        let mut found = asked.simulated(reference.as_ref())?;
        let rows = rows(&found);
        let picture = || draw_run(&found, &asked);
        let files = outputs.table_and_picture(&[], rows.iter(), picture);
        found.report["step"] = json!(rows);
        let ended = found.judge();
        print(found.report, &files, output)?;
        outputs.close(ended)
    }
}
