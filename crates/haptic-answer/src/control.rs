//! A controller for a plant that was typed or dropped on the page: the answer of `control design`, and beside it a controller of
//! one's own; a loop that is judged or run as it is.

use crate::words::{TextFile, form};
use control_tuning::design::{ControlDesign, Trial, TunedController};
use fractional_control::run::samples_for;
use fractional_control::{ControlError, ControllerSetup};
use haptic_document::{Failure, lines};
use haptic_question::control_loop::run::Reference;
use haptic_question::control_loop::{CONTROL_LOOP, ControlLoop, FormParts, LoopForm, NamedPlant};
use haptic_question::controller::DesignForm;
use haptic_question::controller::report::designed as designed_by;
use haptic_question::words::{gains, in_short, margins, shape};
use haptic_trial::advice::in_degrees;
use haptic_trial::{ControllerFile, PlantModel};
use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Points of a curve that is sent, at most.
const POINTS: usize = 600;

/// A plant, and keys for what is asked of its loop.
#[derive(Clone, Debug, Deserialize)]
pub struct ControlRequest {
    /// A plant file, or the table of a measured response, in place of the notation.
    plant_file: Option<TextFile>,
    /// A controller file: of a design, to be compared; of a loop, in place of the notation.
    controller_file: Option<TextFile>,
    /// A table, in place of a step.
    reference_file: Option<TextFile>,
    #[serde(flatten)]
    form: Map<String, Value>,
}

impl ControlRequest {
    /// Plant and controller of the files.
    fn held(&self) -> Result<FormParts, Failure> {
        let plant = self.plant_file.as_ref().map(|TextFile { name, text }| {
            NamedPlant::of(&PlantModel::parse(Path::new(name), text)?)
        });
        let controller = self.controller_file.as_ref();
        let controller =
            controller.map(|TextFile { name, text }| ControllerFile::parse(Path::new(name), text));
        Ok(FormParts {
            plant: plant.transpose()?,
            controller: controller.transpose()?.map(|file| file.setup),
        })
    }

    fn asked(&self) -> Result<ControlLoop, Failure> {
        ControlLoop::of(form(&self.form)?, self.held()?)
    }

    /// The answer of `control analyze`.
    ///
    /// # Errors
    /// Keys or a file that are wrong; a loop that cannot be analysed.
    pub fn analysed(&self) -> Result<Value, Failure> {
        let report = self.asked()?.analysed()?.report;
        Ok(json!({"lines": lines(&report), "report": report}))
    }

    /// The answer of `control simulate`, with its signals.
    ///
    /// # Errors
    /// Keys or a file that are wrong; a loop that cannot be run.
    pub fn simulated(&self) -> Result<Value, Failure> {
        let reference = self.reference_file.as_ref().map(|TextFile { name, text }| {
            let read = Reference::read(&Reference::COLUMNS.map(str::to_owned), text.as_bytes());
            read.map_err(|error| Failure::bad_input(format_args!("{name}: {error}")))
        });
        let found = self.asked()?.simulated(reference.transpose()?.as_ref())?;
        let (run, report) = (&found.response, found.judged());
        let samples = run.measured.len();
        let every = samples.div_ceil(POINTS).max(1);
        let times = (0..samples)
            .step_by(every)
            .map(|n| n as f64 * found.sample_time_s);
        Ok(json!({
            "lines": lines(&report),
            "report": report,
            "time_s": times.collect::<Vec<_>>(),
            "reference": thinned(&run.reference, every),
            "output": thinned(&run.measured, every),
            "command": thinned(&run.command, every),
        }))
    }
}

/// One in so many of the numbers.
fn thinned(numbers: &[f64], every: usize) -> Vec<f64> {
    numbers.iter().copied().step_by(every).collect()
}

/// The controller of a file, in the loop of a design.
fn compared_loop(
    name: &str,
    setup: &ControllerSetup,
    design: &ControlDesign,
) -> Result<Value, Failure> {
    let crossover = Some(design.wishes.crossover_rad_s);
    let design = ControlDesign {
        samples: samples_for(crossover, setup.sample_time_s) as usize,
        ..design.clone()
    };
    let wrong =
        |error: ControlError| Failure::bad_input(format_args!("{name}: {}", in_degrees(&error)));
    Ok(seen(setup, &design.trial(setup).map_err(wrong)?))
}

