//! The flight recorder: what happened around a fault, in a log of its own beside that of the run.
//!
//! ```text
//! every tick ─▶ last 1000 ─┐
//! fault                    ├─▶ NAME-fault.mcap: ticks as in the run's log, one event, metadata "fault"
//! every tick ─▶ next 100 ──┘
//! the device's own recorder ─▶ ticks that the line lost
//! ```
//! Kept in memory, so that it is there even when the disk was slower than the loop.

use haptic_log::record::{Leftover, LogWriter, RecordError, StartTime};
use haptic_message::{EventMessage, TickMessage};
use std::{
    collections::{BTreeMap, VecDeque},
    path::Path,
};

/// Ticks kept from before a fault, the one that it latched in included.
const BEFORE: usize = 1000;
/// Ticks kept from after it.
pub(crate) const AFTER: u64 = 100;

/// Name of the metadata record that says what the fault was.
const FAULT: &str = "fault";

/// A fault, as it is known here.
#[derive(Debug, PartialEq)]
pub(crate) struct FaultSeen {
    /// Its code, as on the wire.
    pub code: u8,
    pub text: String,
    /// The tick in which it latched.
    pub tick: u64,
    pub time_s: f64,
}

/// The run that a fault ended, for the log of the fault.
#[derive(Debug)]
pub(crate) struct RunOfFault<'a> {
    pub log: &'a Path,
    pub experiment: BTreeMap<String, String>,
    pub started: Option<StartTime>,
}

/// Keeps the last ticks, and the first after a fault.
#[derive(Debug)]
pub(crate) struct FaultRecorder {
    ticks: VecDeque<TickMessage>,
    fault: Option<FaultSeen>,
    /// Ticks after that of the fault.
    after: u64,
    /// Ticks that only the device's own recorder had.
    filled: Vec<u64>,
}

impl Default for FaultRecorder {
    /// Empty; never allocates while it takes in ticks.
    fn default() -> Self {
        Self {
            ticks: VecDeque::with_capacity(BEFORE + AFTER as usize),
            fault: None,
            after: 0,
            filled: Vec::new(),
        }
    }
}

impl FaultRecorder {
    /// Takes in a tick. Once a fault has latched it takes 100 more, then none.
    pub(crate) fn tick(&mut self, tick: &TickMessage) {
        if self.is_full() {
            return;
        }
        match &self.fault {
            None if self.ticks.len() == BEFORE => {
                self.ticks.pop_front();
            }
            Some(fault) if tick.tick > fault.tick => self.after += 1,
            None | Some(_) => {}
        }
        self.ticks.push_back(*tick);
    }

    /// A fault has latched; the first counts.
    pub(crate) fn latch(&mut self, fault: FaultSeen) {
        // The news may come later than ticks that followed it.
        let behind = self.ticks.iter().rev();
        let behind = behind.take_while(|message| message.tick > fault.tick);
        if self.fault.is_none() {
            self.after = behind.count() as u64;
            self.fault = Some(fault);
        }
    }

    /// The fault, if one has latched.
    pub(crate) const fn fault(&self) -> Option<&FaultSeen> {
        self.fault.as_ref()
    }

    /// True if a fault has latched and all that is kept after it is there.
    pub(crate) const fn is_full(&self) -> bool {
        self.fault.is_some() && self.after >= AFTER
    }

    /// Adds what the device's own recorder has kept of this run and the line has lost.
    pub(crate) fn fill(&mut self, kept: impl IntoIterator<Item = TickMessage>) {
        let known: BTreeMap<u64, TickMessage> =
            self.ticks.iter().map(|tick| (tick.tick, *tick)).collect();
        let mut all = known.clone();
        for tick in kept {
            all.entry(tick.tick).or_insert(tick);
        }
        // The usual number of samples, those nearest to the fault.
        let fault = self.fault.as_ref().map_or(u64::MAX, |fault| fault.tick);
        let after = all.split_off(&fault.saturating_add(1));
        let spare = all.len().saturating_sub(BEFORE);
        let all = all.into_iter().skip(spare);
        let all: BTreeMap<u64, TickMessage> =
            all.chain(after.into_iter().take(AFTER as usize)).collect();
        let new = all.keys().filter(|tick| !known.contains_key(tick));
        self.filled = new.copied().collect();
        self.ticks = all.into_values().collect();
    }

    /// Writes the log of a fault.
    pub(crate) fn write(
        &self,
        path: &Path,
        overwrite: bool,
        run: RunOfFault<'_>,
    ) -> Result<(), RecordError> {
        let Some(fault) = &self.fault else {
            return Ok(());
        };
        let mut log = LogWriter::create_with(path, Leftover::Keep, overwrite, None)?;
        log.metadata("experiment", run.experiment)?;
        if let Some(start) = run.started {
            log.starts_at(start)?;
        }
        log.metadata(FAULT, self.metadata(fault, run.log))?;
        let mut event = Some(EventMessage {
            time_s: fault.time_s,
            kind: FAULT.to_owned(),
            text: fault.text.clone(),
        });
        for message in &self.ticks {
            if message.tick > fault.tick
                && let Some(event) = event.take()
            {
                log.event(&event)?;
            }
            log.tick(message)?;
        }
        if let Some(event) = event {
            log.event(&event)?;
        }
        log.finish().map(drop)
    }

