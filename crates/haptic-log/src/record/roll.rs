//! A log in several files, each of them whole.
//!
//! ```text
//! NAME.mcap ─next▶ NAME-0002.mcap ─next▶ NAME-0003.mcap
//! ```
//! Every file has the metadata of the run, with a number drawn for it, and its own index; one that is followed by
//! another names it ([`NEXT`]), one that follows another names the first ([`CONTINUES`]). [`LogFiles`] reads all of
//! them as one, and no file of another run.

use std::{
    collections::{BTreeMap, BTreeSet, VecDeque},
    fs::File,
    io::{BufReader, BufWriter},
    path::{Path, PathBuf},
};

use super::{
    CLOCK, Condition, Damage, Entry, FinishedLog, Leftover, LogReader, LogWriter, RecordError,
    SYNC_INTERVAL, StartTime,
    new_file::{drawn_number, remove_earlier},
    order::InOrder,
    part_of,
};
use haptic_message::{EventMessage, TickMessage};

/// Name of the metadata record that names the next file of a log.
pub const NEXT: &str = "next";
/// Name of the metadata record that names the first file of a log, in each that follows it.
pub const CONTINUES: &str = "continues";
/// Key of the number of a run in its metadata.
const RUN: &str = "run";
/// Smallest size at which a log is split into files, bytes.
pub const ROLL_LEAST: u64 = 1_000_000;
/// No log has more files.
const FILES_MOST: usize = 9999;

/// A log that continues in another file when one is full. Written to the disk as it grows.
///
/// ```
/// use haptic_log::record::{LogFiles, RollingLog};
/// use haptic_message::TickMessage;
///
/// let folder = tempfile::tempdir()?;
/// let first = folder.path().join("day.mcap");
/// let mut log = RollingLog::create(&first, [("mu".to_owned(), "0.5".to_owned())].into(), false)?;
/// // Files of 100 MB: day.mcap, day-0002.mcap, …
/// log.roll_at(100_000_000);
/// for tick in 0..100 {
///     log.tick(&TickMessage { tick, time_s: 1e-3 * tick as f64, ..TickMessage::at_rest(1) })?;
/// }
/// let finished = log.finish()?;
/// assert_eq!(finished.paths, [first.clone()]);
/// // 100 ticks and the metadata, however many files there are.
/// assert_eq!(LogFiles::open(&first)?.count(), 101);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct RollingLog {
    log: LogWriter<BufWriter<File>>,
    first: PathBuf,
    overwrite: bool,
    /// Size at which a file is full, bytes; `None` for one file however long.
    full_bytes: Option<u64>,
    /// Metadata at the start of every file, the number of the run with them.
    metadata: BTreeMap<String, String>,
    started: Option<StartTime>,
    done: Vec<FinishedLog>,
}

impl RollingLog {
    /// Starts the first file, with metadata `experiment`, among them the number of the run: `run`.
    ///
    /// # Errors
    /// If the file exists, unless `overwrite`, or cannot be made.
    pub fn create(
        first: &Path,
        mut metadata: BTreeMap<String, String>,
        overwrite: bool,
    ) -> Result<Self, RecordError> {
        metadata.insert(RUN.to_owned(), drawn_number());
        Ok(Self {
            log: begin(first, &metadata, overwrite)?,
            first: first.to_owned(),
            overwrite,
            full_bytes: None,
            metadata,
            started: None,
            done: Vec::new(),
        })
    }

    /// Sets the size at which a file is full, bytes; less is raised to [`ROLL_LEAST`].
    pub fn roll_at(&mut self, full_bytes: u64) {
        self.full_bytes = Some(full_bytes.max(ROLL_LEAST));
    }

    /// See [`LogWriter::starts_at`].
    ///
    /// # Errors
    /// If the disk fails.
    pub fn starts_at(&mut self, start: StartTime) -> Result<(), RecordError> {
        self.started = Some(start);
        self.log.starts_at(start)
    }

    /// See [`LogWriter::metadata`].
    ///
    /// # Errors
    /// If the disk fails.
    pub fn metadata(
        &mut self,
        name: &str,
        values: BTreeMap<String, String>,
    ) -> Result<(), RecordError> {
        self.log.metadata(name, values)
    }

    /// See [`LogWriter::event`].
    ///
    /// # Errors
    /// If the disk fails.
    pub fn event(&mut self, message: &EventMessage) -> Result<(), RecordError> {
        self.log.event(message)
    }

