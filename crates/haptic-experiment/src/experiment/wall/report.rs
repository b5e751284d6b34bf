//! Report of a wall experiment.

use crate::experiment::trial::TrialReport;
use crate::judge::curves::Origin;
use crate::judge::report::{RunReport, Summary};
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

/// The trial of a wall.
#[derive(Clone, Debug, PartialEq)]
pub struct WallCurves {
    /// One line: wall, device, operator, verdict.
    pub subtitle: String,
    /// Origin of the force.
    pub origin: Origin,
    /// Place of rest, m; `None` where no spring holds the push.
    pub expected_deflection_m: Option<f64>,
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Position, m.
    pub position_m: Vec<f64>,
    /// Force of the wall, opposed to the motion, N.
    pub force_n: Vec<f64>,
}
