//! A log that is looked into: its samples as a pyramid, and what it says of itself.

use super::list::Seen;
use haptic_answer::channels::{Channels, places};
use haptic_answer::pyramid::Pyramid;
use haptic_answer::request::TableRequest;
use haptic_experiment::Failure;
use haptic_log::record::{Entry, LogFiles, LogSummary, inspect};
use haptic_message::TickMessage;
use serde_json::{Value, json};
use std::cmp::Ordering;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Most ticks that may be missing in one place; a log with more is not drawn.
const GAP_MOST: u64 = 100_000_000;

#[derive(Debug)]
pub(super) struct Opened {
    pub(super) name: String,
    pub(super) seen: Seen,
    pub(super) pyramid: Pyramid,
    pub(super) channels: Channels,
    pub(super) sample_time_s: f64,
    summary: LogSummary,
}

/// Puts a tick where its number says; missing ones are no numbers.
pub(super) fn push(
    pyramid: &mut Pyramid,
    channels: &Channels,
    tick: &TickMessage,
) -> Result<(), Failure> {
    let missing = tick.tick.saturating_sub(pyramid.made());
    if missing > GAP_MOST {
        return Err(Failure::bad_input(format_args!(
            "tick {} follows tick {}: this log cannot be drawn; check it with `log check`",
            tick.tick,
            pyramid.made()
        )));
    }
    for _ in 0..missing {
        pyramid.push(&[]);
    }
    pyramid.push(&channels.row(tick));
    Ok(())
}

impl Opened {
    pub(super) fn read(name: &str, path: &Path, seen: Seen) -> Result<Self, Failure> {
        let summary = inspect(path)?;
        let (Some(first_s), Some(last_s)) = (summary.first_s, summary.last_s) else {
            return Err(no_sample(name));
        };
        let mut read = None;
        let mut ticks = (0, 0);
        for entry in LogFiles::open(path)? {
            let Entry::Tick(tick) = entry? else { continue };
            let (channels, pyramid) = read.get_or_insert_with(|| {
                let channels = Channels::of(tick.axes());
                let samples = summary.samples.saturating_add(summary.missing_samples);
                ticks = (tick.tick, tick.tick);
                let pyramid = channels.pyramid(samples);
                (channels, pyramid)
            });
            ticks.1 = tick.tick;
            push(pyramid, channels, &tick)?;
        }
        let (channels, pyramid) = read.ok_or_else(|| no_sample(name))?;
        let mut records = summary.metadata.iter();
        let record = records.find(|record| record.name == "experiment");
        let sample_time_s =
            record.and_then(|record| record.values.get("sample_time_s")?.parse::<f64>().ok());
        let sample_time_s = sample_time_s.filter(|time| time.is_finite() && *time > 0.0);
        let (first, last) = ticks;
        let measured = (last_s - first_s) / last.saturating_sub(first).max(1) as f64;
        Ok(Self {
            name: name.to_owned(),
            seen,
            pyramid,
            channels,
            sample_time_s: sample_time_s.unwrap_or(measured),
            summary,
        })
    }

    /// The answer to `runs.open`.
    pub(super) fn answer(&self) -> Value {
        let summary = &self.summary;
        let metadata = summary.metadata.iter();
        let metadata = metadata.map(|record| (record.name.clone(), json!(record.values)));
        json!({
            "name": self.name,
            "channels": self.channels.names(),
            "axes": self.channels.axes,
            "samples": summary.samples,
            "sample_time_s": self.sample_time_s,
            "first_s": summary.first_s,
            "last_s": summary.last_s,
            "started_utc": summary.started_utc,
            "missing_samples": summary.missing_samples,
            "complete": summary.complete,
            "damage": summary.damage,
            "metadata": metadata.collect::<serde_json::Map<_, _>>(),
            "events": summary.events,
            "end": summary.end,
        })
    }
}

fn no_sample(name: &str) -> Failure {
    Failure::bad_input(format_args!("the log {name} holds no sample"))
}

const PIECE: usize = 1 << 16;

/// A table of a log that is there.
#[derive(Debug)]
pub(crate) struct Table {
    log: PathBuf,
    channels: Channels,
    /// Places of the columns behind the time.
    places: Vec<usize>,
    header: String,
    span_s: RangeInclusive<f64>,
}

impl Table {
    pub(super) fn new(
        log: PathBuf,
        channels: Channels,
        request: &TableRequest,
    ) -> Result<Self, Failure> {
        let from_s = request.from_s.unwrap_or(f64::NEG_INFINITY);
        let to_s = request.to_s.unwrap_or(f64::INFINITY);
        // Not a number is before nothing.
        if from_s.partial_cmp(&to_s).is_none_or(Ordering::is_gt) {
            return Err(Failure::bad_input("`from_s` has to be before `to_s`"));
        }
        Ok(Self {
            log,
            places: places(&request.channels, &channels.names())?,
            channels,
            header: Channels::head(&request.channels),
            span_s: from_s..=to_s,
        })
    }

    /// Reads the log and gives the table in pieces, until it is at an end or a piece is not taken. Every number has all of its digits.
    pub(crate) fn pieces(&self, mut take: impl FnMut(Vec<u8>) -> bool) -> Result<(), Failure> {
        let mut piece = self.header.clone();
        for entry in LogFiles::open(&self.log)? {
            let Entry::Tick(tick) = entry? else { continue };
            if !self.span_s.contains(&tick.time_s) {
                continue;
            }
            self.channels.line(&mut piece, &tick, &self.places);
            if piece.len() >= PIECE && !take(std::mem::take(&mut piece).into_bytes()) {
                return Ok(());
            }
        }
        take(piece.into_bytes());
        Ok(())
    }
}
