//! The log of what is felt.

use super::ticking::Ticked;
use haptic_document::Failure;
use haptic_log::record::StartTime;
use haptic_message::{END, EndKind, RunEnd, TickMessage};
use haptic_run::{folder::FolderRequest, recorder::Recorder};
use haptic_trial::tick::by_loop;
use std::{collections::BTreeMap, time::SystemTime};

/// A log that begins and ends while the loop goes on.
#[derive(Debug)]
pub struct Recording {
    recorder: Recorder,
    /// Its path in the folder of the runs, without `.mcap`.
    pub name: String,
    first: Option<(u64, f64)>,
    /// Samples from its first to its newest, those that are missing included.
    pub samples: u64,
}

/// A recording that has ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finished {
    /// Its path in the folder of the runs, without `.mcap`.
    pub name: String,
    /// Samples from its first to its last.
    pub samples: u64,
    /// Those of them that are not in it.
    pub missing: u64,
}

impl Recording {
    /// Begins in this folder, with these metadata beside those of the folder.
    ///
    /// # Errors
    /// A folder or log that cannot be made.
    pub fn start(
        request: &FolderRequest,
        name: String,
        mut metadata: BTreeMap<String, String>,
    ) -> Result<Self, Failure> {
        metadata.extend(request.provenance.clone());
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
    pub fn tick(&mut self, ticked: &Ticked, energy_j: f64) -> bool {
        let reading = &ticked.sample.reading;
        self.first.get_or_insert_with(|| {
            // A writer that has ended is seen at the tick.
            let _ = self.recorder.starts_at(StartTime::at(SystemTime::now()));
            (reading.tick, reading.time_s)
        });
        let (tick, time_s) = self.at(ticked);
        self.samples = tick + 1;
        let hand = TickMessage {
            reference_m: ticked.around.hand_m.into(),
            indenter_position_m: ticked.around.hand_m.into(),
            contact_force_n: ticked.around.hand_force_n.into(),
            ..TickMessage::unknown(1)
        };
        let message = TickMessage {
            tick,
            time_s,
            ..by_loop(hand, &ticked.sample, Some(-energy_j))
        };
        self.recorder.tick(&message).is_ok()
    }

    /// The number of a tick in this log, and its time there, s.
    #[must_use]
    pub fn at(&self, ticked: &Ticked) -> (u64, f64) {
        let reading = &ticked.sample.reading;
        let (first_tick, first_s) = self.first.unwrap_or((reading.tick, reading.time_s));
        (reading.tick - first_tick, reading.time_s - first_s)
    }

    /// Records an event, whose time counts from the first sample.
    pub fn event(&mut self, time_s: f64, kind: &str, text: String) {
        let since = time_s - self.first.map_or(time_s, |(_, first_s)| first_s);
        // A writer that has ended is seen at the tick.
        let _ = self.recorder.event(since, kind, text);
    }

    /// Closes the log.
    ///
    /// # Errors
    /// A log that could not be written.
    pub fn finish(mut self) -> Result<Finished, Failure> {
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
