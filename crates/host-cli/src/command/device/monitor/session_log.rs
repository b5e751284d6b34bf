//! The log of a session: one that cannot be written any more is said at once, and the watching goes on.

use crate::output::note;
use haptic_experiment::Failure;
use haptic_experiment::run::{Recorder, Stopped};
use haptic_log::record::RecordError;
use indicatif::ProgressBar;

/// A log while it can be written, and then nothing.
pub(super) struct SessionLog {
    recorder: Option<Recorder>,
    /// What was handed over and is not in the log.
    dropped: u64,
    unwritten: Option<Failure>,
    bar: ProgressBar,
}

impl SessionLog {
    pub(super) fn new(recorder: Result<Recorder, RecordError>, bar: &ProgressBar) -> Self {
        let mut log = Self {
            recorder: None,
            dropped: 0,
            unwritten: None,
            bar: bar.clone(),
        };
        match recorder {
            Ok(recorder) => log.recorder = Some(recorder),
            Err(error) => log.lose(error),
        }
        log
    }

    /// Hands something over, if somebody writes.
    pub(super) fn keep(&mut self, hand: impl FnOnce(&mut Recorder) -> Result<(), Stopped>) {
        let Some(mut recorder) = self.recorder.take() else {
            self.dropped += 1;
            return;
        };
        match hand(&mut recorder) {
            Ok(()) => self.recorder = Some(recorder),
            // The writer has ended, and tells why.
            Err(Stopped) => {
                self.dropped += 1 + recorder.dropped();
                if let Err(error) = recorder.finish() {
                    self.lose(error);
                }
            }
        }
    }

    fn lose(&mut self, error: RecordError) {
        let failure = Failure::from(error);
        let words = format!("{failure}; from here on nothing is kept");
        self.bar.suspend(|| note("warning", words));
        self.unwritten = Some(failure);
    }

    /// Closes the log.
    pub(super) fn close(mut self) -> Closed {
        let mut file = None;
        if let Some(recorder) = self.recorder.take() {
            self.dropped += recorder.dropped();
            match recorder.finish() {
                Ok(recorded) => {
                    let warnings = recorded.warnings.iter();
                    warnings.for_each(|warning| note("warning", warning));
                    file = Some(recorded.log.path.display().to_string());
                }
                Err(error) => self.unwritten = Some(error.into()),
            }
        }
        Closed {
            file,
            dropped: self.dropped,
            unwritten: self.unwritten,
        }
    }
}

/// What became of the log of a session.
pub(super) struct Closed {
    /// Its file, if it is whole.
    pub(super) file: Option<String>,
    /// What was handed over and is not in it.
    pub(super) dropped: u64,
    /// Why it was not written to its end.
    pub(super) unwritten: Option<Failure>,
}
