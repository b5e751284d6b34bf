//! Report of a teleoperation.

use crate::judge::report::{RunReport, Summary};
use serde::Serialize;

/// How a teleoperation went.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TeleoperationVerdict {
    /// Both forces stayed within their limits, the line gave no energy, and the forces that were held from sample to sample gave
    /// no more than the damping of the devices took.
    Passive,
    /// Both forces stayed within their limits, but the line gave energy.
    GaveEnergy,
    /// The line gave none, but the forces held over a sample gave the devices more than their damping took.
    HeldForcesGaveEnergy,
    /// A force was at its limit in more than 1 % of the samples.
    Saturated,
    /// A side heard nothing for too long.
    Silent,
    /// It did not reach its end.
    Unfinished,
}

impl TeleoperationVerdict {
    /// In words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Passive => "the line gave no energy, held forces no more than damping took",
            Self::GaveEnergy => "the line gave energy",
            Self::HeldForcesGaveEnergy => {
                "held forces gave more than the damping of the devices took"
            }
            Self::Saturated => "a force was at its limit",
            Self::Silent => "a side heard nothing for too long",
            Self::Unfinished => "the run did not finish",
        }
    }
}

/// What the hand felt at a frequency, as force for a place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FeltAt {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Of the master in the hand, from the run, N/m.
    pub felt_n_per_m: f64,
    /// Its phase, °: 0 a spring, 90 a damper, 180 a mass.
    pub felt_degrees: f64,
    /// Of the remote place, from the run, N/m.
    pub touched_n_per_m: f64,
    /// Its phase, °.
    pub touched_degrees: f64,
    /// Of the remote place in closed form, N/m; null where it is not linear.
    pub tissue_n_per_m: Option<f64>,
    /// Its phase, °.
    pub tissue_degrees: Option<f64>,
    /// What the formula says is felt of it, N/m; null where there is none, as of time-domain passivity.
    pub formula_n_per_m: Option<f64>,
    /// Its phase, °.
    pub formula_degrees: Option<f64>,
    /// The run against the formula, dB.
    pub off_formula_db: Option<f64>,
    /// The run against the tissue, dB: 0 would be transparent.
    pub off_tissue_db: Option<f64>,
}

/// Messages of one way of the line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LineCounts {
    /// Sent.
    pub sent: u64,
    /// Lost in the line.
    pub lost: u64,
    /// Doubled by the line.
    pub doubled: u64,
    /// Come out of it.
    pub delivered: u64,
    /// Not acted on, because a later one was there before.
    pub stale: u64,
    /// Not acted on, because the same one was there before.
    pub duplicate: u64,
}

/// The result. The keys are those of a wall where they have a meaning.
#[derive(Clone, Debug, Serialize)]
pub struct TeleoperationReport {
    /// The remote place.
    pub place: String,
    /// Name of the architecture.
    pub architecture: String,
    /// Of the run; its force is that on the master.
    #[serde(flatten)]
    pub run: RunReport,
    /// Verdict.
    pub verdict: TeleoperationVerdict,
    /// The verdict in words.
    pub verdict_reason: &'static str,
    /// Delay of the line, s.
    pub line_delay_s: f64,
    /// Most that the line had given at any time, J; at most rounding if it is passive.
    pub given_most_j: f64,
    /// Taken by the line in the end, J.
    pub taken_j: f64,
    /// Most that held forces had given beyond what the damping of both devices had taken, J: above 0 the devices bear the
    /// hold no more.
    pub beyond_damping_most_j: f64,
    /// Largest force on the master, N.
    pub master_peak_n: f64,
    /// Largest force on the slave, N.
    pub slave_peak_n: f64,
    /// Master to slave.
    pub forth: LineCounts,
    /// Slave to master.
    pub back: LineCounts,
    /// True if Llewellyn's conditions hold at every frequency: stable with any passive hand and place. Null for time-domain
    /// passivity, which is no linear law and has no such conditions.
    pub absolutely_stable: Option<bool>,
    /// Least ratio of Llewellyn's conditions, at least 1 for that.
    pub least_ratio: Option<f64>,
    /// The frequency of it, Hz.
    pub worst_hz: Option<f64>,
    /// What was felt, frequency by frequency; empty for a run that was cut short.
    pub felt: Vec<FeltAt>,
    /// Largest `off_formula_db`; null without formula.
    pub off_formula_most_db: Option<f64>,
}

impl Summary for TeleoperationReport {
    fn run(&self) -> &RunReport {
        &self.run
    }

    fn run_mut(&mut self) -> &mut RunReport {
        &mut self.run
    }
}
