//! Closed loops of a controller and a plant: design, verdict, simulation.

use super::controller::PyPid;
use super::transfer::PyControlPlant;
use crate::arrays::{Array, Vector};
use crate::conducted::heard;
use crate::experiment::failed;
use crate::json::{from_python, to_python};
use crate::refused::OrRefused as _;
use fractional_control::Plant;
use haptic_question::control_loop::run::Reference;
use haptic_question::control_loop::{ControlLoop, FormParts, LoopForm, NamedPlant};
use haptic_question::controller::DesignForm;
use haptic_question::controller::report::designed;
use pyo3::prelude::*;
use std::time::Duration;

/// A controller for a plant, which may be called so, by wishes: the command's report, and the controller file.
#[pyfunction]
pub(crate) fn design_controller<'py>(
    py: Python<'py>,
    plant: Option<&Bound<'py, PyControlPlant>>,
    form: &Bound<'py, PyAny>,
    wishes: &Bound<'py, PyAny>,
    name: Option<String>,
) -> PyResult<(Bound<'py, PyAny>, String)> {
    let wishes: DesignForm = from_python("wishes", wishes)?;
    let (form, held) = read(plant, form)?;
    let (report, file) = heard(py, Duration::MAX, move |_| {
        let plant = form.plant(held.plant).or_refused()?;
        let name = name.unwrap_or(plant.words);
        let found = designed(wishes.design(plant.plant).or_refused()?).or_refused()?;
        let program = concat!("fractional_haptics ", env!("CARGO_PKG_VERSION"));
        let file = found.words().file(&name, &found.design.wishes, program);
        let mut report = found.report(&name);
        if let (Some(hint), Some(notes)) = (plant.hint, report["notes"].as_array_mut()) {
            notes.insert(0, hint.into());
        }
        Ok((report, file.to_toml()))
    })?;
    Ok((to_python(py, &report)?, file))
}

/// A form, and what is held of it: the plant of its files, or this one.
fn read(
    plant: Option<&Bound<'_, PyControlPlant>>,
    form: &Bound<'_, PyAny>,
) -> PyResult<(LoopForm, FormParts)> {
    let form: LoopForm = from_python("options", form)?;
    let mut held = form.files().map_err(|failure| failed(&failure))?;
    if let Some(plant) = plant {
        held.plant = Some(NamedPlant {
            plant: Plant::clone(&plant.get().plant),
            words: "a plant".to_owned(),
            hint: None,
        });
    }
    Ok((form, held))
}

/// The loop of a plant and a controller, each an object or a text of the form.
fn asked(
    plant: Option<&Bound<'_, PyControlPlant>>,
    controller: Option<&Bound<'_, PyPid>>,
    form: &Bound<'_, PyAny>,
) -> PyResult<ControlLoop> {
    let (form, mut held) = read(plant, form)?;
    if let Some(controller) = controller {
        held.controller = Some(controller.try_borrow()?.setup.clone());
    }
    ControlLoop::of(form, held).or_refused()
}

/// The report of `control analyze`.
#[pyfunction]
pub(crate) fn analyze_loop<'py>(
    py: Python<'py>,
    plant: Option<&Bound<'py, PyControlPlant>>,
    controller: Option<&Bound<'py, PyPid>>,
    form: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let asked = asked(plant, controller, form)?;
    let found = heard(py, Duration::MAX, move |_| asked.analysed().or_refused())?;
    to_python(py, &found.report)
}

/// Report, and reference, output and command.
type Run<'py> = (Bound<'py, PyAny>, [Array<f64>; 3]);

/// A reference: name and bytes of a table, or values with the time from one to the next, s.
#[derive(FromPyObject)]
pub(crate) enum Given {
    Table(String, Vec<u8>),
    Sampled(Vector, f64),
}

impl Given {
    /// Reads it on any thread; a mistake in it names its source.
    fn reader(self) -> Box<dyn FnOnce() -> Result<Reference, String> + Send> {
        match self {
            Self::Table(name, bytes) => Box::new(move || {
                let read = Reference::read(&Reference::COLUMNS.map(str::to_owned), &bytes);
                read.map_err(|error| format!("{name}: {error}"))
            }),
            Self::Sampled(Vector(values), sample_time_s) => Box::new(move || {
                let read = Reference::sampled(values, sample_time_s);
                read.map_err(|error| format!("the reference: {error}"))
            }),
        }
    }
}

/// The report of `control simulate`, and its signals.
#[pyfunction]
pub(crate) fn simulate_loop<'py>(
    py: Python<'py>,
    plant: Option<&Bound<'py, PyControlPlant>>,
    controller: Option<&Bound<'py, PyPid>>,
    form: &Bound<'py, PyAny>,
    reference: Option<Given>,
) -> PyResult<Run<'py>> {
    let asked = asked(plant, controller, form)?;
    let read = reference.map(Given::reader);
    // Millions of values are read where Ctrl-C is heard too.
    let found = heard(py, Duration::MAX, move |_| {
        let reference = read.map(|read| read()).transpose().or_refused()?;
        asked.simulated(reference.as_ref()).or_refused()
    })?;
    let report = to_python(py, &found.judged())?;
    let run = found.response;
    let signals = [run.reference, run.measured, run.command];
    Ok((report, signals.map(Array::of)))
}
