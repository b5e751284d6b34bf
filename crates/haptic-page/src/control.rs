//! A controller for a plant that was typed on the page: the answer of `control design`.

use crate::Number;
use fracdiff::parameter::Shown;
use fractional_control::design::{Candidate, ControlDesign, SAMPLES_A_RADIAN, usual_sample_time};
use fractional_control::run::samples_for;
use fractional_control::tuning::Specification;
use fractional_control::{ControlError, Crossing, Margins, Plant};
use haptic_experiment::Failure;
use haptic_experiment::control::{DesignWords, in_degrees, in_short, loose_factor};
use haptic_experiment::document::{ControllerFile, ControllerOrigin, short};
use haptic_experiment::parameters::{CONTROLLER_SCHEME, SAMPLE_TIME};
use haptic_quantity::digits;
use serde::Deserialize;
use serde_json::{Value, json};

/// Points of a curve that is sent, at most.
const POINTS: usize = 600;

/// A plant, and what is wanted of its loop.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ControlRequest {
    plant: String,
    crossover_rad_s: Number,
    phase_margin_rad: Number,
    flat_phase: bool,
}

pub(crate) fn designed(request: &ControlRequest) -> Result<Value, Failure> {
    let failure = |error: ControlError| Failure::bad_input(in_degrees(&error));
    let text = short(&request.plant);
    let refused = |error| Failure::bad_input(format_args!("plant \"{text}\": {error}"));
    let plant = request.plant.parse::<Plant>().map_err(refused)?;
    let wishes = Specification {
        iso_damping: request.flat_phase,
        ..Specification::new(request.crossover_rad_s.0, request.phase_margin_rad.0)
    };
    let crossover = |sample_time_s: f64| 1.0 / (SAMPLES_A_RADIAN * sample_time_s);
    let [high, low] = SAMPLE_TIME.range().ends().map(crossover);
    if !(low..=high).contains(&request.crossover_rad_s.0) {
        return Err(Failure::bad_input(format_args!(
            "crossover {} rad/s is not from {} to {} rad/s",
            Shown(request.crossover_rad_s.0),
            Shown(low),
            Shown(high)
        )));
    }
    let sample_time = usual_sample_time(request.crossover_rad_s.0);
    let scheme = CONTROLLER_SCHEME.shown.parse();
    let design = ControlDesign {
        samples: samples_for(Some(request.crossover_rad_s.0), sample_time.0) as usize,
        plant,
        wishes,
        sample_time,
        scheme: scheme.map_err(Failure::input)?,
        output_low: None,
        output_high: None,
        step: 1.0,
    };
    let answer = design.answer().map_err(failure)?;
    let (fractional, integer) = (&answer.fractional, answer.integer.as_ref());
    let words = DesignWords(&answer);
    let file = ControllerFile {
        setup: fractional.setup.clone(),
        origin: ControllerOrigin {
            plant: request.plant.clone(),
            wishes: wishes_of(request),
            note: words.note(),
            ..ControllerOrigin::default()
        },
    };
    let reading = loose_factor("plant", &request.plant).map(|said| format!("Warning: {said}."));
    Ok(json!({
        "sample_time_s": sample_time.0,
        "fractional": seen(fractional),
        "integer": integer.ok().map(seen),
        "integer_reason": integer.err().map(in_degrees),
        "notes": reading.into_iter().chain(words.sentences()).collect::<Vec<_>>(),
        "file": file.to_toml(),
    }))
}

fn wishes_of(request: &ControlRequest) -> String {
    format!(
        "crossover {} rad/s, phase margin {}°{}",
        digits(request.crossover_rad_s.0, 4),
        digits(request.phase_margin_rad.0.to_degrees(), 4),
        if request.flat_phase {
            ", flat phase"
        } else {
            ""
        }
    )
}

fn seen(candidate: &Candidate) -> Value {
    // A plant in notation runs.
    let Some(trial) = &candidate.trial else {
        return Value::Null;
    };
    let t = candidate.setup.sample_time_s;
    let value = |crossing: fn(&Margins) -> Option<Crossing>| {
        trial.margins().and_then(crossing).map(|at| at.value)
    };
    let phase = trial.margins().and_then(|margins| margins.phase);
    let shape = trial.analysis.verdict.stable.then_some(&trial.shape);
    let step = &trial.step.measured;
    let every = step.len().div_ceil(POINTS).max(1);
    let curve = &trial.analysis.curve;
    json!({
        "controller": candidate.setup.law.to_string(),
        "stable": trial.analysis.verdict.stable,
        "verdict": in_short(&trial.analysis),
        "phase_margin_rad": value(|margins| margins.phase),
        "crossover_rad_s": phase.map(|phase| phase.omega_rad_s),
        "gain_margin": value(|margins| margins.gain_up),
        "gain_margin_down": value(|margins| margins.gain_down),
        "delay_margin_s": value(|margins| margins.delay_s),
        "sensitivity_peak": value(|margins| Some(margins.sensitivity)),
        "overshoot": shape.map(|shape| shape.overshoot),
        "settling_time_s": shape.and_then(|shape| shape.settled).map(|n| n as f64 * t),
        "phase_slope_rad": candidate.tuned.phase_slope_rad,
        "time_s": (0..step.len()).step_by(every).map(|n| n as f64 * t).collect::<Vec<_>>(),
        "step": step.iter().step_by(every).collect::<Vec<_>>(),
        "omega_rad_s": curve.iter().map(|point| point.omega_rad_s).collect::<Vec<_>>(),
        "open_real": curve.iter().map(|point| point.open.re).collect::<Vec<_>>(),
        "open_imaginary": curve.iter().map(|point| point.open.im).collect::<Vec<_>>(),
        "phase_rad": curve.iter().map(|point| point.phase_rad).collect::<Vec<_>>(),
    })
}
