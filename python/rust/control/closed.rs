//! Closed loops of a controller and a plant: tuning, verdict, simulation.

use super::controller::{PyPid, gains};
use super::rule;
use super::transfer::PyControlPlant;
use crate::arrays::vector;
use crate::conducted::heard;
use crate::json::dict;
use crate::refused::OrRefused as _;
use fracdiff::Seconds;
use fractional_control::analysis::{LoopAnalysis, analyse_at};
use fractional_control::tuning::{
    Bound as GainBound, Sampling, Specification, Tuned, tune, tune_integer,
};
use fractional_control::{ControllerSetup, Crossing, SampledPlant, simulate};
use haptic_experiment::control::in_short;
use numpy::{IntoPyArray as _, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use std::time::Duration;

/// Wishes by their names.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Wishes {
    crossover_rad_s: f64,
    phase_margin_rad: f64,
    iso_damping: bool,
    noise: Option<(f64, f64)>,
    disturbance: Option<(f64, f64)>,
    sensitivity_peak: Option<f64>,
    complementary_peak: Option<f64>,
}

/// Gains and orders for a plant, as a dictionary.
#[pyfunction]
pub(crate) fn tune_controller<'py>(
    py: Python<'py>,
    plant: &Bound<'py, PyControlPlant>,
    wishes: Wishes,
    sampling: Option<(f64, String)>,
    integer: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let bound = |(omega_rad_s, at_most)| GainBound {
        omega_rad_s,
        at_most,
    };
    let specification = Specification {
        iso_damping: wishes.iso_damping,
        noise: wishes.noise.map(bound),
        disturbance: wishes.disturbance.map(bound),
        sensitivity_peak: wishes.sensitivity_peak,
        complementary_peak: wishes.complementary_peak,
        ..Specification::new(wishes.crossover_rad_s, wishes.phase_margin_rad)
    };
    let sampling = match sampling {
        Some((sample_time, name)) => Some(Sampling {
            sample_time: Seconds(sample_time),
            rule: rule(&name)?,
        }),
        None => None,
    };
    let plant = Arc::clone(&plant.get().plant);
    let search = if integer { tune_integer } else { tune };
    let tuned = heard(py, Duration::MAX, move |_| {
        search(&plant, sampling, &specification).or_refused()
    })?;
    report(py, &tuned)
}

fn report<'py>(py: Python<'py>, tuned: &Tuned) -> PyResult<Bound<'py, PyDict>> {
    let measures = &tuned.measures;
    let unmet = tuned.unmet.iter().map(ToString::to_string);
    Ok(dict! {py;
        "parameters": gains(py, &tuned.parameters)?,
        "gain_at_crossover": tuned.gain_at_crossover,
        "phase_margin_rad": tuned.phase_margin_rad,
        "phase_slope_rad": tuned.phase_slope_rad,
        "sensitivity_peak": measures.sensitivity_peak,
        "complementary_peak": measures.complementary_peak,
        "overshoot_spread": measures.overshoot_spread,
        "margin_spread_rad": measures.margin_spread_rad,
        "stable": measures.stable,
        "unmet": unmet.collect::<Vec<String>>(),
    })
}

/// Certified verdict and margins of a sampled loop, as a dictionary; `gain` is a factor on the plant.
#[pyfunction]
pub(crate) fn closed_loop<'py>(
    controller: &Bound<'py, PyPid>,
    plant: &Bound<'py, PyControlPlant>,
    gain: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let py = controller.py();
    let own = controller.try_borrow()?;
    let setup = ControllerSetup {
        scheme: own.memory.scheme(),
        memory_s: Some(own.memory.horizon_s()),
        ..ControllerSetup::new(own.parameters, own.sample_time)
    };
    let plant = Arc::clone(&plant.get().plant);
    let analysis = heard(py, Duration::MAX, move |_| {
        analyse_at(&setup, &plant, gain).or_refused()
    })?;
    let LoopAnalysis {
        verdict, margins, ..
    } = &analysis;
    let pair = |crossing: Crossing| (crossing.value, crossing.omega_rad_s);
    Ok(dict! {py;
        "stable": verdict.stable,
        "unstable_poles": verdict.unstable_poles,
        "verdict": in_short(&analysis),
        "coarse": analysis.coarse,
        "phase_rad": margins.phase.map(pair),
        "gain_up": margins.gain_up.map(pair),
        "gain_down": margins.gain_down.map(pair),
        "delay_s": margins.delay_s.map(pair),
        "sensitivity": pair(margins.sensitivity),
        "complementary": pair(margins.complementary),
    })
}

/// Measurement and command of a loop from rest.
type Columns<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// Runs a loop from rest over a record of the reference.
#[pyfunction]
pub(crate) fn simulate_loop<'py>(
    controller: &Bound<'py, PyPid>,
    plant: &Bound<'py, PyControlPlant>,
    reference: &Bound<'py, PyAny>,
) -> PyResult<Columns<'py>> {
    let py = controller.py();
    let own = controller.try_borrow()?;
    let reference = vector("reference", reference)?;
    let (controller, sample_time) = (own.running.controller().clone(), own.sample_time);
    let plant = Arc::clone(&plant.get().plant);
    let run = heard(py, Duration::MAX, move |_| {
        let plant = SampledPlant::with_usual_memory(&plant, sample_time).or_refused()?;
        let samples = reference.len();
        Ok(simulate(&controller, &plant, |n| reference[n], samples))
    })?;
    Ok((run.measured.into_pyarray(py), run.command.into_pyarray(py)))
}
