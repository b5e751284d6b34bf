//! Reads a log in file order, whole or not. One reader walks the records and yields each chunk, another unpacks a
//! chunk whose checksum is right: so a damaged chunk costs its own 100 ms. A wrong length or the end of a cut file
//! ends the reading; what came before is kept. Memory is one chunk; no length is believed before its bytes are there.

use std::{
    borrow::Cow,
    collections::{BTreeMap, VecDeque},
    fmt,
    fs::File,
    io::{BufReader, Chain, Cursor, Read},
    path::{Path, PathBuf},
};

use mcap::{
    McapError,
    records::{Record, op},
    sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions},
};
use ruzstd::decoding::FrameDecoder;

use super::{
    RecordError, StartTime,
    new_file::open_file,
    topics::Topics,
    writer::{DRIVE_CHANNEL, DRIVE_TOPIC, EVENT_CHANNEL, LIBRARY_NAME, TICK_CHANNEL, nanoseconds},
};
use haptic_message::{
    EventMessage, Layout, LogMessage, MessageError, MetadataRecord, TickMessage, TickSlot,
};

/// No record of a log is longer; a longer one is damage.
const RECORD_LIMIT: usize = 1 << 25;
/// Bytes that may be unpacked of any log; of a longer one it may be this many times what was read. More is a file made to waste time.
const UNPACKED_MOST: u64 = 1 << 30;
const UNPACKED_TIMES: u64 = 64;
const NO_KIND: &str = "there is a record of no kind";
/// Most bytes that are asked of the file at a time, so a wrong length cannot ask for more.
const READ_BYTES: usize = 1 << 16;

/// One thing in a log.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Entry {
    /// One sample of the loop.
    Tick(TickMessage),
    /// One sample of the drive, a second device that moves the first: the time is by the clock of the first.
    Drive(TickMessage),
    /// Something worth a sentence, between two ticks.
    Event(EventMessage),
    /// Facts about the run beside its samples.
    Metadata(MetadataRecord),
}

/// A part of a log that could not be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Damage {
    /// The file ends in the middle, as after a crash or with `.part` files.
    #[error("the file ends unfinished after {at_byte} bytes")]
    Cut {
        /// The length of the file.
        at_byte: u64,
    },
    /// One chunk, up to 100 ms of samples, is damaged; reading went on behind it.
    #[error("a chunk of samples near byte {at_byte} is damaged: {cause}")]
    Chunk {
        /// End of the chunk, bytes from the start of the file; near enough to look at.
        at_byte: u64,
        /// Found in place of a record, in words.
        cause: String,
    },
    /// One record is damaged; reading went on behind it.
    #[error("a record near byte {at_byte} is damaged: {cause}")]
    Record {
        /// End of the record, bytes from the start of the file.
        at_byte: u64,
        /// Found in place of a record, in words.
        cause: String,
    },
    /// The records no longer follow each other; nothing behind this place could be read.
    #[error("nothing after about byte {at_byte} can be read: {cause}")]
    Structure {
        /// Bytes read up to here.
        at_byte: u64,
        /// Found in place of a record, in words.
        cause: String,
    },
    /// The next file of the log is missing, or belongs to another.
    #[error("the log goes on in `{}`, which {why}; files after it are read by their own names", .file.display())]
    Next {
        /// The file that the one before it names.
        file: PathBuf,
        /// Why it is not read.
        why: &'static str,
    },
    /// Everything could be read, but the checksum of the whole says that some byte has changed.
    #[error("some byte has changed: {cause}")]
    Checksum {
        /// The sum that the file says and the one that it has.
        cause: String,
    },
}

/// Condition of a log that has been read to its end.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Condition {
    /// The log was finished by its writer and no part of it is damaged.
    pub complete: bool,
    /// Damage: parts that could not be read.
    pub damage: Vec<Damage>,
    /// Topics that are not ours, and the number of their messages; they are skipped. Attachments count as [`ATTACHMENTS`].
    pub foreign_topics: BTreeMap<String, u64>,
    /// Ticks that stood behind later ones and were put in their place.
    pub sorted: u64,
    /// Ticks that were not, because they come twice or too late.
    pub out_of_order: u64,
}

