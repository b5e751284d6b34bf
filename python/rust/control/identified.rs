//! Plants from records.

use crate::conducted::{Interrupted, conduct};
use crate::json::{from_python, to_python};
use crate::refused::{OrRefused as _, refused};
use haptic_experiment::question::plant::keys::PlantForm;
use haptic_experiment::question::plant::{PlantQuestion, PlantRecord};
use numpy::PyArray1;
use pyo3::prelude::*;

/// Name and bytes of a table.
type Named = (String, Vec<u8>);

fn read(question: &PlantQuestion, (name, bytes): &Named) -> PyResult<PlantRecord> {
    let record = question.read(&question.columns, bytes);
    record.map_err(|error| refused(format_args!("{name}: {error}")))
}

/// Report, signals and plant file.
type Found<'py> = (Bound<'py, PyAny>, Vec<Bound<'py, PyArray1<f64>>>, String);

/// The plant in a record, tried on another, if there is one: report, signals with the function's output, and plant file.
#[pyfunction]
pub(crate) fn identify_plant<'py>(
    py: Python<'py>,
    record: Named,
    other: Option<Named>,
    form: &Bound<'py, PyAny>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Found<'py>> {
    let form: PlantForm = from_python("options", form)?;
    let question = PlantQuestion::of(&form).or_refused()?;
    let record = read(&question, &record)?;
    let other = other.map(|other| read(&question, &other)).transpose()?;
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
