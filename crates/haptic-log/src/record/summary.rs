//! Summary of the run in a log: counts, times, gaps, end.

use std::{
    collections::BTreeMap,
    io::{BufReader, Read as _},
    path::Path,
};

use serde::Serialize;

use super::{
    CONTINUES, Damage, Entry, LogFiles, LogReader, RecordError, StartTime, new_file::open_file,
};
use haptic_message::{
    DRIVE_END, EndKind, EventMessage, MetadataRecord, RunEnd, TickMessage, flaw::FlawCounts,
};

/// Name of the metadata record that marks a recovered log.
pub const RECOVERED: &str = "recovered";

/// Ticks that are not in the log although later ones are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Gap {
    /// The last tick before the gap.
    pub after_tick: u64,
    /// The first tick behind it.
    pub before_tick: u64,
    /// Ticks between the one before and the one after that are not in the log.
    pub missing: u64,
}

impl Gap {
    fn between(after_tick: u64, before_tick: u64) -> Option<Self> {
        let missing = before_tick - after_tick - 1;
        let gap = Self {
            after_tick,
            before_tick,
            missing,
        };
        (missing > 0).then_some(gap)
    }
}

/// Counts ticks as they pass.
#[derive(Debug, Default)]
pub(crate) struct TickCount {
    pub samples: u64,
    pub first: Option<(u64, f64)>,
    pub last: Option<(u64, f64)>,
    pub gaps: Vec<Gap>,
    pub flaws: FlawCounts,
    /// End of the run, if the log says it.
    pub end: Option<RunEnd>,
    /// The first file of the log, if this is a later one.
    pub continues: Option<String>,
    /// Ticks of the drive, if the log has one.
    pub drive: Option<Box<Self>>,
}

impl TickCount {
    /// Takes in the next tick of a drive.
    pub(crate) fn add_drive(&mut self, message: &TickMessage) {
        self.drive.get_or_insert_default().add(message);
    }

    /// Ticks of a drive that are missing.
    pub(crate) fn drive_missing(&self) -> u64 {
        self.drive.as_ref().map_or(0, |drive| drive.missing())
    }

    /// Takes in the next tick.
    pub(crate) fn add(&mut self, message: &TickMessage) {
        self.flaws.add(message);
        let (tick, time_s) = (message.tick, message.time_s);
        match self.last {
            None => self.first = Some((tick, time_s)),
            Some((before, _)) if tick <= before => return self.add_late(tick),
            Some((before, _)) => self.gaps.extend(Gap::between(before, tick)),
        }
        self.samples += 1;
        self.last = Some((tick, time_s));
    }

    /// A tick that stands behind later ones is not missing where it should have stood.
    fn add_late(&mut self, tick: u64) {
        self.samples += 1;
        let at = self.gaps.partition_point(|gap| gap.before_tick <= tick);
        let Some(gap) = self.gaps.get(at).filter(|gap| gap.after_tick < tick) else {
            return;
        };
        let halves = [
            Gap::between(gap.after_tick, tick),
            Gap::between(tick, gap.before_tick),
        ];
        self.gaps.splice(at..=at, halves.into_iter().flatten());
    }

    /// Takes in what metadata say of the ticks.
    pub(crate) fn note(&mut self, record: &MetadataRecord) {
        if let Some(end) = RunEnd::of(record) {
            let of = if record.name == DRIVE_END {
                self.drive.get_or_insert_default()
            } else {
                self
            };
            of.end = Some(end);
        } else if record.name == CONTINUES {
            self.continues = record.values.get("file").cloned();
            self.drive
                .get_or_insert_default()
                .continues
                .clone_from(&self.continues);
        }
    }

    /// Ticks of the run before the first; unknown, so none, without the run's end.
    pub(crate) fn missing_at_start(&self) -> u64 {
        match (&self.end, &self.continues, self.first) {
            (Some(_), None, Some((tick, _))) => tick,
            _ => 0,
        }
    }