/// Name of the attachments of a log among its topics.
pub const ATTACHMENTS: &str = "(attachments)";

/// Iterates over the [entries](Entry) of a log; afterwards [`condition`](Self::condition) says what
/// is missing. An `Err` comes from the disk, never from damage, and is the last item.
///
/// ```
/// # use haptic_log::record::LogWriter;
/// # use haptic_message::TickMessage;
/// use haptic_log::record::{Entry, LogReader};
///
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("run.mcap");
/// # let mut log = LogWriter::create(&path)?;
/// # log.tick(&TickMessage { commanded_force_n: (-2.0).into(), ..TickMessage::at_rest(1) })?;
/// # log.finish()?;
/// let mut log = LogReader::open(&path)?;
/// let mut largest_n = 0.0_f64;
/// for entry in log.by_ref() {
///     if let Entry::Tick(tick) = entry? {
///         largest_n = largest_n.max(tick.commanded_force_n[0].abs());
///     }
/// }
/// assert_eq!(largest_n, 2.0);
/// assert!(log.condition().complete, "{:?}", log.condition().damage);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct LogReader<R> {
    /// The first bytes, which were looked at already, and the rest.
    source: Chain<Cursor<Vec<u8>>, R>,
    path: PathBuf,
    walk: LinearReader,
    pub(super) bytes_read: u64,
    /// Bytes that its chunks said to unpack to.
    pub(super) unpacked: u64,
    /// Messages by the number of their channel, of a log whose chunks are not unpacked.
    pub(super) skim: Option<BTreeMap<u16, Indexed>>,
    /// Definitions of messages by the number of their schema.
    schemas: BTreeMap<u16, String>,
    /// Messages by the number of their channel; the topic of foreign ones.
    channels: BTreeMap<u16, Result<Kind, String>>,
    /// Takes every message, ours and those of others, where these are asked for.
    pub(super) topics: Option<Topics>,
    /// Entries to give out next; messages with log time and device time, ns.
    ready: VecDeque<(Option<(u64, u64)>, Entry)>,
    condition: Condition,
    /// Number of axes of all ticks, as of the first.
    pub(super) axes: Option<usize>,
    /// Log time and device time of the newest message given out, ns.
    newest: Option<(u64, u64)>,
    footer_seen: bool,
    done: bool,
}

/// The messages of our topics.
#[derive(Clone, Debug)]
enum Kind {
    /// Ticks in one of these layouts.
    Tick(fn(TickMessage) -> Entry, Vec<Layout<TickSlot>>),
    Event(Layout<usize>),
}

impl Kind {
    /// Messages of this schema on a topic, or of a schema that is lost: then of today's; `None` for a foreign one.
    fn of(topic: &str, schema: Option<&str>) -> Option<Self> {
        match topic {
            TickMessage::TOPIC | DRIVE_TOPIC => {
                let today = [1, 2, 3].map(|axes| TickMessage::at_rest(axes).schema().1);
                let schemas = schema.map_or(today.to_vec(), |schema| vec![schema.to_owned()]);
                let layouts = schemas
                    .iter()
                    .map(|schema| Layout::of(schema, TickMessage::slot));
                let entry = match topic {
                    DRIVE_TOPIC => Entry::Drive,
                    _ => Entry::Tick,
                };
                Some(Self::Tick(entry, layouts.collect()))
            }
            EventMessage::TOPIC => {
                let today = EventMessage::default().schema().1;
                let schema = schema.unwrap_or(&today);
                Some(Self::Event(Layout::of(schema, EventMessage::slot)))
            }
            _ => None,
        }
    }

