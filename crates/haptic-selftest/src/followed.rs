//! A run of the self-test as its samples show it.

use haptic_link::FaultReport;
use haptic_loop::{Fault, Limiters};
use haptic_remote::Tick;

/// Samples of a run, forces that were sent, and the fault that ended it.
#[derive(Clone, Debug, Default)]
pub(super) struct Followed {
    /// In the order of their ticks.
    pub(super) samples: Vec<Tick>,
    /// Tick that a force answered, and the force, N.
    pub(super) sent: Vec<(u32, f32)>,
    /// The fault.
    pub(super) fault: Option<FaultReport>,
    /// The run has begun: what came before is none of it.
    pub(super) begun: bool,
    /// The run has ended otherwise.
    pub(super) ended: bool,
    /// No sample came for long, though the device answers: this machine or the line was held up, and the run was given up.
    pub(super) held_up: bool,
    /// Tick of the newest sample when the device had taken a stop.
    pub(super) stop_asked: Option<u32>,
}

impl Followed {
    /// Tick at which the fault latched: as reported, or, where the report was lost, that of the first sample of a chain
    /// in a fault.
    pub(super) fn fault_tick(&self) -> Option<u32> {
        let report = self.fault?;
        // A report that the host made of a keep-alive knows no time.
        let shown = || {
            let mut samples = self.samples.iter();
            samples.find(|sample| sample.limiters & Limiters::FAULT.bits() != 0)
        };
        match report.time_us {
            0 => shown().map(|sample| sample.tick),
            _ => Some(report.tick),
        }
    }

    /// The last force that the device took over before the fault: the tick that it answered, and the first sample that
    /// shows it.
    pub(super) fn last_taken(&self, fault_tick: u32) -> Option<(u32, Tick)> {
        let same = |a: f32, b: f32| a.to_bits() == b.to_bits();
        let before = self.samples.iter().rev();
        let wanted = (before.clone())
            .find(|sample| sample.tick <= fault_tick)?
            .environment_force_n[0];
        let (answered, _) = (self.sent.iter()).rfind(|(_, force)| same(*force, wanted))?;
        let shown = (self.samples.iter()).find(|sample| {
            sample.tick > *answered && same(sample.environment_force_n[0], wanted)
        })?;
        Some((*answered, *shown))
    }

    /// The fault that ended it, in words.
    pub(super) fn fault_in_words(&self) -> Option<String> {
        let code = self.fault?.status.fault;
        Some(match Fault::from_code(code) {
            Some(fault) => format!("fault {code}, {fault}"),
            None => format!("fault {code}"),
        })
    }

    /// The largest force, N.
    pub(super) fn largest_n(&self) -> f32 {
        let forces = self.samples.iter().map(|sample| sample.force_n[0].abs());
        // A force that is no number is the largest of all.
        forces.fold(0.0, |most, force| {
            if force.is_nan() || force > most {
                force
            } else {
                most
            }
        })
    }
}
