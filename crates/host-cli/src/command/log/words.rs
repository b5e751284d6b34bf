//! A log in words: what is missing, and what is in it.

use haptic_log::record::{EndKind, LogSummary, RECOVERED};

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
