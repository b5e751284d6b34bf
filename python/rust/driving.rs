//! Devices that are driven: neither a signal nor the end of Python leaves a force on one.
//!
//! A signal that Python leaves to the system stops the runs on devices. When the last of them has let go, the signal does what it does
//! to any program: it ends it, or stops it. Without a run on a device it does that at once. One with a handler of the program's own is
//! left to that. Of the signal that becomes a `KeyboardInterrupt` the runs hear as well: Python raises it only when its main thread runs
//! again, which one that waits for input may not do for long.

use haptic_run::signals::{signals, uncaught};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use signal_hook::{SigId, flag, low_level};
use std::collections::BTreeSet;
use std::ffi::c_int;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, LazyLock, Mutex, MutexGuard, PoisonError};

/// True while this process drives no device.
static RESTS: LazyLock<Arc<AtomicBool>> = LazyLock::new(|| Arc::new(AtomicBool::new(true)));
/// The signal that came meanwhile; 0 for none.
static CAME: LazyLock<Arc<AtomicUsize>> = LazyLock::new(Arc::default);
static DRIVEN: Mutex<Driven> = Mutex::new(Driven {
    runs: Vec::new(),
    heard: BTreeSet::new(),
});
static LET_GO: Condvar = Condvar::new();

#[derive(Debug)]
struct Driven {
    /// Flag that stops each run.
    runs: Vec<Arc<AtomicBool>>,
    heard: BTreeSet<c_int>,
}

fn driven() -> MutexGuard<'static, Driven> {
    DRIVEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Signals to which Python has no handler, and which are not ignored.
fn left_to_the_system(py: Python<'_>) -> PyResult<Vec<c_int>> {
    let module = py.import("signal")?;
    let default = module.getattr("SIG_DFL")?;
    let mut left = signals();
    left.retain(|signal| {
        let handler = module.call_method1("getsignal", (signal,));
        handler.is_ok_and(|handler| handler.eq(&default).unwrap_or(false))
    });
    Ok(left)
}

/// The signal of Ctrl-C where it becomes a `KeyboardInterrupt`; its handler is called after ours.
fn interrupt(py: Python<'_>) -> PyResult<Option<c_int>> {
    let module = py.import("signal")?;
    let signal: c_int = module.getattr("SIGINT")?.extract()?;
    let handler = module.call_method1("getsignal", (signal,))?;
    let raises = handler.is(&module.getattr("default_int_handler")?);
    Ok((raises && signals().contains(&signal)).then_some(signal))
}

/// True for a signal whose way to end a program is known to `signal-hook`; it takes IO for one that does nothing.
fn is_known(signal: c_int) -> bool {
    low_level::signal_name(signal).is_some_and(|name| name != "SIGIO")
}

/// Lets signals do at once, from now on, what they do to any program; the one that has come is done first. To be stopped, and to go on later,
/// is waited for here.
fn rest() {
    RESTS.store(true, Ordering::SeqCst);
    let came = CAME.swap(0, Ordering::SeqCst) as c_int;
    if came != 0 && (!is_known(came) || low_level::emulate_default_handler(came).is_err()) {
        low_level::exit(EXIT + came);
    }
}

/// Exit code of a program that a signal has ended, less its number, as shells report it.
const EXIT: c_int = 128;

/// A run that drives a device, from before its first force until it has let go.
#[derive(Debug)]
pub(crate) struct Driving {
    stop: Arc<AtomicBool>,
    listens: Vec<SigId>,
}

impl Driving {
    /// Sets `stop` at each signal that Python leaves to the system, and when Python ends.
    pub(crate) fn new(stop: &Arc<AtomicBool>) -> PyResult<Self> {
        let signals = Python::attach(left_to_the_system)?;
        let interrupt = Python::attach(interrupt)?;
        // Before the lock, which it takes when it is dropped.
        let mut this = Self {
            stop: Arc::clone(stop),
            listens: Vec::new(),
        };
        let mut driven = driven();
        if driven.runs.is_empty() {
            CAME.store(0, Ordering::SeqCst);
        }
        for &signal in &signals {
            if driven.heard.insert(signal) {
                let rests = Arc::clone(&RESTS);
                if is_known(signal) {
                    flag::register_conditional_default(signal, rests)?;
                } else {
                    flag::register_conditional_shutdown(signal, EXIT + signal, rests)?;
                }
                flag::register_usize(signal, Arc::clone(&CAME), signal as usize)?;
            }
            this.listens.push(flag::register(signal, Arc::clone(stop))?);
        }
        if let Some(signal) = interrupt {
            this.listens.push(flag::register(signal, Arc::clone(stop))?);
        }
        if let Some(signal) = uncaught(&signals) {
            let name = low_level::signal_name(signal).unwrap_or("a signal");
            return Err(PyRuntimeError::new_err(format!(
                "{name} ({signal}) would leave the force on the device: this process had a handler for it and removed it; keep it, \
                 or run in another process"
            )));
        }
        driven.runs.push(Arc::clone(stop));
        RESTS.store(false, Ordering::SeqCst);
        Ok(this)
    }
}

impl Drop for Driving {
    fn drop(&mut self) {
        for listens in self.listens.drain(..) {
            low_level::unregister(listens);
        }
        let mut driven = driven();
        (driven.runs).retain(|stop| !Arc::ptr_eq(stop, &self.stop));
        if driven.runs.is_empty() {
            rest();
        }
        LET_GO.notify_all();
    }
}

/// Stops every run on a device, and waits until the last has let go. None begins after it.
#[pyfunction]
pub(crate) fn let_go(py: Python<'_>) {
    py.detach(|| {
        let mut driven = driven();
        (driven.runs.iter()).for_each(|stop| stop.store(true, Ordering::SeqCst));
        while !driven.runs.is_empty() {
            driven = LET_GO.wait(driven).unwrap_or_else(PoisonError::into_inner);
        }
        // Whoever would drive a device now waits for this lock until the process is gone.
        std::mem::forget(driven);
    });
}

/// Makes a fork drive none of the devices of its parent, so that signals end it as any other process.
#[pyfunction]
pub(crate) fn forked() {
    // Nobody here would give a lock back that another thread of the parent has.
    if let Ok(mut driven) = DRIVEN.try_lock() {
        driven.runs.clear();
    }
    rest();
}
