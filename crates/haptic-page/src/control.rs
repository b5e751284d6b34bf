//! A controller for a plant that was typed or dropped on the page: the answer of `control design`, and beside it a controller of
//! one's own.

use crate::{TextFile, form};
use fractional_control::design::{Candidate, ControlDesign, Trial};
use fractional_control::run::samples_for;
use fractional_control::{ControlError, ControllerSetup};
use haptic_experiment::Failure;
use haptic_experiment::control::{
    gains, in_degrees, in_short, loose_factor, margins, refused, shape,
};
use haptic_experiment::document::{ControllerFile, short};
use haptic_experiment::question::controller::DesignForm;
use haptic_experiment::question::controller::report::designed as designed_by;
use haptic_experiment::run::PlantModel;
use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Points of a curve that is sent, at most.
const POINTS: usize = 600;

/// A plant, and keys for what is wanted of its loop.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct ControlRequest {
    plant: String,
    /// A plant file, or the table of a measured response, in place of the notation.
    plant_file: Option<TextFile>,
    /// A controller file, to be compared.
    controller_file: Option<TextFile>,
    #[serde(flatten)]
    form: Map<String, Value>,
}

impl ControlRequest {
    fn model(&self) -> Result<PlantModel, Failure> {
        if let Some(TextFile { name, text }) = &self.plant_file {
            return PlantModel::parse(Path::new(name), text);
        }
        self.plant.parse().map_err(|error: ControlError| {
            let (text, error) = (short(&self.plant), in_degrees(&error));
            Failure::bad_input(format_args!("plant \"{text}\": {error}"))
        })
    }
}

/// The controller of a file, in the loop of a design.
fn own(TextFile { name, text }: &TextFile, design: &ControlDesign) -> Result<Value, Failure> {
    let setup = ControllerFile::parse(Path::new(name), text)?.setup;
    let crossover = Some(design.wishes.crossover_rad_s);
    let design = ControlDesign {
        samples: samples_for(crossover, setup.sample_time_s) as usize,
        ..design.clone()
    };
    let wrong =
        |error: ControlError| Failure::bad_input(format_args!("{name}: {}", in_degrees(&error)));
    Ok(seen(&setup, &design.trial(&setup).map_err(wrong)?))
}

pub(crate) fn designed(request: &ControlRequest) -> Result<Value, Failure> {
    let wishes: DesignForm = form(&request.form)?;
    let model = request.model()?;
    let design = wishes.design(model.plant().map_err(refused)?)?;
    let own = request
        .controller_file
        .as_ref()
        .map(|file| own(file, &design))
        .transpose()?;
    let found = designed_by(design)?;
    let (design, words) = (&found.design, found.words());
    let (fractional, integer) = (&found.answer.fractional, found.answer.integer.as_ref());
    // Of a file the notation is not read.
    let notation = request.plant_file.is_none().then_some(&request.plant);
    let reading =
        notation.and_then(|text| Some(format!("Warning: {}.", loose_factor("plant", text)?)));
    let unmet = Some(words.unmet()).filter(|unmet| !unmet.is_empty());
    let unmet = unmet.map(|unmet| format!("Warning: not met: {unmet}."));
    let seen = |candidate: &Candidate| match &candidate.trial {
        Some(trial) => seen(&candidate.setup, trial),
        // A measured response is tuned for, not run.
        None => json!({
            "controller": candidate.setup.law.to_string(),
            "gains": gains(&candidate.tuned.parameters),
        }),
    };
    Ok(json!({
        "plant": model.in_words(),
        "sample_time_s": design.sample_time.0,
        "fractional": seen(fractional),
        "integer": integer.ok().map(seen),
        "integer_reason": integer.err().map(in_degrees),
        "own": own,
        "notes": reading.into_iter().chain(unmet).chain(words.sentences()).collect::<Vec<_>>(),
        "file": words.file(&model.in_words(), &design.wishes, "").to_toml(),
    }))
}

fn seen(setup: &ControllerSetup, trial: &Trial) -> Value {
    let t = setup.sample_time_s;
    let samples = trial.step.measured.len();
    let every = samples.div_ceil(POINTS).max(1);
    let thinned = |values: &[f64]| -> Vec<f64> { values.iter().copied().step_by(every).collect() };
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
