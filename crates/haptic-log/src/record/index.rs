//! The index of a log that is too long to keep one in memory while it is written: made once the log is closed, from the
//! records in the file, so that memory does not grow with its length.
//!
//! ```text
//! … chunk, message indexes, metadata …, data end │ chunk indexes, schemas, channels, statistics, metadata indexes, offsets, footer
//!               as they were                     │                   written here, in one pass or two
//! ```
//! Of a chunk only the head is looked at, unless it has a channel that was not seen before.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, BufReader, BufWriter, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::Path;

use crc::{CRC_32_ISO_HDLC, Crc, Digest};
use mcap::records::op;

use super::new_file::{open_file, refuse_being_written};
use super::reader::unpack;
use super::{Leftover, NewFile, RecordError};

/// Bytes of a footer with the head of its record, and of the magic behind it.
const TAIL: u64 = 9 + 20 + 8;
/// A chunk tells its times, sizes and compression in so many bytes.
const CHUNK_HEAD: u64 = 64;
/// A record that is kept whole is not longer.
const WHOLE_MOST: u64 = 1 << 25;

static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Gives the finished log `path` an index if it has none, as logs above 1.8 hours had none in earlier versions. The file is
/// replaced by its copy with an index once that is whole. True if it had none.
///
/// # Errors
/// If the log cannot be read, is unfinished or damaged, or the copy cannot be written.
pub fn index(path: &Path) -> Result<bool, RecordError> {
    let read = |source| RecordError::read(path, source);
    refuse_being_written(path)?;
    let mut log = open_file(path).map_err(read)?;
    if has_index(&mut log).map_err(read)? {
        return Ok(false);
    }
    let (new_file, mut copy) = NewFile::create(path, Leftover::Discard, true)?;
    let written = io::copy(&mut log, &mut copy)
        .and_then(|_| append_index(new_file.part()))
        .and_then(|()| copy.sync_data());
    written.map_err(|source| match source.kind() {
        io::ErrorKind::InvalidData => read(source),
        _ => RecordError::Copy {
            path: path.to_owned(),
            source,
        },
    })?;
    new_file.publish()?;
    Ok(true)
}

/// True if the footer says where an index begins.
fn has_index(log: &mut File) -> io::Result<bool> {
    let mut footer = [0; TAIL as usize];
    let read = log
        .seek(SeekFrom::End(-(TAIL as i64)))
        .and_then(|_| log.read_exact(&mut footer));
    log.rewind()?;
    let is_footer =
        footer[..9] == [op::FOOTER, 20, 0, 0, 0, 0, 0, 0, 0] && footer[29..] == *mcap::MAGIC;
    match read.is_ok() && is_footer {
        true => Ok(footer[9..17] != [0; 8]),
        false => Err(damaged(log.metadata()?.len())),
    }
}

fn damaged(at_byte: u64) -> io::Error {
    let why = format!(
        "it is unfinished, or damaged near byte {at_byte}: `host-cli log recover` saves it with an index"
    );
    io::Error::new(io::ErrorKind::InvalidData, why)
}

