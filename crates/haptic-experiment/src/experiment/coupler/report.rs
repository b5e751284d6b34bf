//! Report of a coupler experiment.

use crate::experiment::trial::TrialReport;
use crate::judge::curves::Origin;
use crate::judge::report::{RunReport, Summary};
use serde::Serialize;

/// The result. The mean deflection is compared with the springs in series, not for a coupler that creeps.
#[derive(Clone, Debug, Serialize)]
pub struct CouplerReport {
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
    /// Of the trial.
    #[serde(flatten)]
    pub trial: TrialReport,
}

impl CouplerReport {
    /// Stable by the trial and by the analysis, and passed by Llewellyn.
    #[must_use]
    pub fn stable_by_all(&self) -> bool {
        let trial = &self.trial;
        let llewellyn = trial.run.preflight.and_then(|verdict| verdict.coupler);
        trial.stable_by_both() && llewellyn.is_some_and(|coupler| coupler.llewellyn)
    }
}

impl Summary for CouplerReport {
    fn run(&self) -> &RunReport {
        &self.trial.run
    }

    fn run_mut(&mut self) -> &mut RunReport {
        &mut self.trial.run
    }
}

/// The trial of a coupler.
#[derive(Clone, Debug, PartialEq)]
pub struct CouplerCurves {
    /// One line: coupler, object, device, operator, verdict.
    pub subtitle: String,
    /// Origin of the force.
    pub origin: Origin,
    /// Place of rest of the device, m; `None` where the coupler creeps or nothing holds the object.
    pub expected_deflection_m: Option<f64>,
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Position of the device, m.
    pub position_m: Vec<f64>,
    /// Place of the object, m.
    pub object_position_m: Vec<f64>,
    /// Force of the coupler, opposed to the motion of the device, N.
    pub force_n: Vec<f64>,
}