    /// Ticks of the run behind the last.
    pub(crate) fn missing_at_end(&self) -> u64 {
        let made = self.end.as_ref().map_or(0, |end| end.made_samples);
        match (self.last, &self.continues) {
            (Some((tick, _)), _) => made.saturating_sub(tick.saturating_add(1)),
            (None, None) => made,
            (None, Some(_)) => 0,
        }
    }

    /// All ticks that are missing.
    pub(crate) fn missing(&self) -> u64 {
        let between: u64 = self.gaps.iter().map(|gap| gap.missing).sum();
        self.missing_at_start() + between + self.missing_at_end()
    }
}

/// Name of the metadata record that says, once a second in a real-time loop, where the time of its
/// ticks went.
pub const BUDGET: &str = "budget";

/// Summary of a log. The first five keys are a contract of the command line.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LogSummary {
    /// Ticks that the log has, of its own device.
    pub samples: u64,
    /// Device time of the first tick, s; `None` without ticks.
    pub first_s: Option<f64>,
    /// Device time of the last tick, s.
    pub last_s: Option<f64>,
    /// Wall-clock time of device time 0, RFC 3339 in UTC; `None` in logs made before it was kept.
    pub started_utc: Option<String>,
    /// Missing ticks, by tick number.
    pub gaps: Vec<Gap>,
    /// Ticks missing before the first; 0 if the log does not say how its run ended, or continues
    /// another file.
    pub missing_at_start: u64,
    /// Ticks of the run missing after the last in the log; 0 if the log does not say how its run ended.
    pub missing_at_end: u64,
    /// All missing ticks: in gaps, at the start and at the end.
    pub missing_samples: u64,
    /// End of the run; `None` in logs made before it was kept, and in those that were cut.
    pub end: Option<RunEnd>,
    /// The first file of the log that this file continues; `None` for the first file.
    pub continues: Option<String>,
    /// True if the writer finished it and no part is damaged. Gaps do not count: their samples were
    /// lost before they reached the log.
    pub complete: bool,
    /// Ticks of the drive, a second device; `None` in a log without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drive_samples: Option<u64>,
    /// Ticks of the drive that are missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drive_missing_samples: Option<u64>,
    /// Ticks that come twice, or so late that they are not put in their place.
    pub out_of_order: u64,
    /// Ticks that stood behind later ones and were put in their place, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sorted_ticks: Option<u64>,
    /// Ticks that the device or the link got wrong, by kind.
    #[serde(flatten)]
    pub flaws: FlawCounts,
    /// Parts missing from the log that this one was recovered from; `None` if not recovered or nothing is missing.
    pub missing_since_recovery: Option<String>,
    /// Parts that could not be read, a sentence each.
    pub damage: Vec<String>,
    /// Messages on topics that are not ours: they are counted and left alone.
    pub foreign_messages: u64,
    /// Those topics, and the number of messages on each.
    pub foreign_topics: BTreeMap<String, u64>,
    /// The metadata records in file order.
    pub metadata: Vec<MetadataRecord>,
    /// The events in file order.
    pub events: Vec<EventMessage>,
}

impl LogSummary {
    /// Reasons why the log is not whole, a few words each; empty if it is.
    #[must_use]
    pub fn reasons(&self) -> Vec<String> {
        let mut reasons = self.damage.clone();
        let between: u64 = self.gaps.iter().map(|gap| gap.missing).sum();
        for (missing, which) in [
            (self.missing_at_start, "before the first one".to_owned()),
            (between, format!("in {} gaps", self.gaps.len())),
            (self.missing_at_end, "after the last one".to_owned()),
        ] {
            if missing > 0 {
                reasons.push(format!("{missing} ticks missing {which}"));
            }
        }
        if let Some(missing) = self.drive_missing_samples.filter(|missing| *missing > 0) {
            reasons.push(format!("{missing} ticks of the drive missing"));
        }
        let flaws = &self.flaws;
        if flaws.impossible > 0 {
            reasons.push(format!(
                "of {} ticks the device reported impossible values",
                flaws.impossible
            ));
        }
        if flaws.is_stale(self.samples) {
            reasons.push(stale(self));
        }
        if self.out_of_order > 0 {
            reasons.push(out_of_order(self.out_of_order));
        }
        if !self.complete && self.damage.is_empty() {
            reasons.push("it was not finished".to_owned());
        }
        if let Some(end) = &self.end {
            // A file of a rolled log, and what was saved of a damaged one, do not show all that the run counted.
            let counted = end.dropped_samples > self.missing_samples && self.continues.is_none();
            if counted {
                reasons.push(format!(
                    "the run counted {} samples and events missing, the log shows {}",
                    end.dropped_samples, self.missing_samples
                ));
            }
            if end.ended == EndKind::Link && end.made_samples < end.planned_samples {
                reasons
                    .push("the link was lost, and what the device still made with it".to_owned());
            }
        }
        reasons
    }
}