    fn decode(&self, bytes: &[u8]) -> Result<Entry, MessageError> {
        match self {
            Self::Tick(entry, layouts) => {
                let ticks = layouts
                    .iter()
                    .map(|layout| TickMessage::decode(layout, bytes));
                let ticks = ticks
                    .reduce(Result::or)
                    .unwrap_or(Err(MessageError::Fields));
                ticks.map(entry)
            }
            Self::Event(layout) => EventMessage::decode(layout, bytes).map(Entry::Event),
        }
    }
}

enum Step {
    Need(usize),
    /// A record was taken in.
    Taken,
    /// The end, or the end of what can be read.
    End,
}

impl LogReader<BufReader<File>> {
    /// Opens a log.
    ///
    /// # Errors
    /// If it is not a regular file, cannot be read or is not MCAP.
    pub fn open(path: &Path) -> Result<Self, RecordError> {
        let file = open_file(path).map_err(|source| RecordError::read(path, source))?;
        Self::new(BufReader::with_capacity(READ_BYTES, file), path)
    }
}

impl<R: Read> LogReader<R> {
    /// Reads a log from any source; `path` is its name in messages.
    ///
    /// # Errors
    /// If the source fails or is not MCAP. A file cut within its first 8 bytes is a log with
    /// nothing in it, and so is an empty `.part` file; another empty file is not a log.
    pub fn new(mut source: R, path: &Path) -> Result<Self, RecordError> {
        let mut start = Vec::new();
        (source.by_ref().take(mcap::MAGIC.len() as u64))
            .read_to_end(&mut start)
            .map_err(|source| RecordError::read(path, source))?;
        // A process can die between making its log and writing the first byte.
        let unbegun = start.is_empty() && path.extension().is_some_and(|end| end == "part");
        if (start.is_empty() && !unbegun) || !mcap::MAGIC.starts_with(&start) {
            return Err(RecordError::NotMcap {
                path: path.to_owned(),
                found: describe_start(&start),
            });
        }
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_record_length_limit(RECORD_LIMIT);
        Ok(Self {
            source: Cursor::new(start).chain(source),
            path: path.to_owned(),
            walk: LinearReader::new_with_options(options),
            bytes_read: 0,
            unpacked: 0,
            skim: None,
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            topics: None,
            ready: VecDeque::new(),
            condition: Condition::default(),
            axes: None,
            newest: None,
            footer_seen: false,
            done: false,
        })
    }

    /// Condition of the log; valid once the iteration has ended.
    pub fn condition(&self) -> &Condition {
        &self.condition
    }

    /// When the run of the newest message began; `None` before the first, and in a log without dates.
    pub fn started(&self) -> Option<StartTime> {
        let (log_time_ns, device_time_ns) = self.newest?;
        StartTime::of_log(log_time_ns, device_time_ns)
    }

    /// The ticks by their index.
    pub(super) fn skimmed(&self) -> Option<Indexed> {
        let mut channels = self.skim.iter().flatten();
        let ticks = channels.find(|(id, _)| match self.channels.get(id) {
            Some(Ok(Kind::Tick(entry, _))) => {
                matches!(entry(TickMessage::at_rest(1)), Entry::Tick(_))
            }
            Some(Ok(Kind::Event(_)) | Err(_)) | None => false,
        });
        ticks.map(|(_, indexed)| *indexed)
    }

    pub(super) fn stop(&mut self) {
        self.ready.clear();
        self.done = true;
    }

