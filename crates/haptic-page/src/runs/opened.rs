//! A log that is looked into: its samples as a pyramid, and what it says of itself.

use super::list::Seen;
use crate::pyramid::{Pyramid, PyramidSize};
use haptic_experiment::Failure;
use haptic_log::record::{Entry, LogFiles, LogSummary, TickMessage, inspect};
use serde_json::{Value, json};
use std::path::Path;

/// Channels of a log.
pub(super) const CHANNELS: [&str; 8] = [
    "position_m",
    "force_n",
    "environment_force_n",
    "reference_m",
    "indenter_position_m",
    "contact_force_n",
    "observed_energy_j",
    "limiter",
];
/// Samples of a pyramid that are kept one by one, and entries of its coarser levels.
const SAMPLES: usize = 1 << 19;
const ENTRIES: usize = 1 << 17;
/// Levels above: the last has 65 536 samples in an entry, enough for eight billion.
const COARSER: u32 = 8;
/// Ticks that may be missing in one place; more is a log that nobody should draw.
const GAP_MOST: u64 = 100_000_000;

/// An opened log.
#[derive(Debug)]
pub(super) struct Opened {
    pub(super) name: String,
    pub(super) seen: Seen,
    pub(super) pyramid: Pyramid,
    pub(super) sample_time_s: f64,
    summary: LogSummary,
}

/// A row of a pyramid.
pub(super) fn row(tick: &TickMessage) -> [f32; CHANNELS.len()] {
    [
        tick.position_m,
        tick.force_n,
        tick.environment_force_n,
        tick.reference_m,
        tick.indenter_position_m,
        tick.contact_force_n,
        tick.observed_energy_j,
        f64::from(tick.limiters),
    ]
    .map(|number| number as f32)
}

/// A pyramid for so many samples, no larger than it has to be.
pub(super) fn pyramid(samples: u64) -> Pyramid {
    let up_to = |most: usize, wanted: u64| usize::try_from(wanted).unwrap_or(most).clamp(1, most);
    Pyramid::new(PyramidSize {
        channels: CHANNELS.len(),
        samples: up_to(SAMPLES, samples),
        entries: up_to(ENTRIES, samples.div_ceil(4)),
        coarser: COARSER,
    })
}

/// Puts a tick where its number says; missing ones are no numbers.
///
/// # Errors
/// More missing ticks than can be drawn.
pub(super) fn push(pyramid: &mut Pyramid, tick: &TickMessage) -> Result<(), Failure> {
    let missing = tick.tick.saturating_sub(pyramid.made());
    if missing > GAP_MOST {
        return Err(Failure::bad_input(format_args!(
            "tick {} follows tick {}: this log cannot be drawn; look at it with `log check`",
            tick.tick,
            pyramid.made()
        )));
    }
    for _ in 0..missing {
        pyramid.push(&[]);
    }
    pyramid.push(&row(tick));
    Ok(())
}

impl Opened {
    /// Reads a log.
    ///
    /// # Errors
    /// One that cannot be read, or holds no sample.
    pub(super) fn read(name: &str, path: &Path, seen: Seen) -> Result<Self, Failure> {
        let summary = inspect(path)?;
        let (Some(first_s), Some(last_s)) = (summary.first_s, summary.last_s) else {
            return Err(Failure::bad_input(format_args!(
                "the log {name} holds no sample"
            )));
        };
        let mut pyramid = pyramid(summary.samples + summary.missing_samples);
        let mut ticks = None;
        for entry in LogFiles::open(path)? {
            if let Entry::Tick(tick) = entry? {
                let (first, _) = *ticks.get_or_insert((tick.tick, tick.tick));
                ticks = Some((first, tick.tick));
                push(&mut pyramid, &tick)?;
            }
        }
        let said = summary
            .metadata
            .iter()
            .find(|record| record.name == "experiment");
        let said = said.and_then(|record| record.values.get("sample_time_s")?.parse::<f64>().ok());
        let said = said.filter(|time| time.is_finite() && *time > 0.0);
        let (first, last) = ticks.unwrap_or((0, 0));
        let measured = (last_s - first_s) / last.saturating_sub(first).max(1) as f64;
        Ok(Self {
            name: name.to_owned(),
            seen,
            pyramid,
            sample_time_s: said.unwrap_or(measured),
            summary,
        })
    }

    /// What `runs.open` answers.
    pub(super) fn answer(&self) -> Value {
        let LogSummary {
            samples,
            first_s,
            last_s,
            started_utc,
            missing_samples,
            complete,
            damage,
            metadata,
            events,
            end,
            ..
        } = &self.summary;
        let metadata = metadata
            .iter()
            .map(|record| (record.name.clone(), json!(record.values)));
        json!({
            "name": self.name,
            "channels": CHANNELS,
            "samples": samples,
            "sample_time_s": self.sample_time_s,
            "first_s": first_s,
            "last_s": last_s,
            "started_utc": started_utc,
            "missing_samples": missing_samples,
            "complete": complete,
            "damage": damage,
            "metadata": metadata.collect::<serde_json::Map<_, _>>(),
            "events": events,
            "end": end,
        })
    }
}
