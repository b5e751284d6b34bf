//! `analyze coupling`: the damping that a virtual coupler needs.

use super::arguments::{HORIZON, refused};
use crate::command::words::{parse_order, parse_scheme, wall_order};
use crate::output::Output;
use crate::within::{number_within, within};
use clap::Args;
use fracdiff::{Scheme, Seconds};
use haptic_analysis::{Coupler, LeastDamping, LoopOperator};
use haptic_experiment::Failure;
use haptic_experiment::parameters;
use haptic_experiment::parameters::range;
use haptic_quantity::{Damping, Time};
use serde::Serialize;
use std::io::{self, Write};

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
    /// Damper of the coupler damper + spring (T/(1-w))^mu, velocity in, force out: N s/m
    #[arg(long, value_name = "DAMPER", allow_hyphen_values = true, value_parser = number_within(parameters::COUPLER_STIFFNESS.range()))]
    coupler_stiffness: f64,
    /// Spring of the coupler: N s^(1-mu)/m
    #[arg(long, value_name = "SPRING", allow_hyphen_values = true, value_parser = number_within(parameters::COUPLER_DISSIPATION.range()))]
    coupler_dissipation: f64,
    /// Sample time T
    #[arg(long, value_parser = within::<Time>(range::SAMPLE_TIMES), allow_hyphen_values = true)]
    sample_time: Time,
    /// Damping b of the device, to be judged
    #[arg(long, value_parser = within::<Damping>(parameters::DAMPING.range()), allow_hyphen_values = true)]
    damping: Option<Damping>,
    /// Fractional operator, see `host-cli --help`
    #[arg(long, value_parser = parse_scheme, default_value = "exact")]
    scheme: Scheme,
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
    /// True if the given b is enough; null without one, unless none is.
    passive: Option<bool>,
    reason: Option<String>,
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
        let operator = LoopOperator::new(self.scheme, mu, Seconds(self.sample_time.0), HORIZON)
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
        output.print(&result, |out| result.print(out, damping))
    }
}

impl Coupling {
    /// As a person reads it; `damping` is that of the device, N·s/m, if it was given.
    fn print(&self, out: &mut dyn Write, damping: Option<f64>) -> io::Result<()> {
        match (&self.reason, self.required_damping) {
            (Some(reason), _) => writeln!(out, "{reason}")?,
            (None, Some(b)) => writeln!(
                out,
                "required damping   {b:.9} N·s/m (Llewellyn), at theta = {:.6}",
                self.worst_theta
            )?,
            (None, None) => {}
        }
        writeln!(
            out,
            "corollary damping  {:.9} N·s/m (Corollary 2, not sufficient)",
            self.corollary_damping
        )?;
        match (self.passive, damping) {
            (Some(true), Some(b)) => writeln!(out, "passive            yes, with {b} N·s/m"),
            (Some(false), Some(b)) => writeln!(out, "passive            no, with {b} N·s/m"),
            (Some(false), None) => writeln!(out, "passive            no"),
            _ => writeln!(out, "passive            give --damping to know"),
        }
    }
}
