//! The samples of a log as a table, row by row as they are read.

use super::channels::{Channels, places};
use haptic_experiment::Failure;
use haptic_log::record::{Entry, LogFiles};
use serde::Deserialize;
use std::cmp::Ordering;
use std::fmt::Write as _;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// Bytes of a piece.
const PIECE: usize = 1 << 16;

/// What a table is to hold.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TableRequest {
    pub(crate) name: String,
    pub(crate) channels: Vec<String>,
    #[serde(default)]
    pub(crate) from_s: Option<f64>,
    #[serde(default)]
    pub(crate) to_s: Option<f64>,
}

/// A table of a log that is there.
#[derive(Debug)]
pub(crate) struct Table {
    log: PathBuf,
    channels: Channels,
    /// Of the columns behind the time.
    places: Vec<usize>,
    header: String,
    span_s: RangeInclusive<f64>,
}

impl Table {
    /// # Errors
    /// A channel that the log has not, a span without an end before its beginning.
    pub(super) fn new(
        log: PathBuf,
        channels: Channels,
        request: &TableRequest,
    ) -> Result<Self, Failure> {
        let [from_s, to_s] = [
            request.from_s.unwrap_or(f64::NEG_INFINITY),
            request.to_s.unwrap_or(f64::INFINITY),
        ];
        // Not a number is before nothing.
        if from_s.partial_cmp(&to_s).is_none_or(Ordering::is_gt) {
            return Err(Failure::bad_input("`from_s` has to be before `to_s`"));
        }
        Ok(Self {
            log,
            places: places(&request.channels, &channels.names())?,
            channels,
            header: format!("time_s,{}\n", request.channels.join(",")),
            span_s: from_s..=to_s,
        })
    }

    /// Reads the log and gives the table in pieces, until it is at an end or a piece is not taken. Every number has all of its
    /// digits.
    ///
    /// # Errors
    /// A log that cannot be read any more.
    pub(crate) fn pieces(&self, mut take: impl FnMut(Vec<u8>) -> bool) -> Result<(), Failure> {
        let mut piece = self.header.clone();
        let mut numbers = Vec::new();
        for entry in LogFiles::open(&self.log)? {
            let Entry::Tick(tick) = entry? else { continue };
            let time_s = tick.time_s;
            if !self.span_s.contains(&time_s) {
                continue;
            }
            numbers.clear();
            numbers.extend(self.channels.numbers(&tick));
            // Writing to a string cannot fail.
            let _ = write!(piece, "{time_s}");
            for &place in &self.places {
                let _ = write!(piece, ",{}", numbers.get(place).unwrap_or(&f64::NAN));
            }
            piece.push('\n');
            if piece.len() >= PIECE && !take(std::mem::take(&mut piece).into_bytes()) {
                return Ok(());
            }
        }
        take(piece.into_bytes());
        Ok(())
    }
}
