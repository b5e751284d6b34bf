//! Brings a growing log to the disk itself, from a thread of its own: what the writer has handed over survives its
//! process, but for up to half a minute not a power cut. `sync_data` may take long, so the writer does not wait for
//! it.

use std::{
    fs::File,
    io,
    sync::mpsc::{RecvTimeoutError, Sender, channel},
    thread::JoinHandle,
    time::Duration,
};

/// Time between two syncs of a log that is being written.
pub const SYNC_INTERVAL: Duration = Duration::from_secs(1);

/// Syncs a file at an interval, until it is stopped or dropped.
#[derive(Debug)]
pub(super) struct Syncer {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<io::Result<u32>>>,
}

impl Syncer {
    pub(super) fn start(file: &File, interval: Duration) -> io::Result<Self> {
        let file = file.try_clone()?;
        let (stop, stopped) = channel::<()>();
        let thread = std::thread::Builder::new()
            .name("log sync".to_owned())
            .spawn(move || {
                let mut syncs = 0;
                while stopped.recv_timeout(interval) == Err(RecvTimeoutError::Timeout) {
                    file.sync_data()?;
                    syncs += 1;
                }
                Ok(syncs)
            })?;
        Ok(Self {
            stop: Some(stop),
            thread: Some(thread),
        })
    }

    /// Stops, and says how often it did.
    pub(super) fn stop(mut self) -> io::Result<u32> {
        self.stop = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            // A panic in there is a defect; let it be seen as one.
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => Ok(0),
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
    use std::time::Instant;
    use testkit::Tested;

    #[test]
    fn a_file_is_synced_at_the_interval_until_it_is_stopped() -> Tested {
        let file = tempfile::tempfile()?;
        let syncer = Syncer::start(&file, Duration::from_millis(5))?;
        std::thread::sleep(Duration::from_millis(200));
        let syncs = syncer.stop()?;
        assert!(syncs >= 2, "{syncs}");
        // The stop does not wait for the interval.
        let began = Instant::now();
        let syncer = Syncer::start(&file, Duration::from_secs(600))?;
        assert_eq!(syncer.stop()?, 0);
        assert!(began.elapsed() < Duration::from_secs(60));
        Ok(())
    }
}
