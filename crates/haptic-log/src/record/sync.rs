//! Brings a growing log to the disk itself, from a thread of its own: what the writer has handed over survives its
//! process, but for up to half a minute not a power cut. `sync_data` may take long, so the writer does not wait for
//! it.

use std::fs::File;
use std::io;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two syncs of a log that is being written.
pub const SYNC_INTERVAL: Duration = Duration::from_secs(1);

/// Number and durations of the syncs of a log.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SyncTimes {
    /// Number of syncs.
    pub count: u32,
    /// All together.
    pub total: Duration,
    /// The longest.
    pub longest: Duration,
}

/// Syncs a file at an interval, until it is stopped or dropped.
#[derive(Debug)]
pub(super) struct Syncer {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<io::Result<SyncTimes>>>,
}

impl Syncer {
    /// Starts.
    pub(super) fn start(file: &File, interval: Duration) -> io::Result<Self> {
        let file = file.try_clone()?;
        let (stop, stopped) = channel::<()>();
        let thread = std::thread::Builder::new()
            .name("log sync".to_owned())
            .spawn(move || {
                let mut times = SyncTimes::default();
                while stopped.recv_timeout(interval) == Err(RecvTimeoutError::Timeout) {
                    let began = Instant::now();
                    file.sync_data()?;
                    let took = began.elapsed();
                    times.count += 1;
                    times.total += took;
                    times.longest = times.longest.max(took);
                }
                Ok(times)
            })?;
        Ok(Self {
            stop: Some(stop),
            thread: Some(thread),
        })
    }

    /// Stops.
    pub(super) fn stop(mut self) -> io::Result<SyncTimes> {
        self.stop = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            // A panic in there is a defect; let it be seen as one.
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => Ok(SyncTimes::default()),
        }
    }
}

impl Drop for Syncer {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            // The log has failed otherwise already.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_synced_at_the_interval_until_it_is_stopped() {
        let file = tempfile::tempfile().expect("a file");
        let syncer = Syncer::start(&file, Duration::from_millis(5)).expect("starts");
        std::thread::sleep(Duration::from_millis(200));
        let times = syncer.stop().expect("syncs");
        assert!(times.count >= 2, "{times:?}");
        assert!(times.longest <= times.total, "{times:?}");
        // The stop does not wait for the interval.
        let began = Instant::now();
        let syncer = Syncer::start(&file, Duration::from_secs(600)).expect("starts");
        assert_eq!(syncer.stop().expect("stops"), SyncTimes::default());
        assert!(began.elapsed() < Duration::from_secs(60));
    }
}
