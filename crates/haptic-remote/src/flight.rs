//! The device's flight recorder: the samples around a fault.

use crate::tick::Tick;
use haptic_link::{Field, Flight, Refusal, Report};
use heapless::HistoryBuf;

/// Samples that the flight recorder keeps.
pub const FLIGHT_SAMPLES: usize = 96;
/// Of these, samples after the fault.
const AFTER: u16 = 24;

/// Keeps the newest samples until a fault latches and some more have come; then it stands still until it is
/// cleared.
#[derive(Debug)]
pub(super) struct FlightRecorder<const D: usize> {
    samples: HistoryBuf<Tick<D>, FLIGHT_SAMPLES>,
    /// Samples still to be taken: all until a fault latches.
    left: Option<u16>,
}

impl<const D: usize> FlightRecorder<D> {
    /// Empty.
    pub(super) const fn new() -> Self {
        Self {
            samples: HistoryBuf::new(),
            left: None,
        }
    }

    pub(super) fn take(&mut self, sample: Tick<D>) {
        match &mut self.left {
            None => self.samples.write(sample),
            Some(0) => {}
            Some(left) => {
                *left -= 1;
                self.samples.write(sample);
            }
        }
    }

    /// A fault has latched.
    pub(super) fn fault(&mut self) {
        self.left = Some(AFTER);
    }

    /// Begins anew: what led to the last fault is no part of what comes.
    pub(super) fn clear(&mut self) {
        self.left = None;
        self.samples.clear();
    }

    /// A sample, 0 the oldest. There is none before a fault has latched.
    pub(super) fn read(&self, index: u16) -> Result<Report, Refusal> {
        let count = match self.left {
            Some(_) => self.samples.len() as u16,
            None => 0,
        };
        let mut kept = self.samples.oldest_ordered().take(usize::from(count));
        let sample = match kept.nth(usize::from(index)) {
            Some(sample) => *sample,
            None if index == 0 => Tick::NONE,
            None => {
                return Err(Refusal::Range {
                    field: Field::FlightIndex,
                    value: f32::from(index),
                    least: 0.0,
                    most: f32::from(count.saturating_sub(1)),
                });
            }
        };
        Ok(Report::Flight(Flight {
            index,
            count,
            sample: sample.sample(),
        }))
    }
}
