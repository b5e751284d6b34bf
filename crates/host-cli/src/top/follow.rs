//! The run to be looked at: found by its log, followed entry by entry.

use super::figures::Figures;
use haptic_experiment::failure::Failure;
use haptic_log::record::{Followed, LogFollower, is_being_written};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// Folder of runs that were given no other.
const RESULTS: &str = "results";
/// Longest time spent on reading before the screen is drawn again.
const READING: Duration = Duration::from_millis(100);

/// A run that is looked at.
#[derive(Debug)]
pub struct Run {
    follower: LogFollower,
    /// Its figures so far.
    pub figures: Figures,
}

impl Run {
    /// Attaches to a run by its log, or by the folder of its log.
    ///
    /// # Errors
    /// A folder without a log, a file that is none.
    pub fn attach(path: &Path) -> Result<Self, Failure> {
        let log = match path.is_dir() {
            false => path.to_owned(),
            true => newest(&logs_of(path)).ok_or_else(|| {
                Failure::bad_input(format_args!(
                    "no log in `{}`: give the folder of a run, or its log NAME.mcap or NAME.mcap.part",
                    path.display()
                ))
            })?,
        };
        Ok(Self {
            follower: LogFollower::open(&log)?,
            figures: Figures::default(),
        })
    }

    /// The newest run that goes on under `results`; `None` if there is none.
    ///
    /// # Errors
    /// A log that cannot be read.
    pub fn newest() -> Result<Option<Self>, Failure> {
        let folders = folders_of(Path::new(RESULTS));
        let logs: Vec<PathBuf> = folders.iter().flat_map(|folder| logs_of(folder)).collect();
        let going: Vec<PathBuf> = logs
            .into_iter()
            .filter(|log| is_being_written(log))
            .collect();
        newest(&going).map(|log| Self::attach(&log)).transpose()
    }

    /// Reads what has come; true if there is more than could be read in the time.
    ///
    /// # Errors
    /// A disk that fails.
    pub fn read(&mut self) -> Result<bool, Failure> {
        let began = Instant::now();
        while let Some(entry) = self.follower.next_entry()? {
            self.figures.take(&entry);
            if began.elapsed() >= READING {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Its log.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.follower.path()
    }

    /// State of the log in words, and whether it is one to worry about.
    #[must_use]
    pub fn state(&self) -> (String, bool) {
        let ended = self.figures.end.as_ref();
        match self.follower.state() {
            _ if self.is_deleted() => (
                "the log was deleted: what the run writes is lost when it ends".to_owned(),
                true,
            ),
            Followed::Growing => ("running".to_owned(), false),
            Followed::Finished => match ended {
                Some(end) if !end.reason.is_empty() => (format!("ended: {}", end.reason), true),
                Some(_) => ("finished".to_owned(), false),
                None => ("the log ends here".to_owned(), false),
            },
            Followed::CutOff => (
                "cut off: the process that wrote the log is gone; host-cli log recover saves it"
                    .to_owned(),
                true,
            ),
        }
    }

    /// True if its log has lost its name.
    #[must_use]
    pub fn is_deleted(&self) -> bool {
        self.follower.is_deleted()
    }

    /// True while more may come.
    #[must_use]
    pub fn goes_on(&self) -> bool {
        self.follower.state() == Followed::Growing
    }
}

/// Folders of runs in a folder, and itself.
fn folders_of(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let inner = entries
        .map(|entry| entry.path())
        .filter(|path| path.is_dir());
    std::iter::once(folder.to_owned()).chain(inner).collect()
}

/// Logs in a folder, whole or not; those of faults are parts of others.
fn logs_of(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_log = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        (name.ends_with(".mcap") || name.ends_with(".mcap.part")) && !name.contains("-fault.mcap")
    };
    entries.map(|entry| entry.path()).filter(is_log).collect()
}

/// The log written to last; one that is being written before any other.
fn newest(logs: &[PathBuf]) -> Option<PathBuf> {
    let written = |log: &PathBuf| -> SystemTime {
        let modified = std::fs::metadata(log).and_then(|file| file.modified());
        modified.unwrap_or(SystemTime::UNIX_EPOCH)
    };
    let rank = |log: &&PathBuf| {
        (
            log.extension().is_some_and(|end| end == "part"),
            written(log),
        )
    };
    logs.iter().max_by_key(rank).cloned()
}
