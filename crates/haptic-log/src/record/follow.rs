//! Reads a log while it grows: what a run has written so far, and then what it goes on to write.
//!
//! Its writer hands a chunk over every 100 ms of device time, so what is read is at most that old. The writer is left
//! alone: whether it lives is told by the lock that it holds, looked at only when the file has begun, which is after the
//! lock was taken.

use super::{Entry, LogReader, MetadataRecord, NEXT, RecordError};
use std::fs::{File, TryLockError};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// State of a log that is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Followed {
    /// Its writer lives; more may come.
    Growing,
    /// Whole: the run has ended.
    Finished,
    /// Its writer has died, or the log is damaged; nothing more comes.
    CutOff,
}

/// A log under either of its names, followed to its end, the files behind it too.
///
/// ```
/// use haptic_log::record::{Entry, Followed, LogFollower, LogWriter, TickMessage};
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("run.mcap");
/// let mut log = LogWriter::create(&path)?;
/// let mut follower = LogFollower::open(&path)?;
/// for tick in 0..300 {
///     log.tick(&TickMessage { tick, time_s: 1e-3 * tick as f64, ..TickMessage::default() })?;
/// }
/// let mut seen = 0;
/// while let Some(Entry::Tick(_)) = follower.next_entry()? {
///     seen += 1;
/// }
/// assert_eq!(seen, 200, "two chunks of 100 ms; the third is open");
/// assert_eq!(follower.state(), Followed::Growing);
/// log.finish()?;
/// while follower.next_entry()?.is_some() {
///     seen += 1;
/// }
/// assert_eq!((seen, follower.state()), (300, Followed::Finished));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct LogFollower {
    /// Name of the whole log.
    path: PathBuf,
    /// Second handle on the file that is read.
    file: File,
    /// `None` until the file has begun.
    reader: Option<LogReader<Growing>>,
    /// The file that the one being read names.
    next: Option<PathBuf>,
    state: Followed,
}

impl LogFollower {
    /// Opens NAME.mcap, or, where that is not there yet, NAME.mcap.part.
    ///
    /// # Errors
    /// If neither can be read, or it is not MCAP.
    pub fn open(path: &Path) -> Result<Self, RecordError> {
        let path = whole_name(path);
        let file = open_either(&path)?;
        Ok(Self {
            path,
            file,
            reader: None,
            next: None,
            state: Followed::Growing,
        })
    }

    /// The next entry; `None` if there is none now.
    ///
    /// # Errors
    /// If the disk fails, or the file is not MCAP.
    pub fn next_entry(&mut self) -> Result<Option<Entry>, RecordError> {
        loop {
            if self.reader.is_none() && !self.begin()? {
                return Ok(None);
            }
            let Some(reader) = &mut self.reader else {
                return Ok(None);
            };
            if let Some(entry) = reader.next().transpose()? {
                if let Entry::Metadata(record) = &entry {
                    self.note(record);
                }
                return Ok(Some(entry));
            }
            if reader.is_done() {
                let complete = reader.condition().complete;
                if !self.advance()? {
                    self.state = match complete {
                        true => Followed::Finished,
                        false => Followed::CutOff,
                    };
                    return Ok(None);
                }
            } else if is_written(&self.file) {
                return Ok(None);
            } else {
                // All that its writer has left is there now.
                reader.source_mut().is_whole = true;
            }
        }
    }

    /// State as of the last entry asked for.
    #[must_use]
    pub const fn state(&self) -> Followed {
        self.state
    }

    /// Name of the log when it is whole.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// True if the file being read has lost all its names: whoever writes it writes into nothing.
    #[must_use]
    pub fn is_deleted(&self) -> bool {
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt as _;
            self.file.metadata().is_ok_and(|file| file.nlink() == 0)
        }
        #[cfg(not(unix))]
        {
            !self.path.exists() && !part_of(&self.path).exists()
        }
    }

    /// Begins to read, if there is something to be read. An empty file has not begun.
    fn begin(&mut self) -> Result<bool, RecordError> {
        let failed = |source| RecordError::read(&self.path, source);
        let length = self.file.metadata().map_err(failed)?.len();
        if length < mcap::MAGIC.len() as u64 && (length == 0 || is_written(&self.file)) {
            return Ok(false);
        }
        let growing = Growing {
            file: self.file.try_clone().map_err(failed)?,
            // A start that was cut off.
            is_whole: length < mcap::MAGIC.len() as u64,
        };
        self.reader = Some(LogReader::new(growing, &self.path)?);
        Ok(true)
    }

    fn note(&mut self, record: &MetadataRecord) {
        if record.name == NEXT {
            // A name and no path: a log leads nowhere else.
            let name = record.values.get("file").map(Path::new);
            let name = name.and_then(Path::file_name);
            self.next = name.map(|name| self.path.with_file_name(name));
        }
    }

    /// Goes on with the next file; false if there is none.
    fn advance(&mut self) -> Result<bool, RecordError> {
        let Some(next) = self.next.take() else {
            return Ok(false);
        };
        self.file = open_either(&next)?;
        self.reader = None;
        Ok(true)
    }
}

/// A file whose end is none as long as its writer lives.
#[derive(Debug)]
struct Growing {
    file: File,
    is_whole: bool,
}

impl Read for Growing {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match self.file.read(bytes)? {
            0 if !self.is_whole && !bytes.is_empty() => Err(io::ErrorKind::WouldBlock.into()),
            read => Ok(read),
        }
    }
}

/// True while a log of this name is being written: its unfinished file is there and locked by its writer.
#[must_use]
pub fn is_being_written(path: &Path) -> bool {
    let part = part_of(&whole_name(path));
    File::open(part).is_ok_and(|file| is_written(&file))
}

/// True while somebody holds the lock of a file, or nobody can know.
fn is_written(file: &File) -> bool {
    if file.metadata().is_ok_and(|file| file.len() == 0) {
        // Its writer may be about to lock it.
        return true;
    }
    match file.try_lock_shared() {
        Ok(()) => {
            // Without effect if it fails: the lock ends with the file.
            let _ = file.unlock();
            false
        }
        Err(TryLockError::WouldBlock) => true,
        Err(TryLockError::Error(_)) => false,
    }
}

/// NAME.mcap for either name.
fn whole_name(path: &Path) -> PathBuf {
    match path.extension() {
        Some(end) if end == "part" => path.with_extension(""),
        _ => path.to_owned(),
    }
}

fn part_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    PathBuf::from(name)
}

/// Opens the unfinished file, or the whole one. In this order: the first becomes the second.
fn open_either(path: &Path) -> Result<File, RecordError> {
    let opened = File::open(part_of(path)).or_else(|_| File::open(path));
    opened.map_err(|source| RecordError::read(path, source))
}
