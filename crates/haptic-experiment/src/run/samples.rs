//! The samples of a run, wherever they are: in memory, or in its log.

use super::record::{Record, Start};
use super::tick::KeptSample;
use haptic_document::Failure;
use haptic_log::record::{Entry, LogReader};
use std::path::PathBuf;

/// Place of the samples of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Samples<'a> {
    Whole(&'a [KeptSample]),
    /// In the files of the log, from this tick on, up to this one as it is counted from there.
    Logged(&'a [PathBuf], Start, u64),
}

impl<'a> Samples<'a> {
    /// Those of a record whose log has these files.
    pub(crate) fn of(record: &'a Record, logs: &'a [PathBuf]) -> Self {
        match (&record.whole, record.last) {
            (Some(whole), _) => Self::Whole(whole),
            (None, Some(last)) => Self::Logged(logs, record.start, last.tick),
            (None, None) => Self::Whole(&[]),
        }
    }

    pub(crate) fn for_each(
        self,
        mut take: impl FnMut(&KeptSample) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        match self {
            Self::Whole(samples) => samples.iter().try_for_each(take),
            Self::Logged(logs, start, last_tick) => {
                for log in logs {
                    for entry in LogReader::open(log)? {
                        let Entry::Tick(message) = entry? else {
                            continue;
                        };
                        let counted = start.counted(KeptSample::of(&message));
                        if let Some(sample) = counted.filter(|sample| sample.tick <= last_tick) {
                            take(&sample)?;
                        }
                    }
                }
                Ok(())
            }
        }
    }
}
