//! `analyze passivity`: the damping that a wall needs to be passive.

use super::arguments::{Asked, Wall, refused, resolve};
use super::path::PathResult;
use crate::keys;
use crate::options::Options;
use crate::output::Output;
use clap::Args;
use haptic_analysis::{AnalysisError, Largest, OnePort};
use haptic_experiment::Failure;
use serde::Serialize;

/// Arguments of `analyze passivity`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli analyze passivity --order 0.5 --scheme muir:3 --mass 65g --damping 3.5 --sample-time 1ms --stiffness 3N/mm --dissipation 10"
)]
pub struct PassivityArguments {
    #[command(flatten)]
    options: Options<keys::Loop>,
}

/// Result of `analyze passivity`.
#[derive(Serialize)]
struct Passivity {
    order: f64,
    scheme: String,
    #[serde(flatten)]
    asked: Asked,
    alpha: f64,
    beta: f64,
    /// δ as given; null without one.
    delta: Option<f64>,
    #[serde(flatten)]
    path: PathResult,
    /// Least δ by Theorem 1 for the operator really used; passive above it.
    required_delta: f64,
    /// By Corollary 1, which holds for the exact operator without delay.
    corollary_delta: f64,
    worst_theta: f64,
    /// True if the given δ is enough; null without one.
    passive: Option<bool>,
    passive_reason: Option<&'static str>,
    /// α + βP(1) < 0: then no damping is enough.
    negative_at_rest: bool,
    /// Largest α that is passive with the given δ and β; null without a δ, or if none or any is.
    largest_alpha: Option<f64>,
    /// Largest β that is passive with the given δ and α; null likewise.
    largest_beta: Option<f64>,
    /// The same with units, where the loop was given with units.
    largest_stiffness_n_per_m: Option<f64>,
    largest_dissipation_n_s_mu_per_m: Option<f64>,
    required_damping_n_s_per_m: Option<f64>,
    worst_rad_s: Option<f64>,
}

impl PassivityArguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let resolved = resolve(&self.options.given()?, Wall::Needed)?;
        let parameters = resolved.parameters;
        let port = OnePort::new(&resolved.operator, resolved.order)
            .and_then(|port| port.through(resolved.path))
            .map_err(refused)?
            .with_memory(resolved.operator.memory());
        let required = port
            .required_delta(parameters.alpha, parameters.beta)
            .map_err(refused)?;
        let largest = |found: Result<Largest, AnalysisError>| match found.map_err(refused)? {
            Largest::Below { value, .. } => Ok::<_, Failure>(Some(value)),
            Largest::Any | Largest::Empty => Ok(None),
        };
        let (mut largest_alpha, mut largest_beta) = (None, None);
        if resolved.delta_given {
            largest_alpha = largest(port.largest_alpha(parameters.delta, parameters.beta))?;
            largest_beta = largest(port.largest_beta(parameters.delta, parameters.alpha))?;
        }
        let result = Passivity {
            order: resolved.order.get(),
            scheme: resolved.scheme.to_string(),
            asked: resolved.asked,
            alpha: parameters.alpha,
            beta: parameters.beta,
            delta: resolved.delta_given.then_some(parameters.delta),
            path: resolved.path_result(),
            required_delta: required.delta,
            corollary_delta: required.corollary_delta,
            worst_theta: required.worst_theta,
            passive: resolved
                .delta_given
                .then(|| required.passive(parameters.delta)),
            passive_reason: match (required.negative_at_rest, resolved.delta_given) {
                (true, _) => {
                    Some("at rest a negative spring, alpha + beta P(1) < 0: no damping is enough")
                }
                (false, false) => Some("give --delta or --damping to know"),
                _ => None,
            },
            negative_at_rest: required.negative_at_rest,
            largest_alpha,
            largest_beta,
            // K = αm/T², B = βm/T^(2−μ), δ = bT/m
            largest_stiffness_n_per_m: (resolved.units.zip(largest_alpha))
                .map(|((m, t), alpha)| alpha * m / (t * t)),
            largest_dissipation_n_s_mu_per_m: (resolved.units.zip(largest_beta))
                .map(|((m, t), beta)| beta * m / t.powf(2.0 - resolved.order.get())),
            required_damping_n_s_per_m: resolved.units.map(|(m, t)| required.delta * m / t),
            worst_rad_s: resolved.units.map(|(_, t)| required.worst_theta / t),
        };
        output.report(&result)
    }
}
