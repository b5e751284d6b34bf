//! Summary of a log: counts, times, gaps, metadata.

use std::path::Path;

use serde::Serialize;

use super::count::{Gap, TickCount};
use super::{
    Damage, Entry, EventMessage, FlawCounts, LogFiles, MetadataRecord, RECOVERED, RecordError,
    RunEnd, StartTime,
};

/// Name of the metadata record that tells, once a second of a loop by the clock, where the time of its ticks went. A
/// summary of the log has the last of them.
pub const BUDGET: &str = "budget";

/// Summary of a log. The first five keys are a contract of the command line.
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
    /// Ticks missing before the first in the log; 0 if the log does not say how its run ended, or goes on
    /// with another file's.
    pub missing_at_start: u64,
    /// Ticks of the run missing after the last in the log; 0 if the log does not say how its run ended.
    pub missing_at_end: u64,
    /// All missing ticks: those of the gaps, of the start and of the end.
    pub missing_samples: u64,
    /// End of the run; `None` in logs made before it was kept, and in those that were cut.
    pub end: Option<RunEnd>,
    /// The first file of the log that this one goes on with; `None` for the first.
    pub continues: Option<String>,
    /// The log was finished by its writer and no part of it is damaged. Gaps do not count: the
    /// samples of a gap were lost before they reached the log.
    pub complete: bool,
    /// Ticks whose number is not above that of the tick before.
    pub out_of_order: u64,
    /// Ticks with flaws.
    #[serde(flatten)]
    pub flaws: FlawCounts,
    /// Parts that are missing from the log that this one was recovered from. `None` if this log was not recovered
    /// or nothing is missing.
    pub missing_since_recovery: Option<String>,
    /// Parts that could not be read, a sentence each.
    pub damage: Vec<String>,
    /// Messages on other topics.
    pub foreign_messages: u64,
    /// The metadata records in file order.
    pub metadata: Vec<MetadataRecord>,
    /// The events in file order.
    pub events: Vec<EventMessage>,
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
            Entry::Tick(tick) => count.add(tick),
            Entry::Vector(tick) => count.add(tick),
            Entry::Event(event) => summary.events.push(event),
            Entry::Metadata(record) => {
                count.note(&record);
                if record.name == BUDGET {
                    summary.metadata.retain(|earlier| earlier.name != BUDGET);
                }
                summary.metadata.push(record);
            }
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
    summary.first_s = count.first.map(|(_, time_s)| time_s);
    summary.missing_at_start = count.missing_at_start();
    summary.missing_at_end = count.missing_at_end();
    summary.missing_samples = count.missing();
    summary.last_s = count.last.map(|(_, time_s)| time_s);
    summary.gaps = count.gaps;
    summary.end = count.end;
    summary.continues = count.continues;
    summary.out_of_order = count.out_of_order;
    summary.flaws = count.flaws;
    Ok(summary)
}
