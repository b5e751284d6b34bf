//! Writes a log as the run goes.
//!
//! A chunk is collected in memory and written in one piece, so the file always ends behind a whole
//! chunk unless the disk fills up in the middle of one. Memory is one chunk plus, for each 100 ms,
//! an entry of the index that [`finish`](LogWriter::finish) writes: 10 MB per hour of device time. A log of
//! more than 65 536 chunks (1.8 h) gets no index and no summary, so that memory does not grow with it: readers
//! read it from front to back. The chunks keep their checksums; the sum over the whole file is left out.

mod in_file;

use std::collections::BTreeMap;
use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};

use mcap::records::{MessageHeader, Metadata};

use super::error::io_error;
use super::format::{
    EVENT_CHANNEL, TICK_CHANNEL, VECTOR_CHANNEL, add_channels, add_vectors, nanoseconds, options,
    start,
};
use super::message::LogMessage;
use super::sink::{Control, Sink};
use super::sync::Syncer;
use super::{
    AnyTick, CLOCK, EventMessage, NewFile, RecordError, StartTime, TickMessage, VectorTick,
};
pub use in_file::FinishedLog;

/// A chunk is closed and flushed when this much device time has begun anew, ns.
pub const FLUSH_INTERVAL_NS: u64 = 100_000_000;

/// Chunks of a file that has an index: 1.8 hours.
pub(super) const INDEXED_CHUNKS: u32 = 1 << 16;

/// A log being written. Made by [`create`](LogWriter::create); call
/// [`finish`](LogWriter::finish) at the end.
///
/// Dropped without `finish`, or after an error, it leaves a `.part` file without a footer: what
/// was flushed is in it, and every reader can tell that it is not whole.
///
/// ```
/// use haptic_log::record::{LogWriter, StartTime, TickMessage};
/// use std::time::SystemTime;
///
/// let folder = tempfile::tempdir()?;
/// let mut log = LogWriter::create(&folder.path().join("run.mcap"))?;
/// log.metadata("experiment", [("stiffness_n_per_m".to_owned(), "1000".to_owned())].into())?;
/// log.starts_at(StartTime::at(SystemTime::now()))?;
/// for tick in 0..1000 {
///     let time_s = 1e-3 * tick as f64;
///     log.tick(&TickMessage { tick, time_s, position_m: 1e-3, commanded_force_n: -1.0, ..TickMessage::default() })?;
/// }
/// let finished = log.finish()?;
/// assert_eq!(finished.samples, 1000);
/// assert!(finished.path.ends_with("run.mcap"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct LogWriter<W: Write + Seek> {
    /// `None` only after `close`.
    mcap: Option<mcap::Writer<Sink<W>>>,
    control: Control,
    /// Chunks since the library was started on the file.
    chunks: u32,
    /// Name of the unfinished file, for messages.
    path: PathBuf,
    /// The file to publish; `None` when the sink is not ours.
    new_file: Option<NewFile>,
    /// Of a log that is brought to the disk as it grows.
    syncer: Option<Syncer>,
    buffer: Vec<u8>,
    /// Index of the 100 ms interval of the open chunk.
    interval: Option<u64>,
    /// Log time of device time 0, ns.
    start_ns: u64,
    samples: u64,
    samples_safe: u64,
    events: u32,
    /// Ticks with vectors have been announced.
    vectors: bool,
    failed: bool,
}

impl<W: Write + Seek> LogWriter<W> {
    /// Starts a log in any sink; `path` is its name in messages. Nothing is renamed at the end.
    ///
    /// # Errors
    /// If the sink does not take the header.
    pub fn with_sink(sink: W, path: &Path) -> Result<Self, RecordError> {
        let control = Control::default();
        let sink = Sink::new(sink, control.clone());
        let started = start(sink).map_err(|error| RecordError::Write {
            path: path.to_owned(),
            samples_safe: 0,
            source: io_error(error),
        })?;
        Ok(Self {
            mcap: Some(started),
            control,
            chunks: 0,
            path: path.to_owned(),
            new_file: None,
            syncer: None,
            buffer: Vec::new(),
            interval: None,
            start_ns: 0,
            samples: 0,
            samples_safe: 0,
            events: 0,
            vectors: false,
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

    /// The same without metadata, for a copy that has them already.
    pub(super) const fn dated(&mut self, start: StartTime) {
        self.start_ns = start.since_1970_ns();
    }

    /// Adds a tick.
    ///
    /// # Errors
    /// If the sink fails, or the time is negative or not finite.
    pub fn tick(&mut self, message: &TickMessage) -> Result<(), RecordError> {
        // MCAP has 32 bits for the sequence number; it wraps, the field `tick` does not.
        let sequence = message.tick as u32;
        self.message(TICK_CHANNEL, sequence, message.time_s, message)?;
        self.samples += 1;
        Ok(())
    }

    /// Adds a tick with vectors. A log has ticks of one version and number of axes.
    ///
    /// # Errors
    /// If the sink fails, or the time is negative or not finite.
    pub fn vector_tick(&mut self, message: &VectorTick) -> Result<(), RecordError> {
        if !self.vectors {
            self.attempt(add_vectors)?;
            self.vectors = true;
        }
        let sequence = message.tick as u32;
        self.message(VECTOR_CHANNEL, sequence, message.time_s, message)?;
        self.samples += 1;
        Ok(())
    }

    /// Adds a tick of either version.
    ///
    /// # Errors
    /// If the sink fails, or the time is negative or not finite.
    pub fn any_tick(&mut self, message: &AnyTick) -> Result<(), RecordError> {
        match message {
            AnyTick::One(message) => self.tick(message),
            AnyTick::Vector(message) => self.vector_tick(message),
        }
    }

    /// Adds an event.
    ///
    /// # Errors
    /// If the sink fails, or the time is negative or not finite.
    pub fn event(&mut self, message: &EventMessage) -> Result<(), RecordError> {
        self.message(EVENT_CHANNEL, self.events, message.time_s, message)?;
        self.events = self.events.wrapping_add(1);
        Ok(())
    }

    /// Ticks taken so far.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Ticks that survive if the process dies now.
    pub fn samples_safe(&self) -> u64 {
        self.samples_safe
    }

    /// Bytes handed to the sink so far.
    pub fn bytes(&self) -> u64 {
        self.control.bytes()
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

    fn message<M: LogMessage>(
        &mut self,
        channel_id: u16,
        sequence: u32,
        time_s: f64,
        message: &M,
    ) -> Result<(), RecordError> {
        let time_ns = nanoseconds(time_s)?;
        let interval = time_ns / FLUSH_INTERVAL_NS;
        if self.interval.is_some_and(|open| open != interval) {
            self.flush()?;
        }
        self.interval = Some(interval);
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
        if self.chunks >= INDEXED_CHUNKS {
            self.forget_index()?;
        }
        Ok(())
    }

    /// Goes on in the same file with the library started anew, which has no index in memory.
    fn forget_index(&mut self) -> Result<(), RecordError> {
        let Some(mcap) = self.mcap.take() else {
            return Err(self.closed());
        };
        let sink = mcap.into_inner();
        // The file has its start already.
        self.control.set_deaf(true);
        let continued = options(false).create(sink);
        self.control.set_deaf(false);
        let added = continued.and_then(|mut mcap| {
            add_channels(&mut mcap)?;
            if self.vectors {
                add_vectors(&mut mcap)?;
            }
            Ok(mcap)
        });
        self.mcap = Some(added.map_err(|error| self.error(io_error(error)))?);
        self.chunks = 0;
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
