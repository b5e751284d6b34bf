//! What a wall experiment reports.

use super::Settling;
use crate::experiment::report::{RunReport, Summary};
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
    /// Commanded force against the full history of the position really recorded, as a share of the
    /// largest force. Null where the safety chain limited it, or for a one-sided wall.
    pub max_relative_error: Option<f64>,
    /// What stood for the full history; see the report of a relaxation.
    pub reference_tolerance: Option<f64>,
    /// The deflection against its closed form, push/(K + k). Null for an unstable wall.
    pub closed_form_error: Option<f64>,
    /// Whether and where it came to rest.
    #[serde(flatten)]
    pub settling: Settling,
    /// K, N/m.
    pub stiffness_n_per_m: f64,
    /// B, N·s^μ/m.
    pub dissipation_n_s_mu_per_m: f64,
}

impl Summary for WallReport {
    fn run(&self) -> &RunReport {
        &self.run
    }
}