/// The answer of `control design`, with the controller of a file beside it.
///
/// # Errors
/// A plant, wish or file that is wrong; a design that fails.
pub fn designed(request: &ControlRequest) -> Result<Value, Failure> {
    let (_, of_plant) = CONTROL_LOOP[0];
    let keys = request.form.clone().into_iter();
    let (plant, wishes) = keys.partition(|(key, _)| of_plant.iter().any(|one| one.key == key));
    let wishes: DesignForm = form(&wishes)?;
    let plant: LoopForm = form(&plant)?;
    let held = request.held()?;
    let plant = plant.plant(held.plant)?;
    let design = wishes.design(plant.plant)?;
    let compared = held.controller.zip(request.controller_file.as_ref());
    let compared_loop = compared.map(|(setup, file)| compared_loop(&file.name, &setup, &design));
    let compared_loop = compared_loop.transpose()?;
    let found = designed_by(design)?;
    let (design, words) = (&found.design, found.words());
    let (fractional, integer) = (&found.answer.fractional, found.answer.integer.as_ref());
    let reading = plant.hint.iter().map(|text| format!("Warning: {text}."));
    let unmet = Some(words.unmet()).filter(|unmet| !unmet.is_empty());
    let unmet = unmet.map(|unmet| format!("Warning: not met: {unmet}."));
    let seen = |candidate: &TunedController| match &candidate.trial {
        Some(trial) => seen(&candidate.setup, trial),
        // A measured response is tuned for, not run.
        None => json!({
            "controller": candidate.setup.law.to_string(),
            "gains": gains(&candidate.tuned.parameters),
        }),
    };
    Ok(json!({
        "plant": plant.words,
        "sample_time_s": design.sample_time.0,
        "fractional": seen(fractional),
        "integer": integer.ok().map(seen),
        "integer_reason": integer.err().map(in_degrees),
        "own": compared_loop,
        "notes": reading.chain(unmet).chain(words.sentences()).collect::<Vec<_>>(),
        "file": words.file(&plant.words, &design.wishes, "").to_toml(),
    }))
}

fn seen(setup: &ControllerSetup, trial: &Trial) -> Value {
    let t = setup.sample_time_s;
    let samples = trial.step.measured.len();
    let every = samples.div_ceil(POINTS).max(1);
    let thinned = |values: &[f64]| thinned(values, every);
    let gains_tried = trial.robustness.iter().map(|row| {
        json!({
            "gain": row.gain,
            "stable": row.stable,
            "step": thinned(&row.response.measured),
        })
    });
    let curve = &trial.analysis.curve;
    json!({
        "controller": setup.law.to_string(),
        "gains": setup.pid().as_ref().map(gains),
        // Null where nothing is proved, as the command has it.
        "stable": trial.analysis.coarse.is_none().then_some(trial.analysis.verdict.stable),
        "verdict": in_short(&trial.analysis),
        "margins": trial.margins().map(margins),
        "shape": trial.analysis.verdict.stable.then(|| shape(&trial.shape, t)),
        "time_s": (0..samples).step_by(every).map(|n| n as f64 * t).collect::<Vec<_>>(),
        "step": thinned(&trial.step.measured),
        "command": thinned(&trial.step.command),
        "loaded": thinned(&trial.loaded.measured),
        "robustness": gains_tried.collect::<Vec<_>>(),
        "omega_rad_s": curve.iter().map(|point| point.omega_rad_s).collect::<Vec<_>>(),
        "open_real": curve.iter().map(|point| point.open.re).collect::<Vec<_>>(),
        "open_imaginary": curve.iter().map(|point| point.open.im).collect::<Vec<_>>(),
        "phase_rad": curve.iter().map(|point| point.phase_rad).collect::<Vec<_>>(),
    })
}
