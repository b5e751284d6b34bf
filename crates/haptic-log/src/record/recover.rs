//! Saves what a cut or damaged log still holds.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::new_file::{refuse_being_written, refuse_own_source};
use super::summary::{Gap, TickCount};
use super::{Condition, Damage, Entry, Leftover, LogReader, LogWriter, RecordError};

/// Name of the metadata record that marks a recovered log.
pub const RECOVERED: &str = "recovered";

/// Result of a recovery: the saved data and the lost data.
#[derive(Clone, Debug, PartialEq)]
pub struct RecoverySummary {
    /// The log that was read.
    pub source: PathBuf,
    /// The new log.
    pub target: PathBuf,
    /// Ticks saved.
    pub samples: u64,
    /// Events saved.
    pub events: u64,
    /// Metadata records saved, not counting the one that marks the recovery.
    pub metadata_records: u64,
    /// Device time of the last tick saved, s.
    pub last_s: Option<f64>,
    /// Number of the last tick saved.
    pub last_tick: Option<u64>,
    /// Ticks missing between saved ones.
    pub gaps: Vec<Gap>,
    /// Ticks missing before the first saved, if the log says how its run ended.
    pub missing_at_start: u64,
    /// Ticks missing after the last saved, if the log says how its run ended.
    pub missing_at_end: u64,
    /// The log says how its run ended: nothing came after that.
    pub has_end: bool,
    /// Condition of the source.
    pub condition: Condition,
}

impl RecoverySummary {
    /// True if anything is known to be missing.
    pub fn lost_data(&self) -> bool {
        let at_the_ends = self.missing_at_start + self.missing_at_end;
        !self.condition.complete || !self.gaps.is_empty() || at_the_ends > 0
    }

    /// Missing parts, a sentence each; empty if the source was whole.
    pub fn missing(&self) -> Vec<String> {
        let mut sentences: Vec<String> =
            (self.condition.damage.iter().map(ToString::to_string)).collect();
        sentences.extend(self.gaps.iter().map(|gap| {
            format!(
                "{} ticks between {} and {} are missing",
                gap.missing, gap.after_tick, gap.before_tick
            )
        }));
        for (missing, place) in [
            (self.missing_at_start, "before the first"),
            (self.missing_at_end, "after the last"),
        ] {
            if missing > 0 {
                sentences.push(format!("{missing} ticks {place} one saved are missing"));
            }
        }
        if self.condition.foreign_messages > 0 {
            sentences.push(format!(
                "{} messages on topics that host-cli does not write were not copied",
                self.condition.foreign_messages
            ));
        }
        if !self.condition.complete {
            match self.last_s.zip(self.last_tick) {
                // What is missing after the last tick is counted above.
                Some(_) if self.has_end => {}
                Some((last_s, tick)) => {
                    sentences.push(format!(
                        "whatever came after tick {tick} at {last_s} s is lost"
                    ));
                }
                None => sentences.push("no sample could be saved".to_owned()),
            }
        }
        sentences
    }
}

/// Copies everything readable in `source` into the new, finished log `target`, which gets one
/// more metadata record, [`RECOVERED`]. The source is left as it is. With `overwrite` the target may exist.
///
/// ```
/// # use haptic_log::record::{LogWriter, TickMessage};
/// use haptic_log::record::recover;
///
/// # let folder = tempfile::tempdir()?;
/// # let (cut, saved) = (folder.path().join("run.mcap.part"), folder.path().join("saved.mcap"));
/// # let mut writer = LogWriter::create(&folder.path().join("run.mcap"))?;
/// # writer.tick(&TickMessage::default())?;
/// // The process that wrote `run.mcap` died: `run.mcap.part` is left.
/// drop(writer);
/// let summary = recover(&cut, &saved, false)?;
/// assert_eq!(summary.samples, 1);
/// assert!(summary.lost_data(), "nobody knows what came after");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the source cannot be read, is not MCAP or is being written by another run, or the target exists or
/// cannot be written, or is the source.
pub fn recover(
    source: &Path,
    target: &Path,
    overwrite: bool,
) -> Result<RecoverySummary, RecordError> {
    refuse_own_source(source, target)?;
    refuse_being_written(source)?;
    copy(source, target, overwrite).map_err(|error| match error {
        // There is nothing in the unfinished copy that the source does not have.
        RecordError::Write { source, .. } => RecordError::Copy {
            path: target.to_owned(),
            source,
        },
        error => error,
    })
}

fn copy(source: &Path, target: &Path, overwrite: bool) -> Result<RecoverySummary, RecordError> {
    let mut reader = LogReader::open(source)?;
    let mut writer = LogWriter::create_with(target, Leftover::Discard, overwrite)?;
    let mut count = TickCount::default();
    let (mut events, mut metadata_records) = (0, 0);
    let mut unreadable = None;
    while let Some(entry) = reader.next() {
        if let Some(start) = reader.started() {
            writer.dated(start);
        }
        match entry {
            // A failing disk is a reason to recover, not a reason to stop.
            Err(error) => unreadable = Some(error.to_string()),
            Ok(Entry::Tick(message)) => {
                writer.tick(&message)?;
                count.add(&message);
            }
            Ok(Entry::Event(event)) => {
                writer.event(&event)?;
                events += 1;
            }
            Ok(Entry::Metadata(record)) => {
                count.note(&record);
                writer.metadata(&record.name, record.values)?;
                metadata_records += 1;
            }
        }
    }
    let mut condition = reader.condition().clone();
    if let Some(cause) = unreadable {
        let at_byte = reader.bytes_read();
        condition.damage.push(Damage::Structure { at_byte, cause });
    }
    let summary = RecoverySummary {
        source: source.to_owned(),
        target: target.to_owned(),
        samples: count.samples,
        events,
        metadata_records,
        last_s: count.last.map(|(_, time_s)| time_s),
        last_tick: count.last.map(|(tick, _)| tick),
        missing_at_start: count.missing_at_start(),
        missing_at_end: count.missing_at_end(),
        has_end: count.end.is_some(),
        gaps: count.gaps,
        condition,
    };
    writer.metadata(RECOVERED, mark(&summary))?;
    writer.finish()?;
    Ok(summary)
}

/// The metadata record that marks the new log.
fn mark(summary: &RecoverySummary) -> BTreeMap<String, String> {
    let gaps: Vec<String> = (summary.gaps.iter())
        .map(|gap| format!("{}..{}", gap.after_tick, gap.before_tick))
        .collect();
    let entries = [
        ("source", summary.source.display().to_string()),
        ("samples_kept", summary.samples.to_string()),
        ("gaps", gaps.join(" ")),
        ("missing", summary.missing().join("; ")),
    ];
    entries.map(|(key, value)| (key.to_owned(), value)).into()
}