    fn step(&mut self) -> Step {
        let at_byte = self.bytes_read;
        let (opcode, data) = match self.walk.next_event() {
            None => {
                self.condition.complete = self.footer_seen && self.condition.damage.is_empty();
                return Step::End;
            }
            Some(Ok(LinearReadEvent::ReadRequest(need))) => return Step::Need(need),
            Some(Ok(LinearReadEvent::Record { data, opcode })) => (opcode, data.to_vec()),
            Some(Err(error)) => {
                let cause = error.to_string();
                let changed = matches!(
                    error,
                    McapError::BadDataCrc { .. } | McapError::BadSummaryCrc { .. }
                );
                self.condition.damage.push(if changed {
                    Damage::Checksum { cause }
                } else if matches!(error, McapError::UnexpectedEof) {
                    Damage::Cut { at_byte }
                } else {
                    Damage::Structure { at_byte, cause }
                });
                return Step::End;
            }
        };
        match (opcode, &mut self.skim) {
            (op::CHUNK, Some(_)) => return Step::Taken,
            (op::MESSAGE_INDEX, Some(channels)) => count(channels, &data),
            _ => {}
        }
        match opcode {
            // No record has it; zeros would read as empty records for ever.
            0 => {
                let cause = NO_KIND.to_owned();
                let damage = Damage::Structure { at_byte, cause };
                self.condition.damage.push(damage);
                return Step::End;
            }
            op::ATTACHMENT => {
                let topics = &mut self.condition.foreign_topics;
                *topics.entry(ATTACHMENTS.to_owned()).or_default() += 1;
            }
            op::CHUNK => {
                self.unpacked += size_of(&data)
                    .filter(|size| *size <= RECORD_LIMIT as u64)
                    .unwrap_or(0);
                if self.unpacked > UNPACKED_MOST.max(UNPACKED_TIMES * self.bytes_read) {
                    let cause = format!(
                        "its chunks unpack to {} bytes and more, {UNPACKED_TIMES} times what was read",
                        self.unpacked
                    );
                    self.condition
                        .damage
                        .push(Damage::Structure { at_byte, cause });
                    return Step::End;
                }
                if let Err(cause) = self.chunk(&data) {
                    self.condition.damage.push(Damage::Chunk { at_byte, cause });
                }
            }
            op::FOOTER => self.footer_seen = true,
            _ => {
                if let Err(cause) = self.record(opcode, &data) {
                    self.condition
                        .damage
                        .push(Damage::Record { at_byte, cause });
                }
            }
        }
        Step::Taken
    }

