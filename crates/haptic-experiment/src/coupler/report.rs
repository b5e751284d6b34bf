//! Report of a coupler experiment.

use crate::Settling;
use crate::report::{Errors, RunReport, Summary};
use serde::Serialize;

/// The result. The keys are those of a wall where they have a meaning.
#[derive(Clone, Debug, Serialize)]
pub struct CouplerReport {
    /// No tissue: null.
    pub tissue: Option<String>,
    /// μ.
    pub order: f64,
    /// Operator.
    pub scheme: String,
    /// Of the run.
    #[serde(flatten)]
    pub run: RunReport,
    /// The two errors: the commanded force against the full history, as a share of the largest force, not for a limited
    /// force; the mean deflection against the springs in series, not for a coupler that creeps or is unstable.
    #[serde(flatten)]
    pub errors: Errors,
    /// Tolerance of the reference for the full history; see the report of a relaxation.
    pub reference_tolerance: Option<f64>,
    /// Rest of the device: if it came to rest, and where.
    #[serde(flatten)]
    pub settling: Settling,
    /// True if trial and analysis come to the same verdict; null if one of them has none.
    pub analysis_agrees: Option<bool>,
    /// `k_c`, N·s/m.
    pub coupler_stiffness_n_s_per_m: f64,
    /// `b_c`, N·s^(1−μ)/m.
    pub coupler_dissipation_n_s_1_minus_mu_per_m: f64,
    /// `m_o`, kg.
    pub object_mass_kg: f64,
    /// `b_o`, N·s/m.
    pub object_damping_n_s_per_m: f64,
    /// `k_o`, N/m.
    pub object_stiffness_n_per_m: f64,
    /// Place of the object at the end, m; null for a run that was cut short.
    pub object_position_m: Option<f64>,
}

impl CouplerReport {
    /// Stable by the trial and by the analysis, and passed by Llewellyn.
    #[must_use]
    pub fn stable_by_all(&self) -> bool {
        let llewellyn = self.run.preflight.and_then(|verdict| verdict.coupler);
        self.settling.stable
            && self.analysis_agrees == Some(true)
            && llewellyn.is_some_and(|coupler| coupler.llewellyn)
    }
}

impl Summary for CouplerReport {
    fn run(&self) -> &RunReport {
        &self.run
    }

    fn run_mut(&mut self) -> &mut RunReport {
        &mut self.run
    }
}
