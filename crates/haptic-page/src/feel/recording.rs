//! The log of what is felt.

use super::ticking::Ticked;
use crate::folder::next_folder;
use haptic_experiment::Failure;
use haptic_experiment::run::{Recorder, by_loop};
use haptic_log::record::{END, EndKind, RunEnd, StartTime, TickMessage};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::SystemTime;

#[derive(Debug)]
pub(super) struct Recording {
    recorder: Recorder,
    /// Its path in the folder of the runs, without `.mcap`.
    pub(super) name: String,
    first: Option<(u64, f64)>,
    pub(super) samples: u64,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Finished {
    pub(super) name: String,
    pub(super) samples: u64,
    pub(super) missing: u64,
}

impl Recording {
    /// Begins in the next free folder `feel-NNNN` of the runs.
    pub(super) fn start(
        runs: &Path,
        mut metadata: BTreeMap<String, String>,
        provenance: &BTreeMap<String, String>,
    ) -> Result<Self, Failure> {
        let (request, name) = next_folder(runs, "feel", provenance)?;
        metadata.extend(provenance.clone());
        let folder = request.prepare()?;
        let log = folder.file("mcap");
        let recorder = Recorder::start(&log, metadata, false, false, None, Vec::new())
            .inspect_err(|_| folder.discard())?;
        Ok(Self {
            recorder,
            name,
            first: None,
            samples: 0,
        })
    }

    /// Takes a tick; `false` if the writer has ended, as on a full disk.
    pub(super) fn tick(&mut self, ticked: &Ticked, energy_j: f64) -> bool {
        let reading = &ticked.sample.reading;
        let (first_tick, first_s) = *self.first.get_or_insert_with(|| {
            // A writer that has ended is seen at the tick.
            let _ = self.recorder.starts_at(StartTime::at(SystemTime::now()));
            (reading.tick, reading.time_s)
        });
        self.samples = reading.tick + 1 - first_tick;
        let hand = TickMessage {
            reference_m: ticked.hand_m.into(),
            indenter_position_m: ticked.hand_m.into(),
            contact_force_n: ticked.hand_force_n.into(),
            ..TickMessage::unknown(1)
        };
        let message = TickMessage {
            tick: reading.tick - first_tick,
            time_s: reading.time_s - first_s,
            ..by_loop(hand, &ticked.sample, Some(-energy_j))
        };
        self.recorder.tick(&message).is_ok()
    }

    pub(super) fn event(&mut self, time_s: f64, kind: &str, text: String) {
        let since = time_s - self.first.map_or(time_s, |(_, first_s)| first_s);
        // A writer that has ended is seen at the tick.
        let _ = self.recorder.event(since, kind, text);
    }

    pub(super) fn finish(mut self) -> Result<Finished, Failure> {
        let missing = self.recorder.dropped();
        let end = RunEnd {
            ended: EndKind::Finished,
            reason: String::new(),
            planned_samples: self.samples,
            made_samples: self.samples,
            dropped_samples: missing,
        };
        self.recorder.metadata(END, end.metadata());
        self.recorder.finish()?;
        Ok(Finished {
            name: self.name,
            samples: self.samples,
            missing,
        })
    }
}
