//! `run`: any experiment, from a file; `relax` and `creep`, from options alone.

use crate::command::conduct::RunArguments;
use crate::options::{Options, keys};
use crate::output::{Output, warn};
use clap::Args;
use haptic_document::Document;
use haptic_experiment::DocumentOfKind as _;
use haptic_experiment::Failure;
use haptic_experiment::parameters::{Parameter, Value, tables};
use haptic_run::read_document;
use std::fmt::Write as _;
use std::path::PathBuf;

/// Last part of `--help`: keys of each table, with defaults and ranges.
fn examples_and_keys() -> String {
    let mut text = EXAMPLES.to_owned();
    for (heading, parameters) in tables("experiment") {
        let _ = write!(text, "\n\n{heading}:");
        for parameter in parameters {
            let _ = write!(text, "\n  {}", described(parameter));
        }
    }
    text
}

/// Key, default, range and meaning of a parameter.
fn described(parameter: &Parameter) -> String {
    let Parameter {
        key, value, help, ..
    } = parameter;
    let default = match value {
        Value::Number(Some(default), range) => format!(" = {default}, {range}"),
        Value::Number(None, range) => format!(", {range}"),
        Value::Count(default) => format!(" = {default}"),
        Value::Flag(default) => format!(" = {default}"),
        Value::Text(default) => format!(" = \"{default}\""),
        Value::List(range) => format!(", a list of numbers {range}"),
    };
    format!("{key}{default}: {help}")
}

const EXAMPLES: &str = "Examples:\n  host-cli run experiments/wall.toml stiffness=5kN/m --out wall\n  \
                  host-cli run wall/wall.mcap --out again";

/// Run the experiment that a file describes
///
/// Runs the experiment of a TOML file, or repeats that of a log. The file has one table, that of
/// the experiment; its keys are listed below. They end with their SI unit, as in `duration_s` =
/// 200; options take precedence over them. Paths in the file start from its folder.
///
/// Beside that table may stand `[drive]`, which names a controller file, whose controller moves the
/// indenter, and beside `[wall]` `[admittance]`, a robot that takes a velocity.
///
/// `[wall]`: the device hits the wall at `impact_m_per_s` and is pushed into it; the wall is stable
/// if the device comes to rest (see `host-cli zwidth --help`). A serial device is only pushed.
/// `must_be_stable` = true: exit code 1 unless trial and analysis both say stable.
///
/// `[coupler]`: the same with a virtual coupler, a spring beside a damper, between device and a
/// simulated object, by Llewellyn's criterion too. A serial device needs --loop host.
///
/// `[teleoperation]`: a hand moves a master; a slave follows over a line with delay, jitter, loss
/// and duplication, and touches a remote tissue or wall. All of it is simulated; `host-cli
/// teleoperate` runs the sides over UDP. `must_be_passive` = true: exit code 1 unless the line was
/// passive.
///
/// `[touch]`: a hand moves a device of two or three axes over a plane or ball of tissue. The force
/// is along the normal and follows the history of the depth. The analysis before the run takes the
/// effective mass of the worst posture. `must_be_passive` = true: exit code 1 if the hand gets
/// energy. With --device haply:PATH --loop host the hand is yours.
///
/// guard = "observer" adds damping so that a wall does not shake; "energy-bounding" limits the
/// force to what the device's damping can absorb.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, after_long_help = examples_and_keys())]
pub(crate) struct Arguments {
    /// Experiment file, or the log of a run to repeat
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    options: Options<keys::Run>,
    #[command(flatten)]
    run: RunArguments,
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        let file = read_document(&self.file)?;
        let document = self.options.over(file)?;
        if let Some(changed) = document.changed_since_log() {
            warn(&changed);
        }
        self.run.run(&document, output)
    }
}

pub(crate) const RELAX_EXAMPLES: &str = "Examples:\n  host-cli relax --tissue prostate-healthy \
                  --strain 3% --duration 60s --out healthy\n  host-cli relax --scheme grunwald:1000\n  host-cli relax --loading sphere --indenter-radius 5mm --depth 1mm";

/// Arguments of an experiment without a file.
#[derive(Debug, Args)]
pub(crate) struct Experiment<K: keys::Named> {
    #[command(flatten)]
    options: Options<K>,
    #[command(flatten)]
    run: RunArguments,
}

impl<K: keys::Named> Experiment<K> {
    pub(crate) fn run(self, kind: &str, output: Output) -> Result<(), Failure> {
        let document = self.options.over(Document::new(kind))?;
        self.run.run(&document, output)
    }
}
