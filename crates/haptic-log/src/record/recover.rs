//! Saves what a cut or damaged log still holds.

use serde::Serialize;
use std::path::{Path, PathBuf};

use super::new_file::{refuse_being_written, refuse_own_source};
use super::summary::{Gap, RECOVERED, TickCount};
use super::{Condition, Damage, Entry, Leftover, LogFiles, LogWriter, RecordError};

/// Result of a recovery: the saved data and the lost data.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecoverySummary {
    /// Ticks that the repaired log has.
    pub samples: u64,
    /// Events that the repaired log has.
    pub events: u64,
    /// Device time of the last tick saved, s.
    pub last_s: Option<f64>,
    /// Number of the last tick saved.
    pub last_tick: Option<u64>,
    /// Ticks missing between saved ones.
    pub gaps: Vec<Gap>,
    /// True if nothing is known to be missing.
    pub complete: bool,
    /// Missing parts, a sentence each; empty if the source was whole.
    pub missing: Vec<String>,
    /// The log that was written; the source is left unchanged.
    pub log: PathBuf,
    /// Ticks missing before the first saved and after the last, if the log says how its run ended.
    #[serde(skip)]
    pub missing_at_ends: [u64; 2],
}

/// Missing parts, a sentence each.
fn missing(count: &TickCount, condition: &Condition) -> Vec<String> {
    let mut sentences: Vec<String> = condition.damage.iter().map(ToString::to_string).collect();
    sentences.extend(count.gaps.iter().map(|gap| {
        format!(
            "{} ticks between {} and {} are missing",
            gap.missing, gap.after_tick, gap.before_tick
        )
    }));
    for (missing, which) in [
        (count.missing_at_start(), "before the first"),
        (count.missing_at_end(), "after the last"),
    ] {
        if missing > 0 {
            sentences.push(format!("{missing} ticks {which} one saved are missing"));
        }
    }
    let driven = count.drive_missing();
    if driven > 0 {
        sentences.push(format!("{driven} ticks of the drive are missing"));
    }
    let foreign: u64 = condition.foreign_topics.values().sum();
    if foreign > 0 {
        sentences.push(format!(
            "{foreign} messages on topics that host-cli does not write were not copied"
        ));
    }
    match count.last {
        // What is missing after the last tick is counted above.
        Some(_) if condition.complete || count.end.is_some() => {}
        Some((tick, last_s)) => sentences.push(format!(
            "whatever came after tick {tick} at {last_s} s is not in it"
        )),
        None if condition.complete => {}
        None => sentences.push("no sample could be saved".to_owned()),
    }
    sentences
}

/// Copies everything readable in `source`, and in the files that it goes on in, into the new,
/// finished log `target`, which gets one more metadata record, [`RECOVERED`]. The source is left
/// unchanged. With `overwrite` the target may exist.
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
/// assert!(!summary.complete, "nobody knows what came after");
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
    copy(source, target, overwrite).map_err(|error| {
        let RecordError::Write { source, .. } = error else {
            return error;
        };
        // There is nothing in the unfinished copy that the source does not have.
        let path = target.to_owned();
        RecordError::Copy { path, source }
    })
}

fn copy(source: &Path, target: &Path, overwrite: bool) -> Result<RecoverySummary, RecordError> {
    refuse_own_source(source, target)?;
    refuse_being_written(source)?;
    let mut reader = LogFiles::open(source)?;
    let mut writer = LogWriter::create_with(target, Leftover::Discard, overwrite, None)?;
    let mut file = source.to_owned();
    let mut count = TickCount::default();
    let mut events = 0;
    let mut unreadable = None;
    while let Some(entry) = reader.next() {
        if file != reader.path {
            reader.path.clone_into(&mut file);
            refuse_own_source(&file, target)?;
            refuse_being_written(&file)?;
        }
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
            Ok(Entry::Drive(message)) => {
                writer.drive_tick(&message)?;
                count.add_drive(&message);
            }
            Ok(Entry::Event(event)) => {
                writer.event(&event)?;
                events += 1;
            }
            Ok(Entry::Metadata(record)) => {
                count.note(&record);
                writer.metadata(&record.name, record.values)?;
            }
        }
    }
    let mut condition = reader.condition();
    if let Some(cause) = unreadable {
        let at_byte = reader.reader.bytes_read();
        condition.damage.push(Damage::Structure { at_byte, cause });
    }
    let gaps: Vec<String> = (count.gaps.iter())
        .map(|gap| format!("{}..{}", gap.after_tick, gap.before_tick))
        .collect();
    let missing = missing(&count, &condition);
    let mark = [
        ("source", source.display().to_string()),
        ("samples_kept", count.samples.to_string()),
        ("gaps", gaps.join(" ")),
        ("missing", missing.join("; ")),
    ];
    let mark = mark.map(|(key, value)| (key.to_owned(), value));
    writer.metadata(RECOVERED, mark.into())?;
    writer.finish()?;
    Ok(RecoverySummary {
        samples: count.samples,
        events,
        last_s: count.last.map(|(_, time_s)| time_s),
        last_tick: count.last.map(|(tick, _)| tick),
        complete: condition.complete && count.missing() + count.drive_missing() == 0,
        missing,
        log: target.to_owned(),
        missing_at_ends: [count.missing_at_start(), count.missing_at_end()],
        gaps: count.gaps,
    })
}