    /// Unpacks one chunk, all of it or nothing, into `ready`.
    fn chunk(&mut self, data: &[u8]) -> Result<(), String> {
        // A chunk on its own is a file without magic: the same reader unpacks it, and checks its sum first.
        let data = parsable(data)?;
        let bytes = [&[op::CHUNK][..], &(data.len() as u64).to_le_bytes(), &data].concat();
        let mut rest = bytes.as_slice();
        let mut unpack = LinearReader::new_with_options(
            LinearReaderOptions::default()
                .with_skip_start_magic(true)
                .with_skip_end_magic(true)
                .with_prevalidate_chunk_crcs(true)
                .with_record_length_limit(RECORD_LIMIT),
        );
        let before = self.ready.len();
        while let Some(event) = unpack.next_event() {
            let taken = match event {
                Ok(LinearReadEvent::ReadRequest(need)) => {
                    let space = unpack.insert(need.min(rest.len()));
                    space.copy_from_slice(&rest[..space.len()]);
                    let read = space.len();
                    rest = &rest[read..];
                    unpack.notify_read(read);
                    Ok(())
                }
                // Nothing else follows: zeros would be a million of them.
                Ok(LinearReadEvent::Record { opcode: 0, .. }) => Err(NO_KIND.to_owned()),
                Ok(LinearReadEvent::Record { data, opcode }) => self.record(opcode, data),
                Err(error) => Err(error.to_string()),
            };
            if let Err(cause) = taken {
                self.ready.truncate(before);
                return Err(cause);
            }
        }
        Ok(())
    }

    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "of the records of others, these are the ones that matter here"
    )]
    fn record(&mut self, opcode: u8, data: &[u8]) -> Result<(), String> {
        // Indexes and statistics repeat what the data say; only these matter.
        if !matches!(
            opcode,
            op::HEADER | op::SCHEMA | op::CHANNEL | op::MESSAGE | op::METADATA
        ) {
            return Ok(());
        }
        if !texts_fit(opcode, data) {
            return Err("a text in it is longer than the record".to_owned());
        }
        let record = mcap::parse_record(opcode, data).map_err(|error| error.to_string())?;
        if let Some(topics) = &mut self.topics {
            topics.take(&record);
        }
        match record {
            Record::Header(header) if header.library.starts_with(LIBRARY_NAME) => {
                // Our own channels are known even if the chunk that declares them is lost.
                for (id, topic) in [
                    (TICK_CHANNEL, TickMessage::TOPIC),
                    (EVENT_CHANNEL, EventMessage::TOPIC),
                    (DRIVE_CHANNEL, DRIVE_TOPIC),
                ] {
                    let kind = Kind::of(topic, None).ok_or(topic.to_owned());
                    self.channels.insert(id, kind);
                }
            }
            Record::Schema { header, data } if header.encoding == "ros2msg" => {
                let text = String::from_utf8_lossy(&data).into_owned();
                self.schemas.insert(header.id, text);
            }
            Record::Channel(channel) => {
                let schema = self.schemas.get(&channel.schema_id);
                let is_cdr = channel.message_encoding == "cdr";
                let kind = Kind::of(&channel.topic, schema.map(String::as_str));
                let kind = kind.filter(|_| is_cdr).ok_or(channel.topic);
                self.channels.insert(channel.id, kind);
            }
            Record::Message { header, data } => {
                let kind = match self.channels.get(&header.channel_id) {
                    Some(Ok(kind)) => kind,
                    foreign => {
                        let unnamed = || format!("channel {}", header.channel_id);
                        let topic = foreign.and_then(|topic| topic.clone().err());
                        let topics = &mut self.condition.foreign_topics;
                        *topics.entry(topic.unwrap_or_else(unnamed)).or_default() += 1;
                        return Ok(());
                    }
                };
                let entry = kind.decode(&data).map_err(|error| error.to_string())?;
                if let Entry::Tick(tick) = &entry
                    && *self.axes.get_or_insert(tick.axes()) != tick.axes()
                {
                    return Err(MessageError::Axes.to_string());
                }
                let times = device_time_ns(&entry).map(|time| (header.log_time, time));
                self.ready.push_back((times, entry));
            }
            Record::Metadata(metadata) => {
                let record = MetadataRecord {
                    name: metadata.name,
                    values: metadata.metadata,
                };
                self.ready.push_back((None, Entry::Metadata(record)));
            }
            _ => {}
        }
        Ok(())
    }

    fn read(&mut self, need: usize) -> Result<(), RecordError> {
        loop {
            let space = self.walk.insert(need.clamp(1, READ_BYTES));
            match self.source.read(space) {
                Ok(read) => {
                    self.bytes_read += read as u64;
                    self.walk.notify_read(read);
                    return Ok(());
                }
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(source) => return Err(RecordError::read(&self.path, source)),
            }
        }
    }
}

impl<R: Read> Iterator for LogReader<R> {
    type Item = Result<Entry, RecordError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some((times, entry)) = self.ready.pop_front() {
                self.newest = times.or(self.newest);
                return Some(Ok(entry));
            }
            if self.done {
                return None;
            }
            match self.step() {
                Step::Taken => {}
                Step::End => self.done = true,
                Step::Need(need) => {
                    if let Err(error) = self.read(need) {
                        self.done = true;
                        return Some(Err(error));
                    }
                }
            }
        }
    }
}

impl<R> fmt::Debug for LogReader<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LogReader")
            .field("path", &self.path)
            .field("bytes_read", &self.bytes_read)
            .field("condition", &self.condition)
            .finish_non_exhaustive()
    }
}

/// Device time of a message, ns.
fn device_time_ns(entry: &Entry) -> Option<u64> {
    let time_s = match entry {
        Entry::Tick(message) | Entry::Drive(message) => message.time_s,
        Entry::Event(message) => message.time_s,
        Entry::Metadata(_) => return None,
    };
    nanoseconds(time_s).ok()
}

