//! Report of a wall experiment.

use crate::Settling;
use crate::report::{Errors, RunReport, Summary};
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
    /// Of the run.
    #[serde(flatten)]
    pub run: RunReport,
    /// The two errors: the commanded force against the full history, as a share of the largest force, not for a
    /// one-sided wall or a limited force; the mean deflection against push/(K + k), not for an unstable wall.
    #[serde(flatten)]
    pub errors: Errors,
    /// Tolerance of the reference for the full history; see the report of a relaxation.
    pub reference_tolerance: Option<f64>,
    /// Rest of the device: if it came to rest, and where.
    #[serde(flatten)]
    pub settling: Settling,
    /// True if trial and analysis come to the same verdict; null if one of them has none.
    pub analysis_agrees: Option<bool>,
    /// K, N/m.
    pub stiffness_n_per_m: f64,
    /// B, N·s^μ/m.
    pub dissipation_n_s_mu_per_m: f64,
}

impl WallReport {
    /// Stable by the trial and by the analysis.
    #[must_use]
    pub fn stable_by_both(&self) -> bool {
        self.settling.stable && self.analysis_agrees == Some(true)
    }
}

impl Summary for WallReport {
    fn run(&self) -> &RunReport {
        &self.run
    }

    fn run_mut(&mut self) -> &mut RunReport {
        &mut self.run
    }
}
