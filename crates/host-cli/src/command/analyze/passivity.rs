//! `analyze passivity` and `analyze coupling`: how much damping a port needs.

use super::arguments::{LoopArguments, PathResult, Wall, refused};
use crate::command::words::{parse_number, parse_order, parse_scheme, wall_order};
use crate::output::{Output, fixed, short};
use crate::quantity::{Damping, Time};
use clap::Args;
use fracdiff::{Scheme, Seconds};
use haptic_analysis::{AnalysisError, Coupler, Largest, LeastDamping, LoopOperator, OnePort};
use haptic_experiment::failure::Failure;
use serde::Serialize;
use std::io::{self, Write};

/// Arguments of `analyze passivity`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli analyze passivity --order 0.5 --scheme muir:3 --alpha 0.1 --beta 0.2 --delta 0.2"
)]
pub struct PassivityArguments {
    #[command(flatten)]
    arguments: LoopArguments,
}

/// Arguments of `analyze coupling`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli analyze coupling --order 0.75 --coupler-stiffness 1 --coupler-dissipation 200 \
                  --sample-time 1ms --damping 0.5"
)]
pub struct CouplingArguments {
    /// Order mu of the coupler
    #[arg(long, allow_hyphen_values = true, value_parser = parse_order)]
    order: f64,
    /// `k_c` of the coupler `k_c` + `b_c` (T/(1-w))^mu, velocity in, force out: N s/m
    #[arg(long, value_name = "K_C", allow_hyphen_values = true, value_parser = parse_number)]
    coupler_stiffness: f64,
    /// `b_c` of the coupler: N s^(1-mu)/m
    #[arg(long, value_name = "B_C", allow_hyphen_values = true, value_parser = parse_number)]
    coupler_dissipation: f64,
    /// Sample time T
    #[arg(long, allow_hyphen_values = true)]
    sample_time: Time,
    /// Damping b of the device, to be judged
    #[arg(long, allow_hyphen_values = true)]
    damping: Option<Damping>,
    /// Fractional operator, see `host-cli --help`
    #[arg(long, value_parser = parse_scheme, default_value = "exact")]
    scheme: Scheme,
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
    /// Whether the given δ is enough; null without one.
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

/// Result of `analyze coupling`.
#[derive(Serialize)]
struct Coupling {
    order: f64,
    scheme: String,
    /// Least b by Llewellyn's criterion, N·s/m; null if no damping is enough.
    required_damping: Option<f64>,
    /// By Corollary 2, N·s/m.
    corollary_damping: f64,
    worst_theta: f64,
    /// Whether the given b is enough; null without one, unless none is.
    passive: Option<bool>,
    reason: Option<String>,
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
            print_passivity(out, &result, parameters.delta, resolved.units)
        })
    }
}

/// The result as a person reads it.
fn print_passivity(
    out: &mut dyn Write,
    result: &Passivity,
    delta: f64,
    units: Option<(f64, f64)>,
) -> io::Result<()> {
    writeln!(
        out,
        "required delta    {} (Theorem 1, the operator really used, {}), at theta = {:.6}",
        fixed(result.required_delta, 9),
        result.path.words(),
        result.worst_theta
    )?;
    writeln!(
        out,
        "corollary delta   {} (Corollary 1, exact operator without delay)",
        fixed(result.corollary_delta, 9)
    )?;
    if let (Some(b), Some(omega)) = (result.required_damping_n_s_per_m, result.worst_rad_s) {
        let (b, omega) = (fixed(b, 6), fixed(omega, 3));
        writeln!(out, "required damping  {b} N·s/m, at {omega} rad/s")?;
    }
    if result.negative_at_rest {
        writeln!(
            out,
            "at rest           a negative spring, alpha + beta P(1) < 0: no damping makes this wall passive"
        )?;
    }
    match result.passive {
        Some(passive) => writeln!(
            out,
            "passive           {}, with delta = {}",
            if passive { "yes" } else { "no" },
            short(delta)
        ),
        None => writeln!(out, "passive           give --delta or --damping to know"),
    }?;
    // K = αm/T², B = βm/T^(2−μ)
    let unit_of = |power: f64| units.map_or(1.0, |(m, t)| m / t.powf(power));
    let with_units = units.is_some();
    let (stiffness, dissipation) = match with_units {
        true => (("K", " N/m"), ("B", " N·s^μ/m")),
        false => (("alpha", ""), ("beta", "")),
    };
    for (value, power, (name, unit)) in [
        (result.largest_alpha, 2.0, stiffness),
        (result.largest_beta, 2.0 - result.order, dissipation),
    ] {
        if let Some(value) = value {
            let value = fixed(value * unit_of(power), 9);
            writeln!(
                out,
                "largest {name:<9} {value}{unit}, with the rest as given"
            )?;
        }
    }
    Ok(())
}

impl CouplingArguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let mu = wall_order(self.order, "--order")?;
        let exact = Coupler::exact(
            mu,
            self.sample_time.0,
            self.coupler_stiffness,
            self.coupler_dissipation,
        )
        .map_err(refused)?;
        let operator = LoopOperator::new(
            self.scheme,
            mu,
            Seconds(self.sample_time.0),
            super::arguments::HORIZON,
        )
        .map_err(refused)?;
        let coupler = if self.scheme == Scheme::Exact {
            exact
        } else {
            exact.with_operator(&operator, operator.memory())
        };
        let damping = self.damping.map(|b| b.0);
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
            scheme: self.scheme.to_string(),
            required_damping: required,
            corollary_damping: coupler.corollary_damping(),
            worst_theta,
            passive,
            reason,
        };
        output.print(&result, |out| print_coupling(out, &result, damping))
    }
}

/// The result as a person reads it.
fn print_coupling(out: &mut dyn Write, result: &Coupling, damping: Option<f64>) -> io::Result<()> {
    match (&result.reason, result.required_damping) {
        (Some(reason), _) => writeln!(out, "{reason}")?,
        (None, Some(b)) => writeln!(
            out,
            "required damping   {b:.9} N·s/m (Llewellyn), at theta = {:.6}",
            result.worst_theta
        )?,
        (None, None) => {}
    }
    writeln!(
        out,
        "corollary damping  {:.9} N·s/m (Corollary 2, not sufficient)",
        result.corollary_damping
    )?;
    match (result.passive, damping) {
        (Some(true), Some(b)) => writeln!(out, "passive            yes, with {b} N·s/m"),
        (Some(false), Some(b)) => writeln!(out, "passive            no, with {b} N·s/m"),
        (Some(false), None) => writeln!(out, "passive            no"),
        _ => writeln!(out, "passive            give --damping to know"),
    }
}
