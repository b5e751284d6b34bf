//! Loops, as the commands of `control` ask for them and report them.

use crate::options::Options;
use crate::options::keys::Named;
use crate::output::Output;
use haptic_experiment::Failure;
use haptic_question::control_loop::{ControlLoop, LoopForm};
use serde_json::{Value, json};

/// The loop of the options of a command.
pub(super) fn asked<N: Named>(options: Options<N>) -> Result<ControlLoop, Failure> {
    let form: LoopForm = options.form()?;
    let held = form.files()?;
    ControlLoop::of(form, held)
}

/// Prints the report of a loop; its warnings go to standard error.
pub(super) fn print(mut report: Value, files: &[String], output: Output) -> Result<(), Failure> {
    let warnings = report["warnings"].as_array().into_iter().flatten();
    warnings
        .filter_map(Value::as_str)
        .for_each(|hint| output.warn(hint));
    report["files"] = json!(files);
    output.report(&report)
}
