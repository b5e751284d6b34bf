//! Report of a wall experiment.

use crate::pushed::TrialReport;
use crate::report::{RunReport, Summary};
use serde::Serialize;

/// The result. The mean deflection is compared with push/(K + k); the force of a one-sided wall is not compared.
#[derive(Clone, Debug, Serialize)]
pub struct WallReport {
    /// K, N/m.
    pub stiffness_n_per_m: f64,
    /// B, N·s^μ/m.
    pub dissipation_n_s_mu_per_m: f64,
    /// Of the trial.
    #[serde(flatten)]
    pub trial: TrialReport,
}

impl Summary for WallReport {
    fn run(&self) -> &RunReport {
        &self.trial.run
    }

    fn run_mut(&mut self) -> &mut RunReport {
        &mut self.trial.run
    }
}
