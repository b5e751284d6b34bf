//! Whoever stops what is done with a device: a flag, looked at in each wait.

use super::error::SerialError;
use crate::LinkError;
use core::fmt::Display;
use haptic_loop::realtime::Moment;
use std::{
    string::ToString as _,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::{RecvTimeoutError, sync_channel},
    },
    thread::JoinHandle,
    time::Duration,
};

/// Time from one look at the flag to the next.
const LOOK: Duration = Duration::from_millis(20);

/// Does what may take its time on a thread of its own, which ends by itself, unless `stop` is set meanwhile: within 20 ms.
///
/// # Errors
/// [`LinkError::Stopped`]; no thread.
pub fn unless_stopped<T: Send + 'static>(
    stop: Option<&Arc<AtomicBool>>,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, SerialError> {
    if stop.is_none() {
        return Ok(work());
    }
    let (done, result) = sync_channel(1);
    spawn("opening", move || {
        // Nobody hears it any more if it was stopped.
        let _ = done.send(work());
    })?;
    while !is_set(stop) {
        match result.recv_timeout(LOOK) {
            Err(RecvTimeoutError::Timeout) => {}
            result => return result.map_err(thread_error),
        }
    }
    Err(LinkError::Stopped.into())
}

pub(super) fn is_set(stop: Option<&Arc<AtomicBool>>) -> bool {
    stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
}

/// Sleeps for `time`; false if `stop` was set meanwhile, which is noticed within 50 ms.
pub(super) fn sleep(time: Duration, stop: Option<&Arc<AtomicBool>>) -> bool {
    let until = Moment::now() + time;
    while !is_set(stop) {
        let left = until.saturating_duration_since(Moment::now());
        if left.is_zero() {
            return true;
        }
        std::thread::sleep(left.min(Duration::from_millis(50)));
    }
    false
}

pub(super) fn spawn(
    name: &str,
    run: impl FnOnce() + Send + 'static,
) -> Result<JoinHandle<()>, SerialError> {
    let builder = std::thread::Builder::new().name(name.to_string());
    builder.spawn(run).map_err(thread_error)
}

fn thread_error(error: impl Display) -> SerialError {
    SerialError::Thread {
        reason: error.to_string(),
    }
}
