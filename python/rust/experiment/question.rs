//! Questions to a device: what it can render, and the analyses of a wall.

use super::{Heard, document, failed};
use crate::conducted::{Interrupted, conduct, heard};
use crate::json::to_python;
use crate::refused::OrRefused as _;
use haptic_experiment::Failure;
use haptic_experiment::parameters::CALIBRATION;
use haptic_experiment::question::{CalibrationStep, Calibrator, Question};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use std::sync::mpsc::{TryRecvError, channel};
use std::task::Poll;
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

/// The newtons of a device, checked: the report, the text of the device file with them, and the warnings. `read` is called with the words
/// for a person, and with the force that is held meanwhile, N, or `None`, and gives the force that the instrument shows, N.
#[pyfunction]
pub(crate) fn calibrate<'py>(
    parameters: &Bound<'py, PyDict>,
    read: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Option<String>, Vec<String>)> {
    let py = parameters.py();
    let asked = Calibrator::open(&document(CALIBRATION, parameters)?).or_refused()?;
    let read = read.map(Arc::new);
    let (report, heard) = conduct(py, None, Interrupted::Awaited, move |conduct| {
        let _drives = conduct.drives()?;
        let (heard, mut raised, mut asked_for) = (Heard::default(), None, None);
        // Python answers on a thread of its own: the loop of the device goes on.
        let mut answer = |step: &CalibrationStep| {
            let (_, answered) = match asked_for.take().filter(|(asked, _)| asked == step) {
                Some(waiting) => asked_for.insert(waiting),
                None => {
                    let (told, answered) = channel();
                    let (CalibrationStep { words, commanded_n }, read) = (step.clone(), read.clone());
                    std::thread::spawn(move || told.send(answer_of(read.as_deref(), &words, commanded_n)));
                    asked_for.insert((step.clone(), answered))
                }
            };
            match answered.try_recv() {
                Ok(Ok(force_n)) => Poll::Ready(Ok(force_n)),
                Err(TryRecvError::Empty) => Poll::Pending,
                other => {
                    raised = other.ok().and_then(Result::err);
                    Poll::Ready(Err(Failure::run("no reading came")))
                }
            }
        };
        let report = asked.run(&mut answer, conduct.stop(), &|text| heard.hear(text));
        if let Some(error) = raised {
            return Err(error);
        }
        Ok((report.map_err(|failure| failed(&failure))?, heard.all()))
    })?;
    let file = report.device_file(crate::experiment::PROGRAM);
    Ok((to_python(py, &report)?, file, heard))
}

fn answer_of(read: Option<&Py<PyAny>>, words: &str, commanded_n: Option<f64>) -> PyResult<f64> {
    let read = read.ok_or_else(|| PyValueError::new_err("a device is read by somebody: give read"))?;
    Python::attach(|py| {
        let answered = read.call1(py, (words, commanded_n))?;
        commanded_n.map_or(Ok(0.0), |_| answered.extract(py))
    })
}
