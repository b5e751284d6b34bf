//! A log in words: what is missing, and what is in it.

use crate::output::in_line;
use haptic_log::record::{EndKind, LogSummary, RECOVERED};
use std::io::{self, Write};
use std::path::Path;

/// Why a log is not whole, a few words each; none if it is.
pub(super) fn reasons(summary: &LogSummary) -> Vec<String> {
    let mut reasons = summary.damage.clone();
    let between: u64 = summary.gaps.iter().map(|gap| gap.missing).sum();
    for (missing, place) in [
        (summary.missing_at_start, "before the first one".to_owned()),
        (between, format!("in {} gaps", summary.gaps.len())),
        (summary.missing_at_end, "after the last one".to_owned()),
    ] {
        if missing > 0 {
            reasons.push(format!("{missing} ticks missing {place}"));
        }
    }
    let flaws = &summary.flaws;
    if flaws.impossible > 0 {
        reasons.push(format!(
            "of {} ticks the device told what cannot be",
            flaws.impossible
        ));
    }
    if flaws.is_stale(summary.samples) {
        reasons.push(stale(summary));
    }
    if summary.out_of_order > 0 {
        reasons.push(format!("{} ticks out of order", summary.out_of_order));
    }
    if !summary.complete && summary.damage.is_empty() {
        reasons.push("it was not finished".to_owned());
    }
    if let Some(end) = &summary.end {
        // A file of a rolled log, and what was saved of a damaged one, do not show all that the run counted.
        let counted = end.dropped_samples > summary.missing_samples && summary.continues.is_none();
        if counted {
            reasons.push(format!(
                "the run counted {} samples and events missing, the log shows {}",
                end.dropped_samples, summary.missing_samples
            ));
        }
        if end.ended == EndKind::Link && end.made_samples < end.planned_samples {
            reasons.push("the link was lost, and what the device still made with it".to_owned());
        }
    }
    reasons
}

/// Ticks that tell of an earlier one, in words.
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

/// What helps a log that is not whole: nothing, where its file is undamaged.
pub(super) fn advice(summary: &LogSummary) -> &'static str {
    let is_recovered = summary
        .metadata
        .iter()
        .any(|record| record.name == RECOVERED);
    match (summary.complete, is_recovered) {
        (false, _) => "`host-cli log recover` saves what is there",
        (true, true) => "it has all that `host-cli log recover` found, and what is missing is lost",
        (true, false) => {
            "its file is undamaged: what is missing never reached it, and `host-cli log recover` finds no more"
        }
    }
}

/// Damage and missing ticks, a line each.
pub(super) fn print_missing(out: &mut dyn Write, summary: &LogSummary) -> io::Result<()> {
    for damage in &summary.damage {
        writeln!(out, "damage: {damage}")?;
    }
    if summary.missing_at_start > 0 {
        let missing = summary.missing_at_start;
        writeln!(out, "start: {missing} ticks missing before {missing}")?;
    }
    for gap in &summary.gaps {
        let (missing, after, before) = (gap.missing, gap.after_tick, gap.before_tick);
        writeln!(
            out,
            "gap: {missing} ticks missing between {after} and {before}"
        )?;
    }
    if summary.missing_at_end > 0 {
        let (missing, made) = (summary.missing_at_end, summary.end.as_ref());
        let last = made.map_or(0, |end| end.made_samples.saturating_sub(1));
        writeln!(out, "end: {missing} ticks missing up to {last}")?;
    }
    Ok(())
}

/// Ticks in the log that are not what they seem.
pub(super) fn print_flaws(out: &mut dyn Write, summary: &LogSummary) -> io::Result<()> {
    if summary.flaws.stale > 0 {
        writeln!(out, "stale: {}", stale(summary))?;
    }
    if summary.flaws.impossible > 0 {
        let impossible = summary.flaws.impossible;
        writeln!(
            out,
            "impossible: of {impossible} ticks the device told what cannot be"
        )?;
    }
    Ok(())
}

/// The end of a run that did not reach its planned one, and the first file of the log if it is not this one.
pub(super) fn print_extent(out: &mut dyn Write, summary: &LogSummary) -> io::Result<()> {
    if let Some(end) = &summary.end
        && end.ended != EndKind::Finished
    {
        let planned = end.planned_samples;
        let made = end.made_samples.min(planned);
        let known = if end.ended == EndKind::Link {
            "heard of"
        } else {
            "made"
        };
        let reason = in_line(&end.reason);
        writeln!(
            out,
            "ended early: {reason}; {made} of {planned} planned samples were {known}"
        )?;
    }
    match &summary.continues {
        Some(first) => writeln!(
            out,
            "this file continues a log: give its first file, `{}`, for all of it",
            in_line(first)
        ),
        None => Ok(()),
    }
}

/// Says so if the log is what was saved of another.
pub(super) fn recovered(out: &mut dyn Write, summary: &LogSummary) -> io::Result<()> {
    match &summary.missing_since_recovery {
        Some(missing) => writeln!(
            out,
            "recovered from a log that was not whole: {}",
            in_line(missing)
        ),
        None => Ok(()),
    }
}

/// All that a log says of itself.
pub(super) fn print_info(out: &mut dyn Write, log: &Path, summary: &LogSummary) -> io::Result<()> {
    writeln!(
        out,
        "{}: {}",
        log.display(),
        if summary.complete {
            "whole"
        } else {
            "cut off or damaged"
        }
    )?;
    let time = |time: Option<f64>| time.map_or_else(|| "–".to_owned(), |t| format!("{t} s"));
    writeln!(
        out,
        "  {} samples from {} to {}, {} missing in {} gaps and at the ends",
        summary.samples,
        time(summary.first_s),
        time(summary.last_s),
        summary.missing_samples,
        summary.gaps.len()
    )?;
    if let Some(started) = &summary.started_utc {
        writeln!(out, "  time 0 is {started}")?;
    }
    for record in &summary.metadata {
        writeln!(out, "  [{}]", in_line(&record.name))?;
        for (key, value) in &record.values {
            writeln!(out, "    {:<26} {}", in_line(key), in_line(value))?;
        }
    }
    for event in &summary.events {
        let [kind, text] = [&event.kind, &event.text].map(|text| in_line(text));
        writeln!(out, "  event at {} s: {kind}: {text}", event.time_s)?;
    }
    for damage in &summary.damage {
        writeln!(out, "  damage: {damage}")?;
    }
    print_flaws(out, summary)?;
    print_extent(out, summary)?;
    recovered(out, summary)
}