/// Puts an index into a file that is finished without one.
pub(super) fn append_index(path: &Path) -> io::Result<()> {
    let mut log = BufReader::with_capacity(1 << 16, File::open(path)?);
    let file = OpenOptions::new().write(true).open(path)?;
    let end = file.metadata()?.len().saturating_sub(TAIL);
    file.set_len(end)?;
    let mut out = Summary::behind(file, end)?;
    let mut found = Found::default();
    let mut open: Option<ChunkIndex> = None;
    each_record(&mut log, end, |log, record, bytes| {
        if record.kind != op::MESSAGE_INDEX
            && let Some(chunk) = open.take()
        {
            found.chunks += 1;
            if chunk.offsets.is_empty() {
                found.declared_in(log, &chunk)?;
            }
            out.put(
                op::CHUNK_INDEX,
                &chunk.body(record.at).ok_or_else(|| damaged(record.at))?,
            )?;
        }
        match record.kind {
            op::CHUNK => {
                let head = bytes.to_vec();
                let offsets = Vec::new();
                open = Some(ChunkIndex {
                    record,
                    head,
                    offsets,
                });
            }
            op::MESSAGE_INDEX => {
                let channel = number(bytes, 0, 2)? as u16;
                let chunk = open.as_mut().ok_or_else(|| damaged(record.at))?;
                chunk.offsets.push((channel, record.at));
                // A time and a place for each message.
                *found.messages.entry(channel).or_default() += number(bytes, 2, 4)? / 16;
                found.span(number(&chunk.head, 0, 8)?, number(&chunk.head, 8, 8)?);
                if !found.channels.contains_key(&channel) {
                    found.declared_in(log, chunk)?;
                }
            }
            op::MESSAGE => {
                *found
                    .messages
                    .entry(number(bytes, 0, 2)? as u16)
                    .or_default() += 1;
                found.span(number(bytes, 6, 8)?, number(bytes, 6, 8)?);
            }
            op::SCHEMA | op::CHANNEL => found.declare(record.kind, bytes)?,
            op::METADATA => found.metadata += 1,
            op::ATTACHMENT => found.attachments += 1,
            _ => {}
        }
        Ok(())
    })?;
    for (kind, declared) in [(op::SCHEMA, &found.schemas), (op::CHANNEL, &found.channels)] {
        for body in declared.values() {
            out.put(kind, body)?;
        }
    }
    out.put(op::STATISTICS, &found.statistics())?;
    each_record(&mut log, end, |_, record, bytes| {
        if record.kind != op::METADATA {
            return Ok(());
        }
        let length = number(bytes, 0, 4)? as usize;
        let name = bytes.get(..4 + length).ok_or_else(|| damaged(record.at))?;
        let place = [record.at, record.length].map(u64::to_le_bytes).concat();
        out.put(op::METADATA_INDEX, &[&place, name].concat())
    })?;
    out.finish()
}

/// A record by its place and its length, head and all.
#[derive(Clone, Copy)]
struct Place {
    kind: u8,
    at: u64,
    length: u64,
}

/// Looks at the records before `end`: all bytes of those that are short, the first ones of others.
fn each_record(
    log: &mut BufReader<File>,
    end: u64,
    mut take: impl FnMut(&mut BufReader<File>, Place, &[u8]) -> io::Result<()>,
) -> io::Result<()> {
    let mut at = mcap::MAGIC.len() as u64;
    log.seek(SeekFrom::Start(at))?;
    while at < end {
        let mut head = [0; 9];
        log.read_exact(&mut head)?;
        let body = number(&head, 1, 8)?;
        let next = body.checked_add(at + 9).filter(|next| *next <= end);
        let next = next.ok_or_else(|| damaged(at))?;
        let kept = match head[0] {
            op::SCHEMA | op::CHANNEL | op::METADATA => body.min(WHOLE_MOST),
            _ => body.min(CHUNK_HEAD),
        };
        let mut bytes = vec![0; kept as usize];
        log.read_exact(&mut bytes)?;
        let place = Place {
            kind: head[0],
            at,
            length: next - at,
        };
        take(log, place, &bytes)?;
        let beyond = log.stream_position()?;
        log.seek_relative(next as i64 - beyond as i64)?;
        at = next;
    }
    Ok(())
}

/// The number of so many bytes at a place.
fn number(bytes: &[u8], at: usize, size: usize) -> io::Result<u64> {
    let found = bytes.get(at..at + size).ok_or_else(|| damaged(0))?;
    let mut whole = [0; 8];
    whole[..size].copy_from_slice(found);
    Ok(u64::from_le_bytes(whole))
}

/// A chunk whose message indexes are being read: of each a channel and its place.
struct ChunkIndex {
    record: Place,
    head: Vec<u8>,
    offsets: Vec<(u16, u64)>,
}

impl ChunkIndex {
    /// As a record; the message indexes end at `end`.
    fn body(&self, end: u64) -> Option<Vec<u8>> {
        let Place { at, length, .. } = self.record;
        let name = number(&self.head, 28, 4).ok()? as usize;
        let compression = self.head.get(28..32_usize.checked_add(name)?)?;
        let packed = self.head.get(32 + name..40 + name)?;
        let mut body = self.head.get(..16)?.to_vec();
        body.extend([at, length].map(u64::to_le_bytes).concat());
        body.extend(map(&self.offsets));
        body.extend((end - at - length).to_le_bytes());
        body.extend([compression, packed, self.head.get(16..24)?].concat());
        Some(body)
    }
}

/// A map of numbers by channel.
fn map(pairs: &[(u16, u64)]) -> Vec<u8> {
    let mut bytes = (10 * pairs.len() as u32).to_le_bytes().to_vec();
    for (channel, value) in pairs {
        bytes.extend(channel.to_le_bytes());
        bytes.extend(value.to_le_bytes());
    }
    bytes
}

