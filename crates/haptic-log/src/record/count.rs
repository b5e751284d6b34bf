//! Ticks counted as they pass, and those that are missing.

use serde::Serialize;

use super::flaw::FlawCounts;
use super::{AnyTick, CONTINUES, MetadataRecord, RunEnd};

/// Ticks that are not in the log although later ones are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Gap {
    /// The last tick before the gap.
    pub after_tick: u64,
    /// The first tick behind it.
    pub before_tick: u64,
    /// Number of missing ticks.
    pub missing: u64,
}

/// Counts ticks as they pass.
#[derive(Clone, Debug, Default)]
pub(crate) struct TickCount {
    pub(crate) samples: u64,
    pub(crate) first: Option<(u64, f64)>,
    pub(crate) last: Option<(u64, f64)>,
    pub(crate) gaps: Vec<Gap>,
    pub(crate) out_of_order: u64,
    pub(crate) flaws: FlawCounts,
    /// End of the run, if the log says it.
    pub(crate) end: Option<RunEnd>,
    /// The first file of the log, if this is a later one.
    pub(crate) continues: Option<String>,
}

impl TickCount {
    /// Takes in the next tick.
    pub(crate) fn add(&mut self, message: impl Into<AnyTick>) {
        let message = message.into();
        self.flaws.add(&message);
        let (tick, time_s) = (message.tick(), message.time_s());
        match self.last {
            None => self.first = Some((tick, time_s)),
            Some((before, _)) if tick <= before => self.out_of_order += 1,
            Some((before, _)) if tick - before > 1 => self.gaps.push(Gap {
                after_tick: before,
                before_tick: tick,
                missing: tick - before - 1,
            }),
            Some(_) => {}
        }
        self.samples += 1;
        self.last = Some((tick, time_s));
    }

    /// Takes in what metadata say of the ticks.
    pub(crate) fn note(&mut self, record: &MetadataRecord) {
        if let Some(end) = RunEnd::of(record) {
            self.end = Some(end);
        } else if record.name == CONTINUES {
            self.continues = record.values.get("file").cloned();
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
