//! Copies of a log: what a cut or damaged one still holds, and a span of one.

use serde::Serialize;
use std::path::{Path, PathBuf};

use super::{
    Condition, Damage, Entry, Leftover, LogFiles, LogWriter, RecordError, Span, SpanError,
    new_file::{refuse_being_written, refuse_own_source},
    summary::{Gap, RECOVERED, TickCount, out_of_order},
};
use haptic_message::{DRIVE_END, END};

/// Name of the metadata record that marks a span that was cut out of a log.
pub const CUT: &str = "cut";

/// Result of a copy: the saved data and the lost data.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RecoverySummary {
    /// Ticks that the repaired log has.
    pub samples: u64,
    /// Events that the repaired log has.
    pub events: u64,
    /// Device time of the first tick saved, s.
    pub first_s: Option<f64>,
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
    if condition.out_of_order > 0 {
        sentences.push(out_of_order(condition.out_of_order));
    }
    let foreign: u64 = condition.foreign_topics.values().sum();
    if foreign > 0 {
        sentences.push(format!(
            "{foreign} messages on topics that host-cli does not write, or attachments, were not copied"
        ));
    }
    match count.last {
        // The samples missing after the last tick are counted above.
        Some(_) if condition.complete || count.end.is_some() => {}
        Some((tick, last_s)) => sentences.push(format!(
            "whatever came after tick {tick} at {last_s} s is not in it"
        )),
        None if condition.complete => {}
        None => sentences.push("no sample could be saved".to_owned()),
    }
    sentences
}

/// Copies everything readable in `source`, and in the files that continue it, into the new,
/// finished log `target`, which gets one more metadata record, [`RECOVERED`]. The source is left
/// unchanged. With `overwrite` the target may exist.
///
/// ```
/// # use haptic_log::record::LogWriter;
/// # use haptic_message::TickMessage;
/// use haptic_log::record::recover;
///
/// # let folder = tempfile::tempdir()?;
/// # let (cut, saved) = (folder.path().join("run.mcap.part"), folder.path().join("saved.mcap"));
/// # let mut writer = LogWriter::create(&folder.path().join("run.mcap"))?;
/// # writer.tick(&TickMessage::at_rest(1))?;
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
    copy(source, target, None, overwrite).map_err(|error| untouched(error, target))
}

/// There is nothing in the unfinished copy that the source does not have.
fn untouched(error: RecordError, target: &Path) -> RecordError {
    let RecordError::Write { source, .. } = error else {
        return error;
    };
    let path = target.to_owned();
    RecordError::Copy { path, source }
}

/// Copies a span of `source`, and of the files that continue it, into the new, finished log `target`. Times and numbers
/// of the ticks stay those of the run, and so do the metadata, but for those of its end: these are called `source.end`, and
/// the new log is judged by its gaps. One more record, [`CUT`], says what it is a part of. The source is left unchanged.
///
/// ```
/// # use haptic_log::record::LogWriter;
/// # use haptic_message::TickMessage;
/// use haptic_log::record::{Span, cut, inspect};
///
/// # let folder = tempfile::tempdir()?;
/// # let (run, part) = (folder.path().join("run.mcap"), folder.path().join("part.mcap"));
/// # let mut writer = LogWriter::create(&run)?;
/// # for tick in 0..100 {
/// #     writer.tick(&TickMessage { tick, time_s: 0.01 * tick as f64, ..TickMessage::at_rest(1) })?;
/// # }
/// # writer.finish()?;
/// let made = cut(&run, &part, Span { from_s: 0.2, to_s: 0.4 }, false)?;
/// assert_eq!((made.samples, made.first_s), (21, Some(0.2)));
/// assert!(inspect(&part)?.reasons().is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`recover`]; and if the span is not among the samples, or has none.
pub fn cut(
    source: &Path,
    target: &Path,
    span: Span,
    overwrite: bool,
) -> Result<RecoverySummary, RecordError> {
    copy(source, target, Some(span), overwrite).map_err(|error| untouched(error, target))
}

fn copy(
    source: &Path,
    target: &Path,
    span: Option<Span>,
    overwrite: bool,
) -> Result<RecoverySummary, RecordError> {
    let kept = span.unwrap_or(Span::WHOLE);
    refuse_own_source(source, target)?;
    refuse_being_written(source)?;
    let mut reader = LogFiles::open(source)?;
    let mut writer = LogWriter::create_with(target, Leftover::Discard, overwrite, None)?;
    let mut file = source.to_owned();
    let mut count = TickCount::default();
    let mut seen_s = None;
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
                let time_s = message.time_s;
                let (first_s, _) = seen_s.unwrap_or((time_s, time_s));
                seen_s = Some((first_s, time_s));
                if kept.holds(time_s) {
                    writer.tick(&message)?;
                    count.add(&message);
                }
            }
            Ok(Entry::Drive(message)) if kept.holds(message.time_s) => {
                writer.drive_tick(&message)?;
                count.add_drive(&message);
            }
            Ok(Entry::Event(event)) if kept.holds(event.time_s) => {
                writer.event(&event)?;
                events += 1;
            }
            Ok(Entry::Drive(_) | Entry::Event(_)) => {}
            Ok(Entry::Metadata(record)) => {
                let is_end = [END, DRIVE_END].contains(&record.name.as_str());
                if is_end && span.is_some() {
                    writer.metadata(&format!("source.{}", record.name), record.values)?;
                } else {
                    count.note(&record);
                    writer.metadata(&record.name, record.values)?;
                }
            }
        }
    }
    let mut condition = reader.condition();
    if let Some(cause) = unreadable {
        let at_byte = reader.reader.bytes_read;
        condition.damage.push(Damage::Structure { at_byte, cause });
    }
    if span.is_some() {
        if seen_s.is_none() && !condition.foreign_topics.is_empty() {
            return Err(RecordError::NoTicks {
                path: source.to_owned(),
                topics: condition.foreign_topics.into_keys().collect(),
            });
        }
        kept.check(seen_s)?;
        count.first.ok_or(SpanError::Bare)?;
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
    let name = span.map_or(RECOVERED, |_| CUT);
    writer.metadata(name, mark.into())?;
    writer.finish()?;
    Ok(RecoverySummary {
        samples: count.samples,
        events,
        first_s: count.first.map(|(_, time_s)| time_s),
        last_s: count.last.map(|(_, time_s)| time_s),
        last_tick: count.last.map(|(tick, _)| tick),
        complete: missing.is_empty(),
        missing,
        log: target.to_owned(),
        missing_at_ends: [count.missing_at_start(), count.missing_at_end()],
        gaps: count.gaps,
    })
}
