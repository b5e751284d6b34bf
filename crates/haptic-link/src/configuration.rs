//! Everything that can be set on a device but the coefficients, in one structure.

use crate::coefficients::{OperatorForm, OperatorShape};
use crate::limits::Limits;
use crate::loop_mode::LoopMode;
use crate::simulation::Simulation;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// The whole configuration but the coefficients. Applied in one transaction: stage this, stage the
/// blocks of coefficients, commit with the digest of both.
///
/// ```
/// use haptic_link::{CoefficientBlock, Configuration, OperatorForm, OperatorShape, block_count};
///
/// // 500 N/m and a backward difference: g and k₁ of D¹ at 1 kHz.
/// let taps = [1000.0_f32, -1000.0];
/// let configuration = Configuration {
///     stiffness_n_per_m: 500.0,
///     dissipation_n_s_mu_per_m: 2.0,
///     order: 1.0,
///     operator: OperatorShape { form: OperatorForm::Taps, integer: 0, count: 2 },
///     ..Configuration::PASSIVE
/// };
/// assert_eq!(block_count(configuration.operator.count), 1);
/// assert_eq!(CoefficientBlock::of(&taps, 0).values[..3], [1000.0, -1000.0, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Configuration {
    /// The side on which the loop runs.
    pub loop_mode: LoopMode,
    /// T, µs.
    #[serde(with = "postcard::fixint::le")]
    pub tick_period_us: u32,
    /// K, N/m.
    pub stiffness_n_per_m: f32,
    /// B, N·s^μ/m.
    pub dissipation_n_s_mu_per_m: f32,
    /// μ, for the record: the coefficients are what counts.
    pub order: f32,
    /// The environment begins at `surface_m` and pushes but never pulls.
    pub one_sided: bool,
    /// m.
    pub surface_m: f32,
    /// The operator's coefficients.
    pub operator: OperatorShape,
    /// Limits.
    pub limits: Limits,
    /// The plant of a simulated device.
    pub simulation: Simulation,
}

impl Configuration {
    /// No environment: zero force at 1 kHz, nothing simulated. What a device starts with.
    pub const PASSIVE: Self = Self {
        loop_mode: LoopMode::Device,
        tick_period_us: 1000,
        stiffness_n_per_m: 0.0,
        dissipation_n_s_mu_per_m: 0.0,
        order: 0.0,
        one_sided: false,
        surface_m: 0.0,
        operator: OperatorShape {
            form: OperatorForm::Taps,
            integer: 0,
            count: 1,
        },
        limits: Limits::DEFAULT,
        simulation: Simulation::REAL,
    };
}
