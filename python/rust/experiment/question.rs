//! Questions: the Z-width of a device, and the best wall for it.

use super::{document, failed};
use crate::conducted::{Interrupted, conduct, heard};
use crate::json::read_json;
use crate::refused::OrRefused as _;
use haptic_experiment::question::Question;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::time::Duration;

/// The answer to the question of this document, as the command prints it.
#[pyfunction]
pub(crate) fn answer<'py>(
    kind: &str,
    parameters: &Bound<'py, PyDict>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let py = parameters.py();
    let document = document(kind, parameters)?;
    let read = move |_: &_| Question::open(&document).or_refused();
    let question = heard(py, Duration::MAX, read)?;
    // A device is brought to rest; what is simulated has nothing to lose.
    let interrupted = match question.is_simulated() {
        false => Interrupted::Awaited,
        true => Interrupted::Forgotten,
    };
    let report = conduct(py, progress, interrupted, move |conduct| {
        let drives = (!question.is_simulated()).then(|| conduct.drives());
        let _drives = drives.transpose()?;
        let answer = question.answer(&|steps| conduct.add(steps), conduct.stop(), &|_| ());
        let answer = answer.map_err(|failure| failed(&failure))?;
        serde_json::to_string(&answer).or_refused()
    })?;
    read_json(py, &report)
}