/// What the records of a file tell together.
#[derive(Default)]
struct Found {
    /// Records by the number of the schema and of the channel.
    schemas: BTreeMap<u16, Vec<u8>>,
    channels: BTreeMap<u16, Vec<u8>>,
    /// Messages by channel.
    messages: BTreeMap<u16, u64>,
    /// Log times of the first message and the last.
    times: Option<(u64, u64)>,
    chunks: u32,
    metadata: u32,
    attachments: u32,
}

impl Found {
    fn span(&mut self, first: u64, last: u64) {
        let (start, end) = self.times.unwrap_or((first, last));
        self.times = Some((start.min(first), end.max(last)));
    }

    fn declare(&mut self, kind: u8, body: &[u8]) -> io::Result<()> {
        let declared = match kind == op::SCHEMA {
            true => &mut self.schemas,
            false => &mut self.channels,
        };
        declared.insert(number(body, 0, 2)? as u16, body.to_vec());
        Ok(())
    }

    /// Takes in the schemas and channels that a chunk declares.
    fn declared_in(&mut self, log: &mut BufReader<File>, chunk: &ChunkIndex) -> io::Result<()> {
        let Place { at, length, .. } = chunk.record;
        if length > WHOLE_MOST {
            return Err(damaged(at));
        }
        let mut bytes = vec![0; length as usize - 9];
        log.seek(SeekFrom::Start(at + 9))?;
        log.read_exact(&mut bytes)?;
        let unpacked = unpack(&bytes, |kind, body| match kind {
            op::SCHEMA | op::CHANNEL => self.declare(kind, body).map_err(|error| error.to_string()),
            _ => Ok(()),
        });
        unpacked.map_err(|_| damaged(at))
    }

    fn statistics(&self) -> Vec<u8> {
        let messages: Vec<(u16, u64)> = self
            .messages
            .iter()
            .map(|(&id, &count)| (id, count))
            .collect();
        let (start, end) = self.times.unwrap_or_default();
        let mut body = self.messages.values().sum::<u64>().to_le_bytes().to_vec();
        body.extend((self.schemas.len() as u16).to_le_bytes());
        let counts = [
            self.channels.len() as u32,
            self.attachments,
            self.metadata,
            self.chunks,
        ];
        body.extend(counts.map(u32::to_le_bytes).concat());
        body.extend([start, end].map(u64::to_le_bytes).concat());
        body.extend(map(&messages));
        body
    }
}

/// The records behind the data, in groups of one kind.
struct Summary {
    out: BufWriter<File>,
    sum: Digest<'static, u32>,
    start: u64,
    at: u64,
    /// Kind and place of each group.
    groups: Vec<(u8, u64)>,
}

impl Summary {
    fn behind(mut file: File, start: u64) -> io::Result<Self> {
        file.seek(SeekFrom::Start(start))?;
        let (out, sum) = (BufWriter::new(file), CRC.digest());
        Ok(Self {
            out,
            sum,
            start,
            at: start,
            groups: Vec::new(),
        })
    }

    fn bytes(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.sum.update(bytes);
        self.at += bytes.len() as u64;
        self.out.write_all(bytes)
    }

    fn put(&mut self, kind: u8, body: &[u8]) -> io::Result<()> {
        if self.groups.last().is_none_or(|(last, _)| *last != kind) {
            self.groups.push((kind, self.at));
        }
        self.bytes(&[kind])?;
        self.bytes(&(body.len() as u64).to_le_bytes())?;
        self.bytes(body)
    }

    /// Where the groups are, and the footer.
    fn finish(mut self) -> io::Result<()> {
        let groups = self.groups.clone();
        let offsets = self.at;
        let ends = groups.iter().skip(1).map(|(_, at)| *at).chain([offsets]);
        for ((kind, at), end) in groups.iter().zip(ends) {
            let place = [*at, end - at].map(u64::to_le_bytes).concat();
            self.put(op::SUMMARY_OFFSET, &[&[*kind][..], &place].concat())?;
        }
        self.bytes(&[op::FOOTER])?;
        self.bytes(&[20, self.start, offsets].map(u64::to_le_bytes).concat())?;
        let sum = self.sum.finalize().to_le_bytes();
        self.out.write_all(&sum)?;
        self.out.write_all(mcap::MAGIC)?;
        self.out.flush()
    }
}