    /// See [`LogWriter::tick`].
    ///
    /// # Errors
    /// If the disk fails, or the next file cannot be made.
    pub fn tick(&mut self, message: &TickMessage) -> Result<(), RecordError> {
        let is_full = self.full_bytes.is_some_and(|full| self.log.bytes() >= full);
        if is_full && self.done.len() + 2 <= FILES_MOST {
            self.roll()?;
        }
        self.log.tick(message)
    }

    /// See [`LogWriter::drive_tick`].
    ///
    /// # Errors
    /// If the disk fails.
    pub fn drive_tick(&mut self, message: &TickMessage) -> Result<(), RecordError> {
        self.log.drive_tick(message)
    }

    fn roll(&mut self) -> Result<(), RecordError> {
        let next = nth_file(&self.first, self.done.len() + 2);
        // The next file is there before the last one names it.
        self.remove_stale();
        let mut log = begin(&next, &self.metadata, self.overwrite)?;
        log.metadata(CONTINUES, file_name(&self.first))?;
        if let Some(start) = self.started {
            log.starts_at(start)?;
        }
        let mut full = std::mem::replace(&mut self.log, log);
        full.metadata(NEXT, file_name(&next))?;
        self.done.push(full.finish()?);
        Ok(())
    }

    /// Removes the further files of an earlier log before the first file takes its place: they would pass for files of this one.
    fn remove_stale(&self) {
        if self.overwrite && self.done.is_empty() {
            let further = (2..=FILES_MOST).map(|n| nth_file(&self.first, n));
            for stale in further.take_while(|file| file.exists()) {
                remove_earlier(&stale);
            }
        }
    }

    /// Ends the last file. With overwriting, the further files of an earlier log are removed.
    ///
    /// # Errors
    /// As [`LogWriter::finish`].
    pub fn finish(self) -> Result<FinishedLog, RecordError> {
        self.remove_stale();
        let mut files = self.done;
        files.push(self.log.finish()?);
        let mut whole = files[0].clone();
        for file in &files[1..] {
            whole.paths.push(file.path.clone());
            whole.samples += file.samples;
            whole.bytes += file.bytes;
        }
        Ok(whole)
    }
}

fn begin(
    path: &Path,
    metadata: &BTreeMap<String, String>,
    overwrite: bool,
) -> Result<LogWriter<BufWriter<File>>, RecordError> {
    let interval = Some(SYNC_INTERVAL);
    let mut log = LogWriter::create_with(path, Leftover::Keep, overwrite, interval)?;
    match log.metadata("experiment", metadata.clone()) {
        Ok(()) => Ok(log),
        Err(error) => Err(log.take_back(error)),
    }
}

/// The name of a file beside this one, as metadata.
fn file_name(file: &Path) -> BTreeMap<String, String> {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    [("file".to_owned(), name.into_owned())].into()
}

/// NAME-0002.mcap for NAME.mcap and 2.
#[must_use]
pub fn nth_file(first: &Path, number: usize) -> PathBuf {
    let stem = first.file_stem().unwrap_or_default().to_string_lossy();
    first.with_file_name(format!("{stem}-{number:04}.mcap"))
}

/// NAME.mcap for NAME-0002.mcap, as [`nth_file`] names it; `None` for a name that continues no other.
#[must_use]
pub fn first_file(file: &Path) -> Option<PathBuf> {
    let stem = file.file_stem()?.to_str()?;
    let (first, number) = stem.rsplit_once('-')?;
    let is_number = number.len() == 4 && number.bytes().all(|byte| byte.is_ascii_digit());
    is_number.then(|| file.with_file_name(format!("{first}.mcap")))
}

/// Iterates over the [entries](Entry) of a log and of the files that follow it, with the ticks in the order of their numbers
/// wherever their messages stand: MCAP asks for no order. A tick that comes more than 65 536 entries too late stays there.
#[derive(Debug)]
pub struct LogFiles {
    pub(super) reader: LogReader<BufReader<File>>,
    pub(super) path: PathBuf,
    /// The file that the one being read names.
    next: Option<PathBuf>,
    /// Files read, with the one being read.
    pub(super) read: BTreeSet<PathBuf>,
    /// Number of the run, of a log that has one.
    run: Option<String>,
    /// False until the file being read is known to be of the run.
    belongs: bool,
    before: Condition,
    /// Ticks, with what stands between them, and ticks of the drive.
    ticks: InOrder,
    driven: InOrder,
    ready: VecDeque<Entry>,
}

impl LogFiles {
    /// Opens the first file.
    ///
    /// # Errors
    /// If it cannot be read or is not MCAP.
    pub fn open(path: &Path) -> Result<Self, RecordError> {
        Ok(Self {
            reader: LogReader::open(path)?,
            path: path.to_owned(),
            next: None,
            read: [path.to_owned()].into(),
            run: None,
            belongs: true,
            before: Condition {
                complete: true,
                ..Condition::default()
            },
            ticks: InOrder::default(),
            driven: InOrder::default(),
            ready: VecDeque::new(),
        })
    }

