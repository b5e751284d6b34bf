//! Work that takes long: on a thread of its own, while this one reports progress and listens for Ctrl-C.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

/// The longest wait for Ctrl-C to be heard, and between two reports of progress.
const LISTENS_EVERY: Duration = Duration::from_millis(20);

/// What the work shares with whoever waits for it.
#[derive(Debug, Default)]
pub(crate) struct Conduct {
    done: AtomicU64,
    stop: AtomicBool,
}

impl Conduct {
    /// So many more are done.
    pub(crate) fn add(&self, count: u64) {
        self.done.fetch_add(count, Ordering::Relaxed);
    }

    /// So many are done.
    pub(crate) fn set(&self, count: u64) {
        self.done.store(count, Ordering::Relaxed);
    }

    /// True if it is to end now.
    pub(crate) fn stops(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// The sign itself.
    pub(crate) fn stop(&self) -> &AtomicBool {
        &self.stop
    }
}

/// Does the work. `progress` is called with the number that is done, in this thread, whenever it has grown.
///
/// # Errors
/// What a signal's handler or `progress` raised: the work is told to stop, and waited for if it `listens`, left to itself
/// and forgotten if it does not. `RuntimeError` if the work panicked.
pub(crate) fn conduct<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    listens: bool,
    work: impl FnOnce(&Conduct) -> T + Send + 'static,
) -> PyResult<T> {
    let shared = Arc::new(Conduct::default());
    let (sender, receiver) = channel();
    let (receiver, worker) = (std::sync::Mutex::new(receiver), {
        let shared = Arc::clone(&shared);
        thread::spawn(move || {
            let _ = sender.send(work(&shared));
        })
    });
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
    loop {
        let got = py.detach(|| match receiver.lock() {
            Ok(receiver) => receiver.recv_timeout(LISTENS_EVERY),
            Err(_) => Err(RecvTimeoutError::Disconnected),
        });
        match got {
            Ok(result) => {
                report(&shared)?;
                return Ok(result);
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err(
                    "the library panicked, which is a mistake in it: please report the call",
                ));
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
        if let Err(error) = report(&shared).and_then(|()| py.check_signals()) {
            shared.stop.store(true, Ordering::Relaxed);
            if listens {
                py.detach(|| worker.join().ok());
            }
            return Err(error);
        }
    }
}
