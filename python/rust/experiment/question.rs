//! Questions to a device: what it can render, and the analyses of a wall.

use super::{Heard, PROGRAM, document, failed};
use crate::conducted::{Interrupted, conduct, heard};
use crate::json::to_python;
use crate::refused::OrRefused as _;
use haptic_experiment::Failure;
use haptic_experiment::parameters::CALIBRATION;
use haptic_experiment::question::{Calibrator, Person, Question};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use std::time::Duration;

/// The answer to the question of this document, as the command prints it, and the warnings beside it.
#[pyfunction]
pub(crate) fn answer<'py>(
    kind: &str,
    parameters: &Bound<'py, PyDict>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Vec<String>)> {
    let py = parameters.py();
    let document = document(kind, parameters)?;
    let read = move |_: &_| Question::open(&document).or_refused();
    let question = heard(py, Duration::MAX, read)?;
    // A device is brought to rest; what is simulated has nothing to lose.
    let interrupted = if question.is_simulated() {
        Interrupted::Forgotten
    } else {
        Interrupted::Awaited
    };
    let (answer, warnings) = conduct(py, progress, interrupted, move |conduct| {
        let drives = (!question.is_simulated()).then(|| conduct.drives());
        let _drives = drives.transpose()?;
        let heard = Heard::default();
        let warn = |text: &str| heard.hear(text);
        let answer = question.answer(&|steps| conduct.add(steps), conduct.stop(), &warn);
        let answer = answer.map_err(|failure| failed(&failure))?;
        // An answer that is not what was wished for is one too.
        if let Err(unmet) = answer.require(&warn) {
            warn(&unmet.to_string());
        }
        Ok((answer, heard.all()))
    })?;
    Ok((to_python(py, &answer)?, warnings))
}

/// The newtons of a device, checked: the report, the text of the device file with them, and the warnings. `read` is called on a thread of its
/// own with words for a person and the force that is held meanwhile, N, or `None`, and gives the force that the instrument shows, N.
#[pyfunction]
pub(crate) fn calibrate<'py>(
    parameters: &Bound<'py, PyDict>,
    read: Py<PyAny>,
) -> PyResult<(Bound<'py, PyAny>, String, Vec<String>)> {
    let py = parameters.py();
    let asked = Calibrator::open(&document(CALIBRATION, parameters)?).or_refused()?;
    let person: Person = Arc::new(move |words, held_n| {
        let answered =
            Python::attach(|py| read.call1(py, (words, held_n))?.extract::<Option<f64>>(py));
        let force_n =
            answered.map_err(|error| Failure::bad_input(format_args!("no reading: {error}")))?;
        Ok(force_n.unwrap_or(f64::NAN))
    });
    let (report, heard) = conduct(py, None, Interrupted::Awaited, move |conduct| {
        let _drives = conduct.drives()?;
        let heard = Heard::default();
        let report = asked.run(&person, conduct.stop(), &|text| heard.hear(text));
        Ok((report.map_err(|failure| failed(&failure))?, heard.all()))
    })?;
    Ok((to_python(py, &report)?, report.device_file(PROGRAM), heard))
}
