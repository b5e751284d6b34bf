//! A log in a file of its own: created, brought to the disk, and named when it is whole.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::LogWriter;
use crate::record::sync::{SyncTimes, Syncer};
use crate::record::{Leftover, NewFile, NewFileError, RecordError};

/// Files that [`LogWriter::finish`] leaves on the disk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FinishedLog {
    /// The file, the first if there are more.
    pub path: PathBuf,
    /// All files, in order.
    pub paths: Vec<PathBuf>,
    /// Ticks in it.
    pub samples: u64,
    /// Its size.
    pub bytes: u64,
    /// Number and durations of the syncs to the disk while the log grew.
    pub syncs: SyncTimes,
}

impl LogWriter<BufWriter<File>> {
    /// Starts the log `path`, under the name `path.part` until it is finished.
    ///
    /// # Errors
    /// If `path` or `path.part` exists, or the folder does not take the file.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        Self::create_with(path, Leftover::Keep, false)
    }

    /// As [`create`](Self::create), with a choice of what happens to an unfinished file, and whether
    /// the finished one may replace another.
    ///
    /// # Errors
    /// As there.
    pub fn create_with(
        path: &Path,
        leftover: Leftover,
        overwrite: bool,
    ) -> Result<Self, RecordError> {
        Self::create_synced(path, leftover, overwrite, None)
    }

    /// As [`create_with`](Self::create_with); brought to the disk at an interval, if one is given.
    pub(crate) fn create_synced(
        path: &Path,
        leftover: Leftover,
        overwrite: bool,
        interval: Option<Duration>,
    ) -> Result<Self, RecordError> {
        let (new_file, file) = NewFile::create(path, leftover, overwrite)?;
        let syncer = interval.map(|interval| Syncer::start(&file, interval));
        let started = syncer
            .transpose()
            .map_err(|error| NewFileError::io(path, error).into())
            .and_then(|syncer| {
                let mut writer = Self::with_sink(BufWriter::new(file), new_file.part())?;
                writer.syncer = syncer;
                Ok(writer)
            });
        match started {
            Ok(mut writer) => {
                // The name in the folder must survive a power cut as well.
                new_file.sync_folder();
                writer.new_file = Some(new_file);
                Ok(writer)
            }
            Err(error) => {
                new_file.discard();
                Err(unbegun(path, error))
            }
        }
    }

    /// Takes the file back for a log that could not begin; its error, in which no sample is.
    pub(crate) fn take_back(mut self, error: RecordError) -> RecordError {
        match self.new_file.take() {
            Some(new_file) => {
                let path = new_file.target().to_owned();
                new_file.discard();
                unbegun(&path, error)
            }
            None => error,
        }
    }

    /// Writes the index, brings the file to the disk and gives it its name.
    ///
    /// # Errors
    /// If the disk is full, or the name was taken in the meantime; the `.part` file stays. If that was removed or cut meanwhile.
    pub fn finish(mut self) -> Result<FinishedLog, RecordError> {
        let new_file = self.new_file.take();
        let syncer = self.syncer.take();
        let (path, samples) = (self.path.clone(), self.samples);
        let fail = |source| RecordError::Write {
            path: path.clone(),
            samples_safe: samples,
            source,
        };
        let control = self.control.clone();
        let sink = self.close()?;
        let file = sink
            .into_inner()
            .map_err(|error| fail(error.into_error()))?;
        file.sync_data().map_err(fail)?;
        let syncs = syncer.map_or(Ok(SyncTimes::default()), Syncer::stop);
        let syncs = syncs.map_err(fail)?;
        let bytes = file.metadata().map_err(fail)?.len();
        let path = match new_file {
            Some(new_file) => {
                // Seen here and not earlier, as nobody else writes to it: what was appended after that is in it, or in no folder.
                let what = match new_file.part().exists() {
                    false => Some("removed"),
                    true if bytes < control.bytes() => Some("emptied or cut"),
                    true => None,
                };
                if let Some(what) = what {
                    return Err(RecordError::Lost {
                        path,
                        what,
                        samples,
                    });
                }
                let target = new_file.target().to_owned();
                new_file.publish()?;
                target
            }
            None => path,
        };
        Ok(FinishedLog {
            paths: vec![path.clone()],
            path,
            samples,
            bytes,
            syncs,
        })
    }
}

/// A log whose first bytes the disk did not take is a file that could not be created.
fn unbegun(path: &Path, error: RecordError) -> RecordError {
    match error {
        RecordError::Write { source, .. } => NewFileError::io(path, source).into(),
        other => other,
    }
}
