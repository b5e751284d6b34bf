//! Work of the libraries: on a thread of its own, while the one that called reports progress and listens for Ctrl-C.

use crate::arrays::{Array, Element, any_shape};
use crate::driving::Driving;
use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use pyo3::{PyClass, pyclass::boolean_struct};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

/// The longest wait for Ctrl-C to be heard, and between two reports of progress.
const LISTENS_EVERY: Duration = Duration::from_millis(20);

/// Work that takes longer has a thread of its own; what does not ends before Ctrl-C could be missed.
pub(crate) const LONG: Duration = Duration::from_millis(20);

/// State that the work shares with whoever waits for it.
#[derive(Debug, Default)]
pub(crate) struct Conduct {
    done: AtomicU64,
    stop: Arc<AtomicBool>,
    kept: Arc<AtomicBool>,
}

impl Conduct {
    pub(crate) fn add(&self, count: u64) {
        self.done.fetch_add(count, Ordering::Relaxed);
    }

    pub(crate) fn set(&self, count: u64) {
        self.done.store(count, Ordering::Relaxed);
    }

    /// True if it is to end now.
    pub(crate) fn stops(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Applies a function to each, until it is to stop.
    pub(crate) fn each<X, Y>(&self, all: &[X], function: impl Fn(&X) -> Y) -> Vec<Y> {
        let going = all.iter().take_while(|_| !self.stops());
        going.map(function).collect()
    }

    /// The end that was asked for; and what is to be set then, once there is nothing left that it could lose.
    pub(crate) fn stop_and_kept(&self) -> [Arc<AtomicBool>; 2] {
        [&self.stop, &self.kept].map(Arc::clone)
    }

    /// False if nobody waits for the end any more.
    pub(crate) fn is_awaited(&self) -> bool {
        !self.kept.load(Ordering::Relaxed)
    }

    /// Guard to be taken before a device is driven, and kept until it has let go.
    pub(crate) fn drives(&self) -> PyResult<Driving> {
        Driving::new(&self.stop)
    }

    pub(crate) fn stop(&self) -> &Arc<AtomicBool> {
        &self.stop
    }
}

/// Treatment of interrupted work, which is asked to stop in any case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interrupted {
    /// The caller waits until all is kept, or it has ended: there is a force to bring to zero, a log to close.
    Awaited,
    /// It is left to end by itself, its result forgotten.
    Forgotten,
}

/// A mistake of ours, in whatever call it shows.
fn panicked() -> PyErr {
    PyRuntimeError::new_err(
        "the library panicked, which is a mistake in it: please report the call",
    )
}

/// Does the work. `progress` is called with the number that is done, in this thread, whenever it has grown.
pub(crate) fn conduct<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    interrupted: Interrupted,
    work: impl FnOnce(&Conduct) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    let shared = Arc::new(Conduct::default());
    let (sender, receiver) = channel();
    let handle = Arc::clone(&shared);
    thread::Builder::new().spawn(move || {
        // Nobody listens any more where it was interrupted.
        let _ = sender.send(work(&handle));
    })?;
    let receiver = Mutex::new(receiver);
    let mut reported = 0;
    let mut report = |shared: &Conduct| -> PyResult<()> {
        let done = shared.done.load(Ordering::Relaxed);
        if let Some(progress) = progress
            && done > reported
        {
            reported = done;
            progress.call1((done,))?;
        }
        Ok(())
    };
    let listened = || {
        py.detach(|| match receiver.lock() {
            Ok(receiver) => receiver.recv_timeout(LISTENS_EVERY),
            Err(_) => Err(RecvTimeoutError::Disconnected),
        })
    };
    loop {
        match listened() {
            // A signal stopped it, or the end of Python. What Python itself would raise for it is raised once.
            Ok(Ok(_)) if shared.stops() => {
                py.check_signals()?;
                return Err(PyKeyboardInterrupt::new_err(()));
            }
            Ok(result) => {
                report(&shared)?;
                return result;
            }
            Err(RecvTimeoutError::Disconnected) => return Err(panicked()),
            Err(RecvTimeoutError::Timeout) => {}
        }
        if let Err(error) = report(&shared).and_then(|()| py.check_signals()) {
            shared.stop.store(true, Ordering::Relaxed);
            let waits = || interrupted == Interrupted::Awaited && shared.is_awaited();
            while waits() && matches!(listened(), Err(RecvTimeoutError::Timeout)) {}
            return Err(error);
        }
    }
}

/// Does work that nobody needs when it is interrupted: in this thread where it takes `about` so little that a thread would cost
/// more, or where no signal is heard, as on the threads of a sweep.
pub(crate) fn heard<T: Send + 'static>(
    py: Python<'_>,
    about: Duration,
    work: impl FnOnce(&Conduct) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    if about > LONG && is_main_thread(py)? {
        return conduct(py, None, Interrupted::Forgotten, work);
    }
    py.detach(|| {
        let work = AssertUnwindSafe(|| work(&Conduct::default()));
        catch_unwind(work).unwrap_or_else(|_| Err(panicked()))
    })
}

/// Work of a method that may take long; the object stays alive for it.
pub(crate) fn heard_by<C, T: Send + 'static>(
    object: &Bound<'_, C>,
    work: impl FnOnce(&C, &Conduct) -> PyResult<T> + Send + 'static,
) -> PyResult<T>
where
    C: PyClass<Frozen = boolean_struct::True> + Sync,
{
    let kept = object.clone().unbind();
    heard(object.py(), Duration::MAX, move |conduct| {
        work(kept.get(), conduct)
    })
}

/// A function of each number of an array, in the array's shape.
pub(crate) fn each<'py, T: Element + 'static>(
    name: &str,
    x: &Bound<'py, PyAny>,
    function: impl FnOnce(&[f64], &Conduct) -> Vec<T> + Send + 'static,
) -> PyResult<Bound<'py, PyAny>> {
    let py = x.py();
    let (x, shape) = any_shape(name, x)?;
    let about = Duration::from_micros(5 * x.len() as u64);
    let values = heard(py, about, move |conduct| Ok(function(&x, conduct)))?;
    let values = Array::shaped(values, shape).into_pyobject(py)?;
    // An array without dimensions becomes a number, as NumPy's own functions do.
    values.get_item(PyTuple::empty(py))
}

/// Python hears signals in its main thread alone.
fn is_main_thread(py: Python<'_>) -> PyResult<bool> {
    let threading = py.import("threading")?;
    let main = threading.call_method0("main_thread")?;
    Ok(threading.call_method0("current_thread")?.is(&main))
}