/// The reason why a log with `ticks` ticks out of order is not whole.
pub(super) fn out_of_order(ticks: u64) -> String {
    format!("{ticks} ticks come twice, or too late to be sorted")
}

/// Number of stale ticks in words, and the reasons.
fn stale(summary: &LogSummary) -> String {
    let flaws = &summary.flaws;
    let parts = [
        (flaws.unanswered, "the board did not answer"),
        (
            flaws.forces_not_taken,
            "it may not have taken the force before",
        ),
        (flaws.late_forces, "an older force of the host acted"),
    ];
    let parts = parts.into_iter().filter(|(count, _)| *count > 0);
    let parts: Vec<String> = parts
        .map(|(count, words)| format!("in {count} {words}"))
        .collect();
    format!(
        "{} of {} ticks are stale: {}",
        flaws.stale,
        summary.samples,
        parts.join(", ")
    )
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
            Entry::Tick(tick) => count.add(&tick),
            Entry::Drive(tick) => count.add_drive(&tick),
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
    summary.foreign_messages = condition.foreign_topics.values().sum();
    summary.foreign_topics = condition.foreign_topics;
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
    let drive = count
        .drive
        .filter(|drive| drive.samples + drive.missing() > 0);
    summary.drive_missing_samples = drive.as_ref().map(|drive| drive.missing());
    summary.drive_samples = drive.map(|drive| drive.samples);
    summary.last_s = count.last.map(|(_, time_s)| time_s);
    summary.gaps = count.gaps;
    summary.end = count.end;
    summary.continues = count.continues;
    summary.out_of_order = condition.out_of_order;
    summary.sorted_ticks = Some(condition.sorted).filter(|sorted| *sorted > 0);
    summary.flaws = count.flaws;
    Ok(summary)
}

/// Metadata and counts of a log, read without its samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skimmed {
    /// The metadata records in file order.
    pub metadata: Vec<MetadataRecord>,
    /// Ticks; `None` without an index of them.
    pub samples: Option<u64>,
    /// Time from the first tick to the last, s.
    pub duration_s: Option<f64>,
    /// True if, as far as it was read, the log was finished by its writer and no part of it is damaged.
    pub complete: bool,
}

/// Reads one file of a log without unpacking a sample, at most `most_bytes` of it: for a list of many.
///
/// # Errors
/// If the file cannot be read or is not MCAP.
pub fn skim(path: &Path, most_bytes: u64) -> Result<Skimmed, RecordError> {
    let file = open_file(path).map_err(|source| RecordError::read(path, source))?;
    let mut log = LogReader::new(BufReader::new(file).take(most_bytes), path)?;
    log.skim = Some(BTreeMap::new());
    let mut skimmed = Skimmed::default();
    for entry in log.by_ref() {
        if let Entry::Metadata(record) = entry? {
            skimmed.metadata.push(record);
        }
    }
    skimmed.complete = log.condition().complete;
    if let Some(ticks) = log.skimmed().filter(|ticks| ticks.count > 0) {
        skimmed.samples = Some(ticks.count);
        skimmed.duration_s = Some((ticks.last_ns - ticks.first_ns) as f64 / 1e9);
    }
    Ok(skimmed)
}
