//! The boundaries that were found. The keys are a contract of the command line.

use crate::document::failure::Failure;
use crate::judge::settling::Criterion;
use crate::question::asked_device::AskedDevice;
use serde::{Serialize, Serializer};

/// The result. The keys are a contract of the command line.
#[derive(Debug, Serialize)]
pub struct ZWidthReport {
    /// Device.
    pub device: String,
    /// Its mass, damping, hand and sample time.
    #[serde(flatten)]
    pub asked: AskedDevice,
    /// δ = bT/m of the device.
    pub delta: f64,
    /// Operator.
    pub scheme: String,
    /// By which rule walls were judged.
    pub criterion: Criterion,
    /// Speed at which the device hit them, m/s.
    pub impact_m_per_s: f64,
    /// Constant push, N.
    pub push_n: f64,
    /// Largest α that was looked at: a point this high is a bound of the search, not of the device.
    pub alpha_searched: f64,
    /// One entry an order.
    pub orders: Vec<OrderBoundary>,
    /// Runs made.
    pub runs: u64,
    /// Points where trial and analysis disagree by more than 5 % of the wall.
    pub disagreements: usize,
    /// Why the search ended early; null if it did not. The points that are there are whole.
    #[serde(serialize_with = "in_words")]
    pub ended_early: Option<Failure>,
}

fn in_words<S: Serializer>(failure: &Option<Failure>, to: S) -> Result<S::Ok, S::Error> {
    failure.as_ref().map(ToString::to_string).serialize(to)
}

/// The boundary of one order.
#[derive(Clone, Debug, Serialize)]
pub struct OrderBoundary {
    /// μ.
    pub order: f64,
    /// Unit of the dissipation.
    pub dissipation_unit: &'static str,
    /// Unit of the stiffness.
    pub stiffness_max_unit: &'static str,
    /// The largest stable stiffness for each dissipation; dissipations without one are left out.
    pub boundary: Vec<BoundaryPoint>,
    /// Outline of the stable region by the analysis, as (β, α); empty if it has none.
    #[serde(skip)]
    pub outline: Vec<(f64, f64)>,
    /// N/m of α = 1 and N·s^μ/m of β = 1.
    #[serde(skip)]
    pub units: (f64, f64),
}

/// One point of a boundary.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BoundaryPoint {
    /// B, N·s^μ/m.
    pub dissipation: f64,
    /// Largest stable K, N/m.
    pub stiffness_max: f64,
    /// K·T²/m.
    pub alpha: f64,
    /// B·T^(2−μ)/m.
    pub beta: f64,
    /// The largest stable K for this B by the analysis, N/m; null if it knows none.
    pub analysis_stiffness_n_per_m: Option<f64>,
    /// True if the analysis calls this wall (its K, or K and B together) stable made 5 % weaker and unstable
    /// made 5 % stronger; null if the search ended before, or the analysis does not know such a device.
    pub analysis_agrees: Option<bool>,
    /// The K up to which friction alone holds the device still, N/m; null without friction, and if it holds
    /// nothing beyond `stiffness_max`.
    pub held_by_friction_up_to_n_per_m: Option<f64>,
}

/// A row of the table of all points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BoundaryRow {
    /// μ.
    pub order: f64,
    /// B.
    pub dissipation_n_s_mu_per_m: f64,
    /// Largest stable K.
    pub stiffness_max_n_per_m: f64,
    /// K·T²/m.
    pub alpha: f64,
    /// B·T^(2−μ)/m.
    pub beta: f64,
    /// By the analysis.
    pub analysis_stiffness_n_per_m: Option<f64>,
    /// By friction alone.
    pub held_by_friction_up_to_n_per_m: Option<f64>,
}

impl ZWidthReport {
    /// All points as rows of a table.
    pub fn rows(&self) -> impl Iterator<Item = BoundaryRow> {
        self.orders.iter().flat_map(|order| {
            order.boundary.iter().map(|point| BoundaryRow {
                order: order.order,
                dissipation_n_s_mu_per_m: point.dissipation,
                stiffness_max_n_per_m: point.stiffness_max,
                alpha: point.alpha,
                beta: point.beta,
                analysis_stiffness_n_per_m: point.analysis_stiffness_n_per_m,
                held_by_friction_up_to_n_per_m: point.held_by_friction_up_to_n_per_m,
            })
        })
    }

    /// True if there is a point to draw.
    #[must_use]
    pub fn has_points(&self) -> bool {
        self.orders.iter().any(|order| !order.boundary.is_empty())
    }
}
