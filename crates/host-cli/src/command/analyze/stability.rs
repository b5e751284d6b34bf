//! `analyze stability`: is this wall stable on this device, and by how much?

use super::arguments::{LoopArguments, Wall, decibel};
use super::path::PathResult;
use crate::output::{Output, fixed};
use clap::Args;
use fracdiff::parameter::Shown;
use haptic_experiment::Failure;
use serde::Serialize;
use std::io::{self, Write};

/// Arguments of `analyze stability`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli analyze stability --order 0.5 --mass 65g --damping 3.5 --sample-time 2ms \
                  --stiffness 3N/mm --dissipation 100"
)]
pub struct VerdictArguments {
    #[command(flatten)]
    arguments: LoopArguments,
}

/// Result of `analyze stability`.
#[derive(Serialize)]
struct StabilityVerdict {
    order: f64,
    scheme: String,
    alpha: f64,
    beta: f64,
    delta: f64,
    gamma: f64,
    #[serde(flatten)]
    path: PathResult,
    /// There is no spring, or one too weak to tell: the device stays where it is left, and the loop is judged beside that pole.
    drifts: bool,
    stable: bool,
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
        let resolved = self.arguments.resolve(Wall::Needed)?;
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
            alpha: parameters.alpha,
            beta: parameters.beta,
            delta: parameters.delta,
            gamma: parameters.gamma,
            path: resolved.path_result(),
            drifts,
            stable: verdict.stable,
            spectral_radius: verdict.spectral_radius,
            encirclements: verdict.unstable_poles,
            gain_margin: margins
                .and_then(|margins| margins.gain_up)
                .map(|at| at.value),
            delay_margin_samples: margins.and_then(|margins| margins.delay).map(|at| at.value),
            peak_sensitivity_db: margins.map(|margins| decibel(margins.sensitivity.value)),
        };
        output.print(&result, |out| result.print(out))
    }
}

impl StabilityVerdict {
    /// As a person reads it.
    fn print(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(
            out,
            "{}: order {}, scheme {}, alpha {}, beta {}, delta {}, gamma {}, {}",
            match (self.stable, self.encirclements) {
                (true, _) => "stable",
                (false, Some(_)) => "unstable",
                (false, None) => "on the boundary",
            },
            self.order,
            self.scheme,
            Shown(self.alpha),
            Shown(self.beta),
            Shown(self.delta),
            Shown(self.gamma),
            self.path.words()
        )?;
        if self.drifts {
            let spring = if self.alpha + self.gamma > 0.0 {
                format!(
                    "with a spring of {}, too weak to be told from none (1e-9)",
                    Shown(self.alpha + self.gamma)
                )
            } else {
                "without any spring".to_owned()
            };
            writeln!(
                out,
                "  {spring}: the device stays where it is left, which is no instability"
            )?;
        }
        if let Some(poles) = self.encirclements.filter(|poles| *poles > 0) {
            writeln!(out, "  unstable poles    {poles}")?;
        }
        if let Some(radius) = self.spectral_radius {
            writeln!(out, "  spectral radius   {}", fixed(radius, 9))?;
        }
        if self.stable {
            let or_any = |value: Option<f64>| {
                value.map_or_else(|| "any".to_owned(), |value| fixed(value, 6))
            };
            writeln!(
                out,
                "  gain margin       {} times the wall",
                or_any(self.gain_margin)
            )?;
            writeln!(
                out,
                "  delay margin      {} samples more",
                or_any(self.delay_margin_samples)
            )?;
        }
        if let Some(peak) = self.peak_sensitivity_db {
            writeln!(out, "  sensitivity peak  {peak:.3} dB")?;
        }
        Ok(())
    }
}
