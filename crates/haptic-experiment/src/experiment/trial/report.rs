//! Report of a trial: what that of a wall and that of a coupler share.

use crate::Settling;
use crate::judge::report::{Errors, RunReport};
use serde::Serialize;

/// The result of a trial. The keys are those of the other experiments where they have a meaning.
#[derive(Clone, Debug, Serialize)]
pub struct TrialReport {
    /// No tissue: null.
    pub tissue: Option<String>,
    /// μ.
    pub order: f64,
    /// Operator.
    pub scheme: String,
    /// Of the run.
    #[serde(flatten)]
    pub run: RunReport,
    /// Rest of the device: if it came to rest, and where.
    #[serde(flatten)]
    pub settling: Settling,
    /// True if trial and analysis come to the same verdict; null if one of them has none.
    pub analysis_agrees: Option<bool>,
    /// The two errors: the commanded force against the full history, as a share of the largest force, not for a limited one;
    /// the mean deflection against the place of rest, not without such a place and not for an unstable trial.
    #[serde(flatten)]
    pub errors: Errors,
    /// Tolerance of the reference for the full history; see the report of a relaxation.
    pub reference_tolerance: Option<f64>,
}

impl TrialReport {
    /// Stable by the trial and by the analysis.
    #[must_use]
    pub fn stable_by_both(&self) -> bool {
        self.settling.stable && self.analysis_agrees == Some(true)
    }
}
