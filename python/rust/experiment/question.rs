//! Questions to a device: what it can render, and the analyses of a wall.

use super::{Heard, document, failed};
use crate::conducted::{Interrupted, conduct, heard};
use crate::json::to_python;
use crate::refused::OrRefused as _;
use haptic_experiment::question::Question;
use pyo3::prelude::*;
use pyo3::types::PyDict;
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
    let interrupted = match question.is_simulated() {
        false => Interrupted::Awaited,
        true => Interrupted::Forgotten,
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
