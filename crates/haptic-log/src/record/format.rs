//! The MCAP file as this crate writes it: profile, channels, chunks, times.

use std::collections::BTreeMap;
use std::io::{Seek, Write};

use mcap::{Compression, WriteOptions};

use super::message::LogMessage;
use super::{EventMessage, RecordError, TickMessage, VectorTick};

/// A chunk of this many bytes is closed early, whatever the time.
const CHUNK_BYTES: u64 = 1 << 20;

/// Name of the writer. Readers of this crate trust the channel numbers below if a log has this name.
pub(crate) const LIBRARY: &str = concat!("host-cli ", env!("CARGO_PKG_VERSION"));
/// Start of [`LIBRARY`], the same in every version.
pub(crate) const LIBRARY_NAME: &str = "host-cli ";
/// MCAP channel of the ticks.
pub(crate) const TICK_CHANNEL: u16 = 1;
/// MCAP channel of the events.
pub(crate) const EVENT_CHANNEL: u16 = 2;

/// MCAP channel of the ticks with vectors: only in logs that have some.
pub(crate) const VECTOR_CHANNEL: u16 = 3;

/// Writes header, schemas and channels, and flushes them.
pub(super) fn start<W: Write + Seek>(sink: W) -> mcap::McapResult<mcap::Writer<W>> {
    let mut mcap = options(true).create(sink)?;
    add_channels(&mut mcap)?;
    mcap.flush()?;
    Ok(mcap)
}

/// Options of the MCAP writer. Without an index, it omits the summary and the checksum of the whole file.
pub(super) fn options(indexed: bool) -> WriteOptions {
    WriteOptions::new()
        .profile("ros2")
        .library(LIBRARY)
        .compression(Some(Compression::Lz4))
        .chunk_size(Some(CHUNK_BYTES))
        // Chunks are buffered and written whole, rather than patched afterwards.
        .disable_seeking(true)
        .emit_summary_records(indexed)
        .emit_summary_offsets(indexed)
        .repeat_channels(indexed)
        .repeat_schemas(indexed)
        .calculate_data_section_crc(indexed)
}

pub(super) fn add_channels<W: Write + Seek>(mcap: &mut mcap::Writer<W>) -> mcap::McapResult<()> {
    add_channel::<TickMessage, W>(mcap, TICK_CHANNEL)?;
    add_channel::<EventMessage, W>(mcap, EVENT_CHANNEL)
}

/// Announces ticks with vectors.
pub(super) fn add_vectors<W: Write + Seek>(mcap: &mut mcap::Writer<W>) -> mcap::McapResult<()> {
    add_channel::<VectorTick, W>(mcap, VECTOR_CHANNEL)
}

fn add_channel<M: LogMessage, W: Write + Seek>(
    mcap: &mut mcap::Writer<W>,
    id: u16,
) -> mcap::McapResult<()> {
    let schema = mcap.add_schema(M::SCHEMA_NAME, "ros2msg", M::SCHEMA.as_bytes())?;
    mcap.add_channel_with_id(id, schema, M::TOPIC, "cdr", &BTreeMap::new())?;
    Ok(())
}

/// Device time in ns, rounded to the nearest.
pub(super) fn nanoseconds(time_s: f64) -> Result<u64, RecordError> {
    if !(0.0..=1.8e10).contains(&time_s) {
        return Err(RecordError::Time { time_s });
    }
    Ok((time_s * 1e9).round() as u64)
}
