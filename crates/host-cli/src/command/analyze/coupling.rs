//! `analyze coupling`: the damping that a virtual coupler needs.

use super::arguments::{HORIZON, refused};
use crate::keys;
use crate::options::Options;
use crate::output::Output;
use clap::Args;
use fracdiff::{Scheme, Seconds};
use haptic_analysis::{Coupler, LeastDamping, LoopOperator};
use haptic_experiment::Failure;
use haptic_experiment::parameters::analysis::{ANALYSED_DAMPING, ANALYSED_SAMPLE_TIME};
use haptic_experiment::parameters::{COUPLER_DISSIPATION, COUPLER_STIFFNESS};
use serde::Serialize;

/// Arguments of `analyze coupling`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli analyze coupling --order 0.75 --coupler-stiffness 1 --coupler-dissipation 200 \
                  --sample-time 1ms --damping 0.5"
)]
pub struct CouplingArguments {
    #[command(flatten)]
    options: Options<keys::Coupling>,
}

/// Result of `analyze coupling`.
#[derive(Serialize)]
struct Coupling {
    order: f64,
    scheme: String,
    sample_time_s: f64,
    coupler_stiffness_n_s_per_m: f64,
    coupler_dissipation_n_s_1_minus_mu_per_m: f64,
    /// b as given; null without one.
    damping_n_s_per_m: Option<f64>,
    /// Least b by Llewellyn's criterion, N·s/m; null if no damping is enough.
    required_damping: Option<f64>,
    required_damping_unit: &'static str,
    /// By Corollary 2, N·s/m.
    corollary_damping: f64,
    corollary_damping_unit: &'static str,
    worst_theta: f64,
    /// True if the given b is enough; null without one, unless none is.
    passive: Option<bool>,
    passive_reason: Option<&'static str>,
    reason: Option<String>,
}

impl CouplingArguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let given = self.options.given()?;
        let (mu, scheme) = (given.order()?, given.scheme()?);
        let sample_time_s = given.needed(&ANALYSED_SAMPLE_TIME)?;
        let stiffness = given.needed(&COUPLER_STIFFNESS)?;
        let dissipation = given.needed(&COUPLER_DISSIPATION)?;
        let exact = Coupler::exact(mu, sample_time_s, stiffness, dissipation).map_err(refused)?;
        let operator =
            LoopOperator::new(scheme, mu, Seconds(sample_time_s), HORIZON).map_err(refused)?;
        let coupler = if scheme == Scheme::Exact {
            exact
        } else {
            exact.with_operator(&operator, operator.memory())
        };
        let damping = given.number(&ANALYSED_DAMPING);
        let (required, worst_theta, reason) = match coupler.least_damping().map_err(refused)? {
            LeastDamping::Enough {
                damping_n_s_per_m,
                worst_theta,
            } => (Some(damping_n_s_per_m), worst_theta, None),
            LeastDamping::NoneIsEnough { theta } => (
                None,
                theta,
                Some(format!(
                    "the coupler itself is active at theta = {theta:.6}: no damping of the device makes the port passive"
                )),
            ),
        };
        let passive = match (required, damping) {
            (None, _) => Some(false),
            (Some(_), Some(b)) => Some(coupler.passive(b).map_err(refused)?),
            (Some(_), None) => None,
        };
        let result = Coupling {
            order: mu.get(),
            scheme: scheme.to_string(),
            sample_time_s,
            coupler_stiffness_n_s_per_m: stiffness,
            coupler_dissipation_n_s_1_minus_mu_per_m: dissipation,
            damping_n_s_per_m: damping,
            required_damping: required,
            required_damping_unit: "N·s/m",
            corollary_damping: coupler.corollary_damping(),
            corollary_damping_unit: "N·s/m",
            worst_theta,
            passive,
            passive_reason: passive.is_none().then_some("give --damping to know"),
            reason,
        };
        output.report(&result)
    }
}
