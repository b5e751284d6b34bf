//! `analyze stability`: is this wall stable on this device, and by how much?

use super::arguments::{Asked, Wall, decibel, resolve};
use super::path::PathResult;
use crate::keys;
use crate::options::Options;
use crate::output::Output;
use clap::Args;
use haptic_experiment::Failure;
use serde::Serialize;

/// Arguments of `analyze stability`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli analyze stability --order 0.5 --mass 65g --damping 3.5 --sample-time 2ms \
                  --stiffness 3N/mm --dissipation 100"
)]
pub struct VerdictArguments {
    #[command(flatten)]
    options: Options<keys::Loop>,
}

/// Result of `analyze stability`.
#[derive(Serialize)]
struct StabilityVerdict {
    order: f64,
    scheme: String,
    #[serde(flatten)]
    asked: Asked,
    alpha: f64,
    beta: f64,
    delta: f64,
    gamma: f64,
    #[serde(flatten)]
    path: PathResult,
    stable: bool,
    /// On the boundary, or a device that stays where it is left.
    stable_reason: Option<String>,
    /// There is no spring, or one too weak to tell: the device stays where it is left, and the loop is judged beside that pole.
    drifts: bool,
    /// Largest |z| of a pole; null if P is irrational or the polynomial too long.
    spectral_radius: Option<f64>,
    /// Poles with |z| > 1, by encirclement; null on the boundary.
    encirclements: Option<usize>,
    /// Factor by which the wall as a whole could grow; null for none, or if unstable.
    gain_margin: Option<f64>,
    /// More delay that the loop could bear, samples; null for any, or if unstable.
    delay_margin_samples: Option<f64>,
    peak_sensitivity_db: Option<f64>,
}

impl VerdictArguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let resolved = resolve(&self.options.given()?, Wall::Needed)?;
        let parameters = resolved.parameters;
        // Without any spring there is a pole at z = 1, which is no instability.
        let sampled = resolved.sampled()?;
        let (drifts, sampled) = (sampled.drifts(), sampled.beside_rest());
        let verdict = sampled.verdict();
        // Only a stable loop has margins; the edge is not stable.
        let margins = if verdict.stable {
            sampled.margins().ok()
        } else {
            None
        };
        let result = StabilityVerdict {
            order: resolved.order.get(),
            scheme: resolved.scheme.to_string(),
            asked: resolved.asked,
            alpha: parameters.alpha,
            beta: parameters.beta,
            delta: parameters.delta,
            gamma: parameters.gamma,
            path: resolved.path_result(),
            stable: verdict.stable,
            stable_reason: match (verdict.unstable_poles, drifts) {
                (None, _) => Some("on the boundary".to_owned()),
                (_, true) => Some("without a spring the device stays where it is left".to_owned()),
                _ => None,
            },
            drifts,
            spectral_radius: verdict.spectral_radius,
            encirclements: verdict.unstable_poles,
            gain_margin: margins
                .and_then(|margins| margins.gain_up)
                .map(|at| at.value),
            delay_margin_samples: margins.and_then(|margins| margins.delay).map(|at| at.value),
            peak_sensitivity_db: margins.map(|margins| decibel(margins.sensitivity.value)),
        };
        output.report(&result)
    }
}
