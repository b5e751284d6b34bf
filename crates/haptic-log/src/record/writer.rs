//! Writes a log as the run goes.
//!
//! A chunk is collected in memory and written in one piece, so the file always ends behind a whole
//! chunk unless the disk fills up in the middle of one. Memory is one chunk plus, for each chunk,
//! an entry of the index that [`finish`](LogWriter::finish) writes: 10 MB per hour of device time at first. Beyond 65 536
//! chunks (1.8 h) their time doubles with every 32 768, so that a log twice as long takes 10 MB more.

use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, BufWriter, Seek, SeekFrom, Write},
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering},
    },
    time::Duration,
};

use mcap::{
    Compression, McapResult, WriteOptions,
    records::{MessageHeader, Metadata},
};

use super::{
    CLOCK, Leftover, NewFile, NewFileError, RecordError, StartTime, error::io_error, sync::Syncer,
};
use haptic_message::{EventMessage, LogMessage, MessageError, TickMessage};

/// A chunk is closed and flushed when this much device time has begun anew, ns: at first.
const FLUSH_INTERVAL_NS: u64 = 100_000_000;
/// A chunk of this many bytes is closed early, whatever the time.
const CHUNK_BYTES: u64 = 1 << 20;
/// Number of chunks after which the time of a chunk doubles, the first time at 1.8 hours.
const DOUBLED_AFTER: u64 = 1 << 15;

/// Name of the writer. Readers of this crate trust the channel numbers below if a log has this name.
const LIBRARY: &str = concat!("host-cli haptic-log ", env!("CARGO_PKG_VERSION"));
/// Start of [`LIBRARY`], the same in every version.
pub(super) const LIBRARY_NAME: &str = "host-cli ";
/// MCAP channel of the ticks.
pub(super) const TICK_CHANNEL: u16 = 1;
/// MCAP channel of the events.
pub(super) const EVENT_CHANNEL: u16 = 2;
/// MCAP channel of the ticks of a drive.
pub(super) const DRIVE_CHANNEL: u16 = 3;
/// Topic of the ticks of a drive: a second device, which moves the first.
pub(super) const DRIVE_TOPIC: &str = "/haptics/drive";

/// Files that [`LogWriter::finish`] leaves on the disk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FinishedLog {
    /// The file, the first if there are more.
    pub path: PathBuf,
    /// All files, in order; more than one only if the log was split.
    pub paths: Vec<PathBuf>,
    /// Ticks that the file has.
    pub samples: u64,
    /// Bytes on the disk, of all files together.
    pub bytes: u64,
}

/// A log being written. Made by [`create`](LogWriter::create); call
/// [`finish`](LogWriter::finish) at the end.
///
/// Dropped without `finish`, or after an error, it leaves a `.part` file without a footer: it
/// contains what was flushed, and every reader can detect that it is incomplete.
///
/// ```
/// use haptic_log::record::{LogWriter, StartTime};
/// use haptic_message::TickMessage;
/// use std::time::SystemTime;
///
/// let folder = tempfile::tempdir()?;
/// let mut log = LogWriter::create(&folder.path().join("run.mcap"))?;
/// log.metadata("experiment", [("stiffness_n_per_m".to_owned(), "1000".to_owned())].into())?;
/// log.starts_at(StartTime::at(SystemTime::now()))?;
/// for tick in 0..1000 {
///     let time_s = 1e-3 * tick as f64;
///     log.tick(&TickMessage { tick, time_s, position_m: 1e-3.into(), commanded_force_n: (-1.0).into(), ..TickMessage::at_rest(1) })?;
/// }
/// let finished = log.finish()?;
/// assert_eq!(finished.samples, 1000);
/// assert!(finished.path.ends_with("run.mcap"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct LogWriter<W: Write + Seek> {
    /// `None` only after `close`.
    mcap: Option<mcap::Writer<Sink<W>>>,
    /// Bytes that the sink took.
    bytes: Arc<AtomicU64>,
    chunks: u64,
    /// Name of the unfinished file, for messages.
    path: PathBuf,
    /// The file to publish; `None` when the sink is not ours.
    new_file: Option<NewFile>,
    /// Syncer of a log that is brought to the disk as it grows.
    syncer: Option<Syncer>,
    buffer: Vec<u8>,
    /// Index of the 100 ms interval of the open chunk.
    interval: Option<u64>,
    /// Log time of device time 0, ns.
    start_ns: u64,
    samples: u64,
    samples_safe: u64,
    driven: u64,
    events: u32,
    /// Number of axes of the ticks, as their channel was announced with the first.
    axes: Option<usize>,
    failed: bool,
}

