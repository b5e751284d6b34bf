//! The watcher of a run, and the folder of its files.

use crate::folder::FolderRequest;
use haptic_document::Warn;
use haptic_log::live::LiveStreams;
use std::sync::{Arc, atomic::AtomicBool};

/// Watcher of a run: may stop it, hears how far it is, and sees the samples.
#[derive(Clone, Copy)]
pub struct Supervisor<'a> {
    /// Set to stop the run: the force ramps to zero, the log is closed.
    pub stop: &'a Arc<AtomicBool>,
    /// Called now and then with the samples done.
    pub progress: &'a dyn Fn(u64),
    /// Streams that show the run while it goes; the first run takes them.
    pub live: Option<&'a LiveStreams>,
    /// Hears what a user should know before the run is over.
    pub warn: Warn<'a>,
}

impl std::fmt::Debug for Supervisor<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Supervisor")
            .field("stop", self.stop)
            .finish_non_exhaustive()
    }
}

/// Folder for the files of a run, and its supervisor.
#[derive(Clone, Copy, Debug)]
pub struct Watched<'a> {
    /// Folder and names of its files.
    pub request: &'a FolderRequest,
    /// Watcher of the run, which may stop it.
    pub supervisor: Supervisor<'a>,
}
