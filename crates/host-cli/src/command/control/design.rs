//! `control design`: from wishes to a controller file, with the best integer-order PID beside it.

use super::draw::{design_columns, draw_design};
use crate::files::{Files, PROGRAM, Place};
use crate::options::{Options, keys};
use crate::output::Output;
use clap::Args;
use control_tuning::design::ControlAnswer;
use haptic_experiment::Failure;
use haptic_question::control_loop::{LoopForm, NamedPlant};
use haptic_question::controller::DesignForm;
use haptic_question::controller::report::designed;
use serde::Serialize;
use serde_json::Value;

/// Tune a fractional PID and compare it with the best integer-order PID
///
/// The controller is a PI^lambda D^mu. It meets crossover and phase margin exactly, makes the phase
/// flat there (so that the overshoot stays the same when the plant's gain changes), and keeps
/// bounds on |S| and |T| as well as possible. The result is simulated beside the closest
/// integer-order PID. The verdict on the sampled loop is a proof for an interval of plant gains,
/// with a warning if that does not reach from half to double.
///
/// Exit code 1 if a wish is missed by more than 1 %; the report says which, and by how much.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli control design --plant \"0.55exp(-s)/(62s+1)\" --crossover \
                  0.1rad/s --phase-margin 65deg --out oven"
)]
pub(crate) struct Arguments {
    #[command(flatten)]
    plant: Options<keys::ControlPlant>,
    #[command(flatten)]
    asked: Options<keys::ControlDesign>,
    #[command(flatten)]
    files: Files,
}

/// The result, and where it was written.
#[derive(Serialize)]
struct Shown<'a> {
    #[serde(flatten)]
    report: Value,
    controller_file: Option<String>,
    files: &'a [String],
}

impl Arguments {
    pub(super) fn run(self, output: Output) -> Result<(), Failure> {
        let mut outputs = self.files.look("controller", &["toml"])?;
        let plant: LoopForm = self.plant.form()?;
        let plant = plant.plant(plant.files()?.plant)?;
        plant.hint.iter().for_each(|hint| output.warn(hint));
        let form: DesignForm = self.asked.form()?;
        let found = designed(form.design(plant.plant.clone())?)?;
        let file = found
            .words()
            .file(&plant.words, &found.design.wishes, PROGRAM);
        let controller_file = outputs.text("toml", &file.to_toml());
        let files = &write(&plant, &found.answer, &mut outputs);
        output.report(&Shown {
            report: found.report(&plant.words),
            controller_file,
            files,
        })?;
        outputs.close(found.judge())
    }
}

/// Writes table and picture, if a folder was given and the plant runs; their names.
fn write(plant: &NamedPlant, answer: &ControlAnswer, outputs: &mut Place) -> Vec<String> {
    let mut columns = design_columns(&answer.fractional, "");
    if let Ok(integer) = &answer.integer {
        columns.extend(design_columns(integer, "integer_"));
    }
    let t = answer.fractional.setup.sample_time_s;
    let table = columns.first().and_then(|(_, first)| {
        let names = columns.iter().map(|(name, _)| name.as_str());
        let names: Vec<&str> = std::iter::once("time_s").chain(names).collect();
        let rows = (0..first.len()).map(|n| {
            let values = columns.iter().map(|(_, column)| column[n]);
            let row = std::iter::once(n as f64 * t).chain(values);
            row.collect::<Vec<f64>>()
        });
        outputs.write(|folder| folder.write_table(&names, rows))
    });
    let picture = draw_design(answer, plant).transpose();
    let picture = picture.and_then(|picture| outputs.picture(|| picture));
    table.into_iter().chain(picture).collect()
}
