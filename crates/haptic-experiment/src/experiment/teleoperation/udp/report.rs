//! How a side ended, its report, and the terms on which it meets the other.

use crate::document::failure::Failure;
use crate::document::parameters::{PATIENCE, SKIPPED_SHARE};
use crate::experiment::teleoperation::judge::SATURATED_SHARE;
use crate::experiment::teleoperation::report::TeleoperationVerdict;
use crate::experiment::teleoperation::specification::TeleoperationExperiment;
use fracdiff::parameter::Shown;
use serde::Serialize;
use std::time::Duration;

/// Why a side ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FarEnd {
    /// Its time was over.
    Done,
    /// Its time was over, but the clock had skipped more ticks than a result may miss.
    Late,
    /// The other side said goodbye.
    OtherLeft,
    /// The other side was silent for too long.
    Silent,
    /// Somebody asked for it.
    Interrupted,
    /// The safety chain latched a fault.
    Fault,
}

/// Terms on which a side meets the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Terms {
    /// Time to wait for the other side, above 0.
    pub patience: Duration,
    /// Largest share of the ticks that may be skipped, 0 to 1; more of them is no result.
    pub skipped_most: f64,
}

impl Terms {
    pub(super) fn checked(self) -> Result<Self, Failure> {
        if self.patience.is_zero() {
            return Err(Failure::bad_input(format_args!(
                "patience 0 s is no time to wait for the other side: give a {PATIENCE} above 0, as 60s"
            )));
        }
        if !(0.0..=1.0).contains(&self.skipped_most) {
            return Err(Failure::bad_input(format_args!(
                "{SKIPPED_SHARE} {} is not in [0, 1]: give a share of the ticks, as 0.1",
                Shown(self.skipped_most)
            )));
        }
        Ok(self)
    }

    /// The same end, unless more ticks were skipped than a result may miss.
    pub(super) fn judge(self, ended: FarEnd, skipped: u64, ticks: u64) -> FarEnd {
        let whole = matches!(ended, FarEnd::Done | FarEnd::OtherLeft);
        let late = skipped as f64 > self.skipped_most * ticks as f64;
        if whole && late { FarEnd::Late } else { ended }
    }
}

/// The report of a side.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FarReport {
    /// master or slave.
    pub side: String,
    /// Name of the architecture.
    pub architecture: String,
    /// Address of the other side.
    pub peer: String,
    /// Why it ended.
    pub ended: FarEnd,
    /// Ticks of its device.
    pub ticks: u64,
    /// Time of its device at the end, s.
    pub duration_s: f64,
    /// Ticks that the clock had to skip.
    pub skipped: u64,
    /// Messages sent.
    pub sent: u64,
    /// Messages that were acted on.
    pub acted_on: u64,
    /// Numbers that were passed over: lost, or late.
    pub missing: u32,
    /// Messages after a later one: refused.
    pub stale: u32,
    /// Messages that came twice: refused.
    pub duplicate: u32,
    /// Datagrams that were damaged or no messages.
    pub corrupt: u32,
    /// Datagrams from elsewhere or of another connection.
    pub foreign: u64,
    /// Ticks whose force was at its limit.
    pub ticks_at_limit: u64,
    /// Largest force, N.
    pub peak_force_n: f64,
    /// Force at the end, N: 0.
    pub final_force_n: f64,
    /// Energy that the line gave to this device, J; below 0 it took some.
    pub given_j: f64,
    /// Device time from the last message to a force of zero, s; null unless the other side fell silent.
    pub silent_to_zero_s: Option<f64>,
    /// Most of that: silence, stop time and two samples, s.
    pub silent_to_zero_most_s: f64,
    /// The log, or the first of its files.
    pub log: String,
    /// All files of the log, in order.
    pub logs: Vec<String>,
    /// The samples, unless the run was cut short.
    pub csv: Option<String>,
    /// The picture, unless the run was cut short.
    pub figure: Option<String>,
    /// The log of the fault; null without one.
    pub fault_log: Option<String>,
    /// Samples and events that did not reach the log.
    pub dropped_samples: u64,
    /// Why there is no table of a run that reached its end.
    #[serde(skip)]
    pub unwritten: Option<String>,
}

impl FarReport {
    /// True if a force was at its limit in more of the ticks than a passive run may have.
    pub(super) fn is_saturated(&self) -> bool {
        self.ticks_at_limit as f64 > SATURATED_SHARE * self.ticks as f64
    }

    /// What speaks against a passive run of this experiment, as far as one side sees it: its force was at the limit, or the other side
    /// left longer before the end than it may be silent. Energy of the line is that of both sides together: the sum of their `given_j`.
    #[must_use]
    pub fn against_passive(
        &self,
        experiment: &TeleoperationExperiment,
    ) -> Option<TeleoperationVerdict> {
        let left_s = experiment.duration_s - self.duration_s;
        if self.is_saturated() {
            Some(TeleoperationVerdict::Saturated)
        } else if self.ended == FarEnd::OtherLeft && left_s > experiment.silence_s {
            Some(TeleoperationVerdict::Unfinished)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_that_skipped_too_many_ticks_is_no_result() {
        let terms = Terms {
            patience: Duration::from_secs(1),
            skipped_most: 0.1,
        };
        for (ended, skipped, want) in [
            (FarEnd::Done, 100, FarEnd::Done),
            (FarEnd::Done, 101, FarEnd::Late),
            (FarEnd::OtherLeft, 550, FarEnd::Late),
            // Why it ended early says more.
            (FarEnd::Silent, 550, FarEnd::Silent),
            (FarEnd::Interrupted, 550, FarEnd::Interrupted),
        ] {
            assert_eq!(terms.judge(ended, skipped, 1000), want, "{skipped}");
        }
        let any = Terms {
            skipped_most: 1.0,
            ..terms
        };
        assert_eq!(any.judge(FarEnd::Done, 999, 1000), FarEnd::Done);
        let impatient = Terms {
            patience: Duration::ZERO,
            ..terms
        };
        assert!(impatient.checked().is_err());
        let wild = Terms {
            skipped_most: f64::NAN,
            ..terms
        };
        assert!(wild.checked().is_err());
    }
}
