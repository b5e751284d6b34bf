//! Sessions with a person: walls that are judged, felt and changed on one device, in one log.

use crate::conducted::{Conduct, Interrupted, conduct};
use crate::driving::Driving;
use crate::experiment::{document, failed, provenance};
use crate::json::to_python;
use haptic_experiment::Failure;
use haptic_experiment::live::{Session, SessionOptions};
use haptic_run::RealtimeOptions;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, ThreadId};

/// An open session, of the process and the thread that opened it.
#[pyclass(frozen, name = "Session", module = "fractional_haptics._native")]
#[derive(Debug)]
pub(crate) struct PySession {
    session: Arc<Session>,
    process: u32,
    thread: ThreadId,
    /// A call goes on, from which `progress` may call again.
    calls: AtomicBool,
}

impl Drop for PySession {
    fn drop(&mut self) {
        if self.process != std::process::id() {
            // A fork has none of the threads that an end waits for.
            std::mem::forget(Arc::clone(&self.session));
        }
    }
}

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
    // Without a device at a port there is no force to be left, but a log to be closed.
    let driving = match Driving::new(&stop) {
        Err(_) if !drives => None,
        driving => Some(driving?),
    };
    let opened = conducted(parameters.py(), None, move |conduct| {
        Session::open(options, &stop, driving, &|| conduct.stops())
    })?;
    Ok(PySession {
        session: Arc::new(opened),
        process: std::process::id(),
        thread: thread::current().id(),
        calls: AtomicBool::new(false),
    })
}

impl PySession {
    fn conducted<T: Send + 'static>(
        &self,
        py: Python<'_>,
        progress: Option<&Bound<'_, PyAny>>,
        work: impl FnOnce(&Session, &Conduct) -> Result<T, Failure> + Send + 'static,
    ) -> PyResult<T> {
        self.may_call(false)?;
        self.calls.store(true, Ordering::Relaxed);
        let session = Arc::clone(&self.session);
        let done = conducted(py, progress, move |conduct| work(&session, conduct));
        self.calls.store(false, Ordering::Relaxed);
        done
    }

    /// Refuses a call of another process or thread, or out of a call that goes on; to stop, any thread may call.
    fn may_call(&self, to_stop: bool) -> PyResult<()> {
        let here = thread::current().id() == self.thread;
        let why = if self.process != std::process::id() {
            "this session is of the process that this one was forked from: open one of its own here"
        } else if !here && !to_stop {
            "a session is of the thread that opened it: call it there; stop alone may be called from any other"
        } else if here && self.calls.load(Ordering::Relaxed) {
            "progress cannot call the session that reports to it, nor stop it: end feel by a true value of until"
        } else {
            return Ok(());
        };
        Err(PyRuntimeError::new_err(why))
    }
}

#[pymethods]
impl PySession {
    /// Sample time of the loop, s.
    #[getter]
    fn sample_time(&self) -> f64 {
        self.session.sample_time_s()
    }

    /// Judges walls; the number of the first.
    fn allow(&self, py: Python<'_>, walls: Vec<Bound<'_, PyDict>>) -> PyResult<usize> {
        let walls = walls.iter().map(|wall| document("wall", wall));
        let walls = walls.collect::<PyResult<Vec<_>>>()?;
        self.conducted(py, None, move |session, _| session.allow(&walls))
    }

    /// Proves all walls between two.
    fn allow_between(
        &self,
        py: Python<'_>,
        first: &Bound<'_, PyDict>,
        second: &Bound<'_, PyDict>,
    ) -> PyResult<()> {
        let ends = [document("wall", first)?, document("wall", second)?];
        self.conducted(py, None, move |session, _| {
            session.allow_between(ends.each_ref())
        })
    }

    /// The number of a wall in a region.
    fn inside(&self, py: Python<'_>, wall: &Bound<'_, PyDict>) -> PyResult<usize> {
        let wall = document("wall", wall)?;
        self.conducted(py, None, move |session, _| session.inside(&wall))
    }

    /// Makes a wall be felt, and sums what is felt over so many ticks at most; false if the handle stayed behind its surface.
    fn feel(
        &self,
        py: Python<'_>,
        wall: usize,
        surface_m: f64,
        ticks: Option<u64>,
        patience_s: f64,
    ) -> PyResult<bool> {
        self.conducted(py, None, move |session, conduct| {
            session.feel(wall, surface_m, ticks, patience_s, &|| conduct.stops())
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
        self.may_call(false)?;
        to_python(py, &self.session.felt())
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
        self.may_call(false)?;
        (self.session)
            .hand(path)
            .map_err(|failure| failed(&failure))
    }

    /// Puts a mark into the log.
    fn mark(&self, kind: &str, text: &str) -> PyResult<()> {
        self.may_call(false)?;
        (self.session)
            .mark(kind, text)
            .map_err(|failure| failed(&failure))
    }

    /// Lets the force fall, and ends the session.
    fn stop(&self) -> PyResult<()> {
        self.may_call(true)?;
        self.session.stop();
        Ok(())
    }

    /// Ends the session and closes the log; its report.
    fn close<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let report = self.conducted(py, None, |session, _| session.close())?;
        to_python(py, &report)
    }
}
