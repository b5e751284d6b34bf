//! Plants from records.

use crate::arrays::vector;
use crate::conducted::{Interrupted, conduct};
use crate::json::{from_python, to_python};
use crate::refused::{OrRefused as _, refused};
use fractional_control::model_search::InputOutput;
use haptic_experiment::question::plant::{PlantForm, PlantQuestion, PlantRecord};
use numpy::PyArray1;
use pyo3::prelude::*;

/// Name and bytes of a table, or times, input and output.
#[derive(FromPyObject)]
pub(crate) enum Given<'py> {
    Table(String, Vec<u8>),
    Signals(Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>),
}

impl Given<'_> {
    fn read(&self, question: &PlantQuestion) -> PyResult<PlantRecord> {
        match self {
            Self::Table(name, bytes) => {
                let record = question.read(&question.columns, bytes);
                record.map_err(|error| refused(format_args!("{name}: {error}")))
            }
            Self::Signals(t, u, y) => {
                let record = InputOutput {
                    time_s: vector("t", t)?,
                    input: vector("u", u)?,
                    output: vector("y", y)?,
                    ..InputOutput::default()
                };
                let rows = 1..=record.time_s.len() as u64;
                question
                    .record(record, rows.collect(), ["t", "u", "y"])
                    .or_refused()
            }
        }
    }
}

/// The plant in a record, tried on another, if there is one: report, signals with the function's output, and plant file.
#[pyfunction]
pub(crate) fn identify_plant<'py>(
    py: Python<'py>,
    record: Given<'py>,
    other: Option<Given<'py>>,
    form: &Bound<'py, PyAny>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Vec<Bound<'py, PyArray1<f64>>>, String)> {
    let form: PlantForm = from_python("options", form)?;
    let question = PlantQuestion::of(&form).or_refused()?;
    let record = record.read(&question)?;
    let other = other.map(|other| other.read(&question)).transpose()?;
    let answer = conduct(py, progress, Interrupted::Forgotten, move |conduct| {
        let steps = |_: &_, _, done| conduct.add(done as u64);
        question
            .answer(record, other, conduct.stop(), &steps)
            .or_refused()
    })?;
    let found = &answer.record;
    let signals = [
        &found.time_s[..],
        &found.input,
        &found.output,
        answer.model(),
    ];
    let signals = signals.map(|signal| PyArray1::from_slice(py, signal));
    let program = concat!("fractional_haptics ", env!("CARGO_PKG_VERSION"));
    Ok((
        to_python(py, &answer.report)?,
        signals.into(),
        answer.to_toml(program, "a record"),
    ))
}