impl<W: Write + Seek> LogWriter<W> {
    /// Starts a log in any sink; `path` is its name in messages. Nothing is renamed at the end.
    ///
    /// # Errors
    /// If the sink does not accept the header.
    pub fn with_sink(sink: W, path: &Path) -> Result<Self, RecordError> {
        let bytes = Arc::default();
        let sink = Sink {
            inner: sink,
            bytes: Arc::clone(&bytes),
        };
        let started = options().create(sink).and_then(|mut mcap| {
            let event = EventMessage::default();
            add_channel(&mut mcap, EVENT_CHANNEL, EventMessage::TOPIC, &event)?;
            mcap.flush()?;
            Ok(mcap)
        });
        let started = started.map_err(|error| RecordError::Write {
            path: path.to_owned(),
            samples_safe: 0,
            source: io_error(error),
        })?;
        Ok(Self {
            mcap: Some(started),
            bytes,
            chunks: 0,
            path: path.to_owned(),
            new_file: None,
            syncer: None,
            buffer: Vec::new(),
            interval: None,
            start_ns: 0,
            samples: 0,
            samples_safe: 0,
            driven: 0,
            events: 0,
            axes: None,
            failed: false,
        })
    }

    /// Adds a metadata record: what is needed to repeat the run, statistics at its end.
    ///
    /// # Errors
    /// If the sink fails; the writer takes nothing more after that.
    pub fn metadata(
        &mut self,
        name: &str,
        values: BTreeMap<String, String>,
    ) -> Result<(), RecordError> {
        let record = Metadata {
            name: name.to_owned(),
            metadata: values,
        };
        self.attempt(|mcap| mcap.write_metadata(&record))?;
        self.flush()
    }

    /// Dates what follows: log times become `start` plus device time, and the start is added as metadata
    /// ([`CLOCK`]). To be called before the first tick; without it log times are device times.
    ///
    /// # Errors
    /// If the sink fails.
    pub fn starts_at(&mut self, start: StartTime) -> Result<(), RecordError> {
        self.dated(start);
        self.metadata(CLOCK, start.metadata())
    }

    /// Dates what follows as [`starts_at`](Self::starts_at) does, for a copy that already has the metadata.
    pub(super) const fn dated(&mut self, start: StartTime) {
        self.start_ns = start.since_1970_ns();
    }

    /// Adds a tick. All ticks of a log have the same number of axes.
    ///
    /// # Errors
    /// If the sink fails, the time is negative or not finite, or the number of axes has
    /// changed.
    pub fn tick(&mut self, message: &TickMessage) -> Result<(), RecordError> {
        let axes = message.axes();
        if *self.axes.get_or_insert(axes) != axes {
            return Err(MessageError::Axes.into());
        }
        if self.samples == 0 {
            let topic = TickMessage::TOPIC;
            self.attempt(|mcap| add_channel(mcap, TICK_CHANNEL, topic, message))?;
        }
        self.flush_before(message.time_s)?;
        // MCAP has 32 bits for the sequence number; it wraps, the field `tick` does not.
        self.message(TICK_CHANNEL, message.tick as u32, message)?;
        self.samples += 1;
        Ok(())
    }

