//! `analyze passivity`: the damping that a wall needs to be passive.

use super::arguments::{LoopArguments, Wall, refused};
use super::path::PathResult;
use crate::output::{Output, fixed};
use clap::Args;
use fracdiff::parameter::Shown;
use haptic_analysis::{AnalysisError, Largest, OnePort};
use haptic_experiment::Failure;
use serde::Serialize;
use std::io::{self, Write};

/// Nearer to a bound, as a share of it, nothing is known.
const ROUNDING: f64 = 1e-15;
/// Decimals of δ.
const DIGITS: usize = 9;

/// Arguments of `analyze passivity`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli analyze passivity --order 0.5 --scheme muir:3 --mass 65g --damping 3.5 --sample-time 1ms --stiffness 3N/mm --dissipation 10"
)]
pub struct PassivityArguments {
    #[command(flatten)]
    arguments: LoopArguments,
}

/// Result of `analyze passivity`.
#[derive(Serialize)]
struct Passivity {
    order: f64,
    scheme: String,
    alpha: f64,
    beta: f64,
    #[serde(flatten)]
    path: PathResult,
    /// Least δ by Theorem 1 for the operator really used; passive above it.
    required_delta: f64,
    /// By Corollary 1, which holds for the exact operator without delay.
    corollary_delta: f64,
    worst_theta: f64,
    /// True if the given δ is enough; null without one.
    passive: Option<bool>,
    /// α + βP(1) < 0: then no damping is enough.
    negative_at_rest: bool,
    /// Largest α that is passive with the given δ and β; null without a δ, or if none or any is.
    largest_alpha: Option<f64>,
    /// Largest β that is passive with the given δ and α; null likewise.
    largest_beta: Option<f64>,
    /// The same with units, where the loop was given with units.
    required_damping_n_s_per_m: Option<f64>,
    worst_rad_s: Option<f64>,
}

impl PassivityArguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let resolved = self.arguments.resolve(Wall::Needed)?;
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
            alpha: parameters.alpha,
            beta: parameters.beta,
            path: resolved.path_result(),
            required_delta: required.delta,
            corollary_delta: required.corollary_delta,
            worst_theta: required.worst_theta,
            passive: resolved
                .delta_given
                .then(|| required.passive(parameters.delta)),
            negative_at_rest: required.negative_at_rest,
            largest_alpha,
            largest_beta,
            // δ = bT/m
            required_damping_n_s_per_m: resolved.units.map(|(m, t)| required.delta * m / t),
            worst_rad_s: resolved.units.map(|(_, t)| required.worst_theta / t),
        };
        output.print(&result, |out| {
            result.print(out, parameters.delta, resolved.units)
        })
    }
}

impl Passivity {
    /// As a person reads it; `units` are m and T, where the loop was given with units.
    fn print(&self, out: &mut dyn Write, delta: f64, units: Option<(f64, f64)>) -> io::Result<()> {
        writeln!(
            out,
            "required delta    {} (Theorem 1, the operator really used, {}), at theta = {:.6}",
            fixed(self.required_delta, DIGITS),
            self.path.words(),
            self.worst_theta
        )?;
        writeln!(
            out,
            "corollary delta   {} (Corollary 1, exact operator without delay)",
            fixed(self.corollary_delta, DIGITS)
        )?;
        if let (Some(b), Some(omega)) = (self.required_damping_n_s_per_m, self.worst_rad_s) {
            let (b, omega) = (fixed(b, 6), fixed(omega, 3));
            writeln!(out, "required damping  {b} N·s/m, at {omega} rad/s")?;
        }
        if self.negative_at_rest {
            writeln!(
                out,
                "at rest           a negative spring, alpha + beta P(1) < 0: no damping makes this wall passive"
            )?;
        }
        match self.passive {
            Some(passive) => writeln!(
                out,
                "passive           {}, with delta = {}{}",
                if passive { "yes" } else { "no" },
                Shown(delta),
                self.beside_the_bound(delta)
            ),
            None => writeln!(out, "passive           give --delta or --damping to know"),
        }?;
        self.print_largest(out, units)
    }

    /// Words for a δ that looks like the required one with the digits that are printed.
    fn beside_the_bound(&self, delta: f64) -> String {
        let over = delta - self.required_delta;
        match () {
            () if fixed(delta, DIGITS) != fixed(self.required_delta, DIGITS) => String::new(),
            () if over.abs() <= ROUNDING * self.required_delta => {
                ", which is the bound itself: take more".to_owned()
            }
            () if over > 0.0 => format!(", {over:.1e} above the bound"),
            () => format!(", {:.1e} below the bound", -over),
        }
    }

    fn print_largest(&self, out: &mut dyn Write, units: Option<(f64, f64)>) -> io::Result<()> {
        // K = αm/T², B = βm/T^(2−μ)
        let scale = |power: f64| units.map_or(1.0, |(m, t)| m / t.powf(power));
        let with_units = units.is_some();
        if let Some(alpha) = self.largest_alpha {
            let (name, unit) = if with_units {
                ("K", " N/m")
            } else {
                ("alpha", "")
            };
            writeln!(
                out,
                "largest {name:<9} {}{unit}, with the rest as given",
                fixed(alpha * scale(2.0), 9)
            )?;
        }
        if let Some(beta) = self.largest_beta {
            let (name, unit) = if with_units {
                ("B", " N·s^μ/m")
            } else {
                ("beta", "")
            };
            let value = fixed(beta * scale(2.0 - self.order), 9);
            writeln!(
                out,
                "largest {name:<9} {value}{unit}, with the rest as given"
            )?;
        }
        Ok(())
    }
}