    fn metadata(&self, fault: &FaultSeen, run: &Path) -> BTreeMap<String, String> {
        let after = |message: &&TickMessage| message.tick > fault.tick;
        let after = self.ticks.iter().filter(after).count();
        let filled: Vec<String> = self.filled.iter().map(u64::to_string).collect();
        let pairs = self.ticks.iter().zip(self.ticks.iter().skip(1));
        let gaps = pairs.map(|(a, b)| b.tick.saturating_sub(a.tick).saturating_sub(1));
        let missing: u64 = gaps.sum();
        let run = run.file_name().unwrap_or_default().to_string_lossy();
        let entries = [
            ("code", fault.code.to_string()),
            ("text", fault.text.clone()),
            ("tick", fault.tick.to_string()),
            ("time_s", fault.time_s.to_string()),
            ("samples_before", (self.ticks.len() - after).to_string()),
            ("samples_after", after.to_string()),
            // As `log check` counts them: what neither the line brought nor the device still had.
            ("ticks_missing", missing.to_string()),
            ("ticks_from_device_recorder", filled.join(" ")),
            ("run", run.into_owned()),
        ];
        entries.map(|(key, value)| (key.to_owned(), value)).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_log::record::{Entry, LogReader};
    use testkit::{Folder, Tested};

    fn tick(tick: u64) -> TickMessage {
        TickMessage {
            tick,
            time_s: 1e-3 * tick as f64,
            ..TickMessage::at_rest(1)
        }
    }

    fn fault(tick: u64) -> FaultSeen {
        FaultSeen {
            code: 6,
            text: "the device left its workspace".to_owned(),
            tick,
            time_s: 1e-3 * tick as f64,
        }
    }

    fn ticks(recorder: &FaultRecorder) -> Vec<u64> {
        recorder.ticks.iter().map(|tick| tick.tick).collect()
    }

    #[test]
    fn a_thousand_ticks_before_a_fault_and_a_hundred_after_it_are_kept() {
        let mut recorder = FaultRecorder::default();
        (0..=5000).for_each(|n| recorder.tick(&tick(n)));
        assert!(recorder.fault().is_none() && !recorder.is_full());
        recorder.latch(fault(5000));
        recorder.latch(fault(7));
        assert_eq!(recorder.fault(), Some(&fault(5000)));
        (5001..6000).for_each(|n| recorder.tick(&tick(n)));
        assert!(recorder.is_full());
        assert_eq!(ticks(&recorder), (4001..=5100).collect::<Vec<_>>());
    }

    #[test]
    fn a_fault_that_is_heard_of_late_keeps_its_place() {
        let mut recorder = FaultRecorder::default();
        (0..=230).for_each(|n| recorder.tick(&tick(n)));
        recorder.latch(fault(200));
        (231..400).for_each(|n| recorder.tick(&tick(n)));
        assert_eq!(ticks(&recorder), (0..=300).collect::<Vec<_>>());
    }

    #[test]
    fn the_device_fills_what_the_line_lost_and_changes_nothing_else() {
        let mut recorder = FaultRecorder::default();
        let lost = [3, 4, 9];
        let came = (0..12).filter(|n| !lost.contains(n));
        came.for_each(|n| recorder.tick(&tick(n)));
        recorder.latch(fault(11));
        let device = (2..15).map(|n| TickMessage {
            commanded_force_n: 1.0.into(),
            ..tick(n)
        });
        recorder.fill(device);
        assert_eq!(ticks(&recorder), (0..15).collect::<Vec<_>>());
        assert_eq!(recorder.filled, [3, 4, 9, 12, 13, 14]);
        let from_device = (recorder.ticks.iter())
            .filter(|tick| tick.commanded_force_n == haptic_message::PerAxis::from(1.0));
        assert_eq!(from_device.count(), 6);
    }

    #[test]
    fn what_the_device_adds_makes_the_log_no_longer() {
        let mut recorder = FaultRecorder::default();
        let lost = 1990..2010;
        let came = (0..3000).filter(|n| !lost.contains(n));
        came.for_each(|n| {
            recorder.tick(&tick(n));
            if n == 2010 {
                recorder.latch(fault(2000));
            }
        });
        recorder.fill((1950..2025).map(tick));
        assert_eq!(ticks(&recorder), (1001..=2100).collect::<Vec<_>>());
        assert_eq!(recorder.filled, lost.collect::<Vec<_>>());
    }

    #[test]
    fn its_log_says_what_happened_and_is_never_written_over() -> Tested {
        let folder = Folder::empty();
        let path = folder.join("run-fault.mcap");
        let run = folder.join("run.mcap");
        let mut recorder = FaultRecorder::default();
        (0..50).for_each(|n| recorder.tick(&tick(n)));
        let write = |recorder: &FaultRecorder, overwrite| {
            let run = RunOfFault {
                log: &run,
                experiment: BTreeMap::new(),
                started: None,
            };
            recorder.write(&path, overwrite, run)
        };
        write(&recorder, false)?;
        assert!(!path.exists());
        recorder.latch(fault(40));
        write(&recorder, false)?;
        write(&recorder, false).expect_err("it exists");
        write(&recorder, true)?;
        let entries: Vec<Entry> = LogReader::open(&path)?.collect::<Result<_, _>>()?;
        let index = |wanted: fn(&Entry) -> bool| entries.iter().position(wanted).expect("there");
        // The event lies between the ticks 40 and 41.
        let event = index(|entry| matches!(entry, Entry::Event(_)));
        assert_eq!(entries[event - 1], Entry::Tick(tick(40)));
        assert_eq!(entries[event + 1], Entry::Tick(tick(41)));
        let Entry::Metadata(record) = &entries
            [index(|entry| matches!(entry, Entry::Metadata(record) if record.name == FAULT))]
        else {
            panic!("{entries:?}");
        };
        for (key, value) in [
            ("code", "6"),
            ("tick", "40"),
            ("samples_before", "41"),
            ("samples_after", "9"),
            ("ticks_missing", "0"),
            ("run", "run.mcap"),
        ] {
            assert_eq!(record.values[key], value, "{key}");
        }
        Ok(())
    }
}