/// The first bytes of a file that is not MCAP, for a person.
fn describe_start(start: &[u8]) -> String {
    if start.is_empty() {
        "it is empty".to_owned()
    } else {
        format!("it starts with \"{}\"", start.escape_ascii())
    }
}

/// True if the texts and maps of a record end within its bytes: the parser trusts their lengths, and asks for up to 4
/// GiB.
fn texts_fit(opcode: u8, data: &[u8]) -> bool {
    // Bytes before the first text, the texts, and true if a map follows.
    let (numbers, texts, has_map) = match opcode {
        op::HEADER => (0, 2, false),
        op::CHANNEL => (4, 2, true),
        op::METADATA => (0, 1, true),
        op::SCHEMA => (2, 3, false),
        _ => return true,
    };
    let mut rest = Rest(data);
    let mut fits = rest.take(numbers).is_some();
    fits &= (0..texts).all(|_| rest.text().is_some());
    fits && (!has_map || rest.map().is_some())
}

/// A chunk as the parser knows it: one with zstd is unpacked, and what stands behind the records of others is left out,
/// which the parser takes for part of the last one.
fn parsable(chunk: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    let size = size_of(chunk).unwrap_or(0);
    if size > RECORD_LIMIT as u64 {
        return Err(format!("its {size} bytes are more than {RECORD_LIMIT}"));
    }
    let mut rest = Rest(chunk);
    // Times, size and sum first; then the compression, and the records behind their number of bytes.
    let parts =
        (rest.take(28)).and_then(|head| Some((head, rest.counted()?, rest.0.split_first_chunk()?)));
    let Some((head, compression, (length, behind))) = parts else {
        return Ok(chunk.into());
    };
    let length = u64::from_le_bytes(*length) as usize;
    let Some(records) = behind.get(..length) else {
        return Ok(chunk.into());
    };
    if compression != b"zstd" {
        return Ok(chunk[..chunk.len() - (behind.len() - length)].into());
    }
    let mut plain = [head, &[0; 4], &size.to_le_bytes()].concat();
    let start = plain.len();
    plain.resize(start + size as usize, 0);
    let unpacked = FrameDecoder::new().decode_all(records, &mut plain[start..]);
    unpacked.map_err(|error| format!("zstd: {error}"))?;
    Ok(plain.into())
}

/// Bytes that a chunk says to unpack to.
fn size_of(chunk: &[u8]) -> Option<u64> {
    Some(u64::from_le_bytes(*chunk.get(16..)?.first_chunk()?))
}

/// The messages of a channel by the index behind each chunk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Indexed {
    pub count: u64,
    /// Log times of the first and the last, ns.
    pub first_ns: u64,
    pub last_ns: u64,
}

/// Counts the messages of an index.
fn count(channels: &mut BTreeMap<u16, Indexed>, index: &[u8]) {
    let Some((channel, entries)) = index.split_first_chunk() else {
        return;
    };
    let entries = Rest(entries).counted().unwrap_or_default();
    let none = Indexed {
        count: 0,
        first_ns: u64::MAX,
        last_ns: 0,
    };
    let all = channels.entry(u16::from_le_bytes(*channel)).or_insert(none);
    for time in entries.as_chunks::<16>().0 {
        let time = u64::from_le_bytes(*time.first_chunk().unwrap_or(&[0; 8]));
        all.count += 1;
        all.first_ns = all.first_ns.min(time);
        all.last_ns = all.last_ns.max(time);
    }
}

struct Rest<'a>(&'a [u8]);

impl<'a> Rest<'a> {
    fn take(&mut self, length: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(taken)
    }

    fn counted(&mut self) -> Option<&'a [u8]> {
        let (length, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        self.take(u32::from_le_bytes(*length) as usize)
    }

    fn text(&mut self) -> Option<()> {
        self.counted().map(|_| ())
    }

    fn map(&mut self) -> Option<()> {
        let mut pairs = Rest(self.counted()?);
        while !pairs.0.is_empty() {
            pairs.text()?;
            pairs.text()?;
        }
        Some(())
    }
}
