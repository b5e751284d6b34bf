//! What is in a log: counts, times, gaps, metadata.

use std::path::Path;

use serde::Serialize;

use super::{
    Damage, Entry, EventMessage, LogFiles, MetadataRecord, RECOVERED, RecordError, StartTime,
    TickMessage,
};

/// Ticks that are not in the log although later ones are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Gap {
    /// The last tick before the gap.
    pub after_tick: u64,
    /// The first tick behind it.
    pub before_tick: u64,
    /// How many are missing.
    pub missing: u64,
}

/// What is in a log. The first five keys are a contract of the command line.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LogSummary {
    /// Ticks in the log.
    pub samples: u64,
    /// Device time of the first tick, s; `None` without ticks.
    pub first_s: Option<f64>,
    /// Device time of the last tick, s.
    pub last_s: Option<f64>,
    /// Wall-clock time of device time 0, RFC 3339 in UTC; `None` in logs made before it was kept.
    pub started_utc: Option<String>,
    /// Missing ticks, by tick number.
    pub gaps: Vec<Gap>,
    /// The log was finished by its writer and no part of it is damaged. Gaps do not count: the
    /// samples of a gap were lost before they reached the log.
    pub complete: bool,
    /// Ticks whose number is not above that of the tick before.
    pub out_of_order: u64,
    /// What is missing from the log that this one was recovered from; `None` if it is no recovered one
    /// or nothing is missing.
    pub missing_since_recovery: Option<String>,
    /// What could not be read, a sentence each.
    pub damage: Vec<String>,
    /// Messages on other topics.
    pub foreign_messages: u64,
    /// The metadata records in file order.
    pub metadata: Vec<MetadataRecord>,
    /// The events in file order.
    pub events: Vec<EventMessage>,
}

/// Counts ticks as they pass.
#[derive(Clone, Debug, Default)]
pub(crate) struct TickCount {
    pub(crate) samples: u64,
    pub(crate) first_s: Option<f64>,
    pub(crate) last: Option<(u64, f64)>,
    pub(crate) gaps: Vec<Gap>,
    pub(crate) out_of_order: u64,
}

impl TickCount {
    /// Takes in the next tick.
    pub(crate) fn add(&mut self, message: &TickMessage) {
        match self.last {
            None => self.first_s = Some(message.time_s),
            Some((before, _)) if message.tick <= before => self.out_of_order += 1,
            Some((before, _)) if message.tick - before > 1 => self.gaps.push(Gap {
                after_tick: before,
                before_tick: message.tick,
                missing: message.tick - before - 1,
            }),
            Some(_) => {}
        }
        self.samples += 1;
        self.last = Some((message.tick, message.time_s));
    }
}

/// Reads a log to its end and says what is in it.
///
/// # Errors
/// If the file cannot be read or is not MCAP; damage inside is part of the answer.
pub fn inspect(path: &Path) -> Result<LogSummary, RecordError> {
    let mut reader = LogFiles::open(path)?;
    let mut count = TickCount::default();
    let mut summary = LogSummary::default();
    let mut started = None;
    while let Some(entry) = reader.next() {
        started = started.or_else(|| reader.started());
        match entry? {
            Entry::Tick(message) => count.add(&message),
            Entry::Event(event) => summary.events.push(event),
            Entry::Metadata(record) => summary.metadata.push(record),
        }
    }
    summary.started_utc = started.map(StartTime::rfc3339);
    let condition = reader.condition();
    summary.complete = condition.complete;
    summary.damage = condition.damage.iter().map(Damage::to_string).collect();
    summary.foreign_messages = condition.foreign_messages;
    summary.missing_since_recovery = summary
        .metadata
        .iter()
        .filter(|record| record.name == RECOVERED)
        .filter_map(|record| record.values.get("missing"))
        .find(|missing| !missing.is_empty())
        .cloned();
    summary.samples = count.samples;
    summary.first_s = count.first_s;
    summary.last_s = count.last.map(|(_, time_s)| time_s);
    summary.gaps = count.gaps;
    summary.out_of_order = count.out_of_order;
    Ok(summary)
}