    /// Condition of the log; valid once the iteration has ended.
    #[must_use]
    pub fn condition(&self) -> Condition {
        let Condition {
            complete,
            damage,
            foreign_topics,
            ..
        } = self.reader.condition();
        let mut all = self.before.clone();
        all.sorted = self.ticks.sorted + self.driven.sorted;
        all.out_of_order = self.ticks.out_of_order + self.driven.out_of_order;
        all.complete &= complete;
        all.damage.extend_from_slice(damage);
        for (topic, messages) in foreign_topics {
            *all.foreign_topics.entry(topic.clone()).or_default() += messages;
        }
        all
    }

    /// See [`LogReader::started`].
    #[must_use]
    pub fn started(&self) -> Option<StartTime> {
        self.reader.started()
    }

    /// Ends the reading with something missing.
    fn end(&mut self, file: PathBuf, why: &'static str) {
        self.before.complete = false;
        self.before.damage.push(Damage::Next { file, why });
        self.next = None;
    }

    /// Goes on with the next file; whether there is one.
    fn advance(&mut self) -> Result<bool, RecordError> {
        let Some(next) = self.next.take() else {
            return Ok(false);
        };
        let files = [next.clone(), part_of(&next)];
        let existing = files.into_iter().find(|file| file.exists());
        let Some(file) = existing else {
            self.end(next, "is not there");
            return Ok(false);
        };
        if self.read.len() >= FILES_MOST || !self.read.insert(file.clone()) {
            self.end(file, "is one of its files already");
            return Ok(false);
        }
        self.before = self.condition();
        // All files of a log have the axes of the first.
        let (axes, topics) = (self.reader.axes, self.reader.topics.take());
        let (bytes_read, unpacked) = (self.reader.bytes_read, self.reader.unpacked);
        self.reader = LogReader::open(&file)?;
        self.reader.axes = axes;
        self.reader.topics = topics;
        // The bound on what is unpacked is one for all files together.
        self.reader.bytes_read += bytes_read;
        self.reader.unpacked = unpacked;
        self.belongs = self.run.is_none();
        self.path = file;
        Ok(true)
    }

    /// The next entry as the files have it.
    fn next_read(&mut self) -> Option<Result<Entry, RecordError>> {
        loop {
            let entry = self.reader.next();
            if let Some(Ok(Entry::Metadata(record))) = &entry
                && record.name == "experiment"
            {
                let run = record.values.get(RUN);
                self.belongs |= run == self.run.as_ref();
                self.run = self.run.take().or_else(|| run.cloned());
            }
            match entry {
                Some(Ok(_)) if !self.belongs => {
                    let file = self.path.clone();
                    self.reader.stop();
                    self.end(file, "is of another run");
                }
                Some(Ok(Entry::Metadata(record))) if record.name == NEXT => {
                    let name = record.values.get("file").map(Path::new);
                    // A name and no path: a log leads nowhere else.
                    match name.and_then(Path::file_name) {
                        Some(name) => self.next = Some(self.path.with_file_name(name)),
                        None => {
                            let file = name.unwrap_or(Path::new("")).to_owned();
                            self.end(file, "is no name of a file");
                        }
                    }
                }
                // The first file has said it.
                Some(Ok(Entry::Metadata(record)))
                    if self.read.len() > 1
                        && ["experiment", CLOCK, CONTINUES].contains(&record.name.as_str()) => {}
                Some(entry) => return Some(entry),
                None => match self.advance() {
                    Ok(true) => {}
                    Ok(false) => return None,
                    Err(error) => return Some(Err(error)),
                },
            }
        }
    }
}

impl Iterator for LogFiles {
    type Item = Result<Entry, RecordError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(entry) = self.ready.pop_front() {
                return Some(Ok(entry));
            }
            match self.next_read() {
                Some(Ok(entry)) => {
                    let order = match entry {
                        Entry::Drive(_) => &mut self.driven,
                        Entry::Tick(_) | Entry::Event(_) | Entry::Metadata(_) => &mut self.ticks,
                    };
                    order.take(entry, &mut self.ready);
                }
                Some(Err(error)) => return Some(Err(error)),
                None => {
                    self.ticks.give(0, &mut self.ready);
                    self.driven.give(0, &mut self.ready);
                    return self.ready.pop_front().map(Ok);
                }
            }
        }
    }
}
