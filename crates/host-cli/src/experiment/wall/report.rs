//! What a wall experiment reports.

use super::Settling;
use crate::experiment::preflight::Verdict;
use crate::experiment::realtime::RealtimeSummary;
use crate::experiment::remote::LinkSummary;
use crate::experiment::report::{Ending, Summary, TickTimes};
use serde::Serialize;

/// The result. The keys are those of the other experiments where they have a meaning.
#[derive(Clone, Debug, Serialize)]
pub struct WallReport {
    /// No tissue: null.
    pub tissue: Option<String>,
    /// μ.
    pub order: f64,
    /// Operator.
    pub scheme: String,
    /// Device.
    pub device: String,
    /// Ticks in the log.
    pub samples: u64,
    /// Time of the last sample that counts, s.
    pub duration_s: f64,
    /// Largest magnitude of the commanded force, N.
    pub peak_force_n: f64,
    /// Force that the wall opposes to the push at the end, N.
    pub final_force_n: f64,
    /// Commanded force against the full history of the position really recorded, as a share of the
    /// largest force. Null where the safety chain limited it, or for a one-sided wall.
    pub max_relative_error: Option<f64>,
    /// The deflection against its closed form, push/(K + k). Null for an unstable wall.
    pub closed_form_error: Option<f64>,
    /// Time of a tick; null in a loop on a device, which does not tell.
    pub tick_ns: Option<TickTimes>,
    /// Ticks more than one sample time late; 0 in virtual time.
    pub missed_deadlines: u64,
    /// Where the time went in a run by the clock of this machine; null in another.
    pub realtime: Option<RealtimeSummary>,
    /// The log.
    pub log: String,
    /// The picture (PNG; an SVG lies beside it), unless the run was cut short.
    pub figure: Option<String>,
    /// The samples, unless the run was cut short.
    pub csv: Option<String>,
    /// Whether and where it came to rest.
    #[serde(flatten)]
    pub settling: Settling,
    /// K, N/m.
    pub stiffness_n_per_m: f64,
    /// B, N·s^μ/m.
    pub dissipation_n_s_mu_per_m: f64,
    /// T, s.
    pub sample_time_s: f64,
    /// Samples in which the safety chain limited the force.
    pub limited_samples: u64,
    /// Samples and events that did not reach the log.
    pub dropped_samples: u64,
    /// Why the run ended early; null if it did not.
    pub ended_early: Option<String>,
    /// What the link to the device counted; null without one.
    pub link: Option<LinkSummary>,
    /// What the analysis said before the run; null if it was not asked.
    pub preflight: Option<Verdict>,
    /// The log of the fault, 1000 samples before it and 100 after; null without a fault.
    pub fault_log: Option<String>,
    /// The link was lost in the middle of the run.
    #[serde(skip)]
    pub link_lost: bool,
    /// What a user should know about these numbers, a sentence each.
    pub warnings: Vec<String>,
}

impl Summary for WallReport {
    fn ending(&self) -> Ending<'_> {
        Ending {
            warnings: &self.warnings,
            ended_early: self.ended_early.as_deref(),
            duration_s: self.duration_s,
            dropped_samples: self.dropped_samples,
            link_lost: self.link_lost,
            log: &self.log,
        }
    }
}
