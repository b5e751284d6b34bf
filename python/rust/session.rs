//! Sessions with a person: walls that are judged, felt and changed on one device, in one log.

use crate::conducted::{Conduct, Interrupted, conduct};
use crate::driving::Driving;
use crate::experiment::{document, failed, provenance};
use crate::json::to_python;
use haptic_experiment::Failure;
use haptic_experiment::live::{Session, SessionOptions};
use haptic_run::RealtimeOptions;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// An open session.
#[pyclass(frozen, name = "Session", module = "fractional_haptics._native")]
#[derive(Debug)]
pub(crate) struct PySession(Arc<Session>);

/// Does what may end with the session, on a thread of its own. What Python raises for a signal goes before what the session says of it.
fn conducted<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Conduct) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let done = conduct(py, progress, Interrupted::Awaited, move |conduct| {
        work(conduct).map_err(|failure| failed(&failure))
    });
    if done.is_err() {
        py.check_signals()?;
    }
    done
}

/// Opens a session on a device, which is armed when this returns; `drives` of one that is not simulated here.
#[pyfunction]
pub(crate) fn open_session(
    parameters: &Bound<'_, PyDict>,
    log: PathBuf,
    realtime: bool,
    drives: bool,
) -> PyResult<PySession> {
    let options = SessionOptions {
        document: document("wall", parameters)?,
        log,
        provenance: provenance(),
        realtime: realtime.then(RealtimeOptions::default),
    };
    let stop = Arc::new(AtomicBool::new(false));
    let driving = drives.then(|| Driving::new(&stop)).transpose()?;
    let opened = conducted(parameters.py(), None, move |conduct| {
        Session::open(options, &stop, driving, &|| conduct.stops())
    })?;
    Ok(PySession(Arc::new(opened)))
}

impl PySession {
    fn conducted<T: Send + 'static>(
        &self,
        py: Python<'_>,
        progress: Option<&Bound<'_, PyAny>>,
        work: impl FnOnce(&Session, &Conduct) -> Result<T, Failure> + Send + 'static,
    ) -> PyResult<T> {
        let session = Arc::clone(&self.0);
        conducted(py, progress, move |conduct| work(&session, conduct))
    }
}

#[pymethods]
impl PySession {
    /// Sample time of the loop, s.
    #[getter]
    fn sample_time(&self) -> f64 {
        self.0.sample_time_s()
    }

    /// Judges walls; the number of the first.
    fn allow(&self, py: Python<'_>, walls: Vec<Bound<'_, PyDict>>) -> PyResult<usize> {
        let walls = walls.iter().map(|wall| document("wall", wall));
        let walls = walls.collect::<PyResult<Vec<_>>>()?;
        self.conducted(py, None, move |session, _| session.allow(&walls))
    }

    /// Makes a wall be felt, and sums what is felt over so many ticks at most.
    fn feel(
        &self,
        py: Python<'_>,
        wall: usize,
        surface_m: f64,
        ticks: Option<u64>,
    ) -> PyResult<()> {
        self.conducted(py, None, move |session, conduct| {
            session.feel(wall, surface_m, ticks, &|| conduct.stops())
        })
    }

    /// Goes on until so many ticks were felt.
    fn go_on(
        &self,
        py: Python<'_>,
        ticks: u64,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        self.conducted(py, progress, move |session, conduct| {
            session.go_on(ticks, &|| conduct.stops(), &|felt| conduct.set(felt))
        })
    }

    /// Numbers of what was felt so far.
    fn felt<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0.felt())
    }

    /// Waits until the handle has left the wall; false if it does not.
    fn rest(&self, py: Python<'_>, patience_s: f64) -> PyResult<bool> {
        self.conducted(py, None, move |session, conduct| {
            session.rest(patience_s, &|| conduct.stops())
        })
    }

    /// Takes the wall away.
    fn pause(&self, py: Python<'_>) -> PyResult<()> {
        self.conducted(py, None, |session, conduct| {
            session.pause(&|| conduct.stops())
        })
    }

    /// The simulated hand goes this way.
    fn hand(&self, path: Vec<(f64, f64)>) -> PyResult<()> {
        self.0.hand(path).map_err(|failure| failed(&failure))
    }

    /// Puts a mark into the log.
    fn mark(&self, kind: &str, text: &str) -> PyResult<()> {
        self.0.mark(kind, text).map_err(|failure| failed(&failure))
    }

    /// Lets the force fall, and ends the session.
    fn stop(&self) {
        self.0.stop();
    }

    /// Ends the session and closes the log; its report.
    fn close<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let report = self.conducted(py, None, |session, _| session.close())?;
        to_python(py, &report)
    }
}