    /// Adds a tick of the drive, a second device that moves the first; its time is by the clock of the first. It closes no chunk:
    /// the times of two devices come in no order.
    ///
    /// # Errors
    /// As [`tick`](Self::tick), but for the number of axes.
    pub fn drive_tick(&mut self, message: &TickMessage) -> Result<(), RecordError> {
        if self.driven == 0 {
            self.attempt(|mcap| add_channel(mcap, DRIVE_CHANNEL, DRIVE_TOPIC, message))?;
        }
        self.message(DRIVE_CHANNEL, message.tick as u32, message)?;
        self.driven += 1;
        Ok(())
    }

    /// Adds an event.
    ///
    /// # Errors
    /// If the sink fails, or the time is negative or not finite.
    pub fn event(&mut self, message: &EventMessage) -> Result<(), RecordError> {
        self.flush_before(message.time_s)?;
        self.message(EVENT_CHANNEL, self.events, message)?;
        self.events = self.events.wrapping_add(1);
        Ok(())
    }

    /// Ticks that were given to it, safe on the disk or not.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Ticks that survive if the process dies now.
    pub fn samples_safe(&self) -> u64 {
        self.samples_safe
    }

    /// Bytes handed to the sink so far.
    pub fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }

    /// Writes the index and gives the sink back.
    ///
    /// # Errors
    /// If the sink fails.
    pub fn close(mut self) -> Result<W, RecordError> {
        self.flush()?;
        self.attempt(|mcap| mcap.finish().map(drop))?;
        let mcap = self.mcap.take().ok_or_else(|| self.closed())?;
        Ok(mcap.into_inner().inner)
    }

    /// Closes the chunk if this device time belongs to the next.
    fn flush_before(&mut self, time_s: f64) -> Result<(), RecordError> {
        let time_ns = nanoseconds(time_s)?;
        let doublings = (self.chunks / DOUBLED_AFTER).saturating_sub(1);
        let interval = time_ns / (FLUSH_INTERVAL_NS << doublings.min(32));
        if self.interval.is_some_and(|open| open != interval) {
            self.flush()?;
        }
        self.interval = Some(interval);
        Ok(())
    }

    fn message<M: LogMessage>(
        &mut self,
        channel_id: u16,
        sequence: u32,
        message: &M,
    ) -> Result<(), RecordError> {
        let time_ns = nanoseconds(message.time_s())?;
        let log_time = self.start_ns.saturating_add(time_ns);
        let mut buffer = std::mem::take(&mut self.buffer);
        message.encode_into(&mut buffer)?;
        let header = MessageHeader {
            channel_id,
            sequence,
            log_time,
            publish_time: log_time,
        };
        let written = self.attempt(|mcap| mcap.write_to_known_channel(&header, &buffer));
        self.buffer = buffer;
        written
    }

    /// Closes the chunk and hands it to the operating system.
    fn flush(&mut self) -> Result<(), RecordError> {
        self.attempt(mcap::Writer::flush)?;
        self.samples_safe = self.samples;
        self.chunks += 1;
        Ok(())
    }

    /// Runs one operation of the MCAP library; after a failure no further one is tried.
    fn attempt(
        &mut self,
        operation: impl FnOnce(&mut mcap::Writer<Sink<W>>) -> mcap::McapResult<()>,
    ) -> Result<(), RecordError> {
        let result = match &mut self.mcap {
            Some(mcap) if !self.failed => operation(mcap).map_err(io_error),
            _ => return Err(self.closed()),
        };
        result.map_err(|source| {
            self.failed = true;
            self.error(source)
        })
    }

    fn error(&self, source: io::Error) -> RecordError {
        RecordError::Write {
            path: self.path.clone(),
            samples_safe: self.samples_safe,
            source,
        }
    }

    fn closed(&self) -> RecordError {
        self.error(io::Error::other("an earlier write failed"))
    }
}

