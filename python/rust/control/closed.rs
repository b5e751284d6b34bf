//! Closed loops of a controller and a plant: tuning, verdict, simulation.

use super::controller::{PyPid, gains};
use super::rule;
use super::transfer::PyControlPlant;
use crate::arrays::vector;
use crate::conducted::heard;
use crate::json::{dict, from_python, to_python};
use crate::refused::OrRefused as _;
use fracdiff::Seconds;
use fractional_control::analysis::{LoopAnalysis, analyse_at};
use fractional_control::tuning::{Sampling, Tuned, tune, tune_integer};
use fractional_control::{ControllerSetup, Crossing, Plant, SampledPlant, simulate};
use haptic_experiment::control::in_short;
use haptic_experiment::question::controller::DesignForm;
use haptic_experiment::question::controller::report::designed;
use numpy::{IntoPyArray as _, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use std::time::Duration;

/// Gains and orders for a plant, as a dictionary.
#[pyfunction]
pub(crate) fn tune_controller<'py>(
    py: Python<'py>,
    plant: &Bound<'py, PyControlPlant>,
    wishes: &Bound<'py, PyAny>,
    sampling: Option<(f64, String)>,
    integer: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let wishes: DesignForm = from_python("wishes", wishes)?;
    let specification = wishes.wishes().or_refused()?;
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

/// A controller for a plant that is called so, by wishes: the command's report, and the controller file.
#[pyfunction]
pub(crate) fn design_controller<'py>(
    plant: &Bound<'py, PyControlPlant>,
    name: String,
    wishes: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyAny>, String)> {
    let py = plant.py();
    let wishes: DesignForm = from_python("wishes", wishes)?;
    let plant = Plant::clone(&plant.get().plant);
    let (report, file) = heard(py, Duration::MAX, move |_| {
        let found = designed(wishes.design(plant).or_refused()?).or_refused()?;
        let program = concat!("fractional_haptics ", env!("CARGO_PKG_VERSION"));
        let file = found.words().file(&name, &found.design.wishes, program);
        Ok((found.report(&name), file.to_toml()))
    })?;
    Ok((to_python(py, &report)?, file))
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