impl LogWriter<BufWriter<File>> {
    /// Starts the log `path`, under the name `path.part` until it is finished.
    ///
    /// # Errors
    /// If `path` or `path.part` exists, or the folder does not take the file.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        Self::create_with(path, Leftover::Keep, false, None)
    }

    /// Starts a log as [`create`](Self::create) does, with a choice of what happens to an unfinished file, and
    /// whether the finished one may replace another; it is synced to disk at an interval, if one is
    /// given.
    ///
    /// # Errors
    /// As there.
    pub fn create_with(
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

    /// Writes the index, syncs the file to disk and gives it its final name.
    ///
    /// # Errors
    /// If the disk is full, or the name was taken in the meantime; the `.part` file stays.
    /// Also if that was removed or cut meanwhile.
    pub fn finish(mut self) -> Result<FinishedLog, RecordError> {
        let new_file = self.new_file.take();
        let syncer = self.syncer.take();
        let (path, samples) = (self.path.clone(), self.samples);
        let fail = |source| RecordError::Write {
            path: path.clone(),
            samples_safe: samples,
            source,
        };
        let written = Arc::clone(&self.bytes);
        let sink = self.close()?;
        let file = sink
            .into_inner()
            .map_err(|error| fail(error.into_error()))?;
        file.sync_data().map_err(fail)?;
        syncer.map_or(Ok(0), Syncer::stop).map_err(fail)?;
        let bytes = file.metadata().map_err(fail)?.len();
        let path = match new_file {
            Some(new_file) => {
                // Seen here and not earlier, as nobody else writes to it: what was appended after that is in it, or in no folder.
                let what = if !new_file.part().exists() {
                    Some("removed")
                } else {
                    (bytes < written.load(Ordering::Relaxed)).then_some("emptied or cut")
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
        })
    }
}

impl<W: Write + Seek> Drop for LogWriter<W> {
    fn drop(&mut self) {
        // Keep what is in memory, but write no footer: the library's own drop would, and the
        // file would then pass for a finished one.
        if !self.failed && self.mcap.is_some() {
            let _ = self.flush();
        }
        if let Some(mcap) = self.mcap.take() {
            drop(mcap.into_inner());
        }
    }
}

impl<W: Write + Seek> std::fmt::Debug for LogWriter<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LogWriter")
            .field("path", &self.path)
            .field("samples", &self.samples)
            .field("samples_safe", &self.samples_safe)
            .finish_non_exhaustive()
    }
}

/// A log whose first bytes the disk did not take is a file that could not be created.
fn unbegun(path: &Path, error: RecordError) -> RecordError {
    let RecordError::Write { source, .. } = error else {
        return error;
    };
    NewFileError::io(path, source).into()
}

/// Options of the MCAP writer.
fn options() -> WriteOptions {
    WriteOptions::new()
        .profile("ros2")
        .library(LIBRARY)
        .compression(Some(Compression::Lz4))
        .chunk_size(Some(CHUNK_BYTES))
        // Chunks are buffered and written whole, rather than patched afterwards.
        .disable_seeking(true)
}

fn add_channel<M: LogMessage, W: Write + Seek>(
    mcap: &mut mcap::Writer<W>,
    id: u16,
    topic: &str,
    message: &M,
) -> McapResult<()> {
    let (name, text) = message.schema();
    let schema = mcap.add_schema(&name, "ros2msg", text.as_bytes())?;
    mcap.add_channel_with_id(id, schema, topic, "cdr", &BTreeMap::new())?;
    Ok(())
}

/// Device time in ns, rounded to the nearest.
pub(super) fn nanoseconds(time_s: f64) -> Result<u64, RecordError> {
    if !(0.0..=1.8e10).contains(&time_s) {
        return Err(RecordError::Time { time_s });
    }
    Ok((time_s * 1e9).round() as u64)
}

/// A sink that counts what it takes.
struct Sink<W> {
    inner: W,
    bytes: Arc<AtomicU64>,
}

impl<W: Write> Write for Sink<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = self.inner.write(bytes)?;
        self.bytes.fetch_add(taken as u64, Ordering::Relaxed);
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<W: Seek> Seek for Sink<W> {
    fn seek(&mut self, place: SeekFrom) -> io::Result<u64> {
        self.inner.seek(place)
    }
}
