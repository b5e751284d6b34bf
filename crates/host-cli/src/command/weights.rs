//! `weights`: the impulse response of an operator.

use super::words::{order, parse_order, parse_scheme, rate, sample_time_of};
use crate::output::Output;
use crate::whole::whole;
use crate::within::within;
use clap::Args;
use fracdiff::{Channel, Operator, Scheme, grunwald_weights};
use haptic_experiment::Failure;
use haptic_experiment::parameters::range;
use haptic_quantity::Time;
use serde::Serialize;

/// Arguments of `weights`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli weights --order 0.5 --scheme grunwald:5 --count 5\n\
                  The response is that of P in D^mu = T^(-mu) P, without a unit."
)]
pub struct Arguments {
    /// Order mu, -2 to 2
    #[arg(long, allow_hyphen_values = true, value_parser = parse_order)]
    order: f64,
    /// Fractional operator, see `host-cli --help`
    #[arg(long, value_parser = parse_scheme, default_value = "exact")]
    scheme: Scheme,
    /// Number of weights
    #[arg(long, default_value_t = 10, allow_hyphen_values = true, value_parser = whole::<u64>(1..=10_000_000))]
    count: u64,
    /// Sample time, for a scheme with frequencies in Hz
    #[arg(long, value_parser = within::<Time>(range::SAMPLE_TIMES), allow_hyphen_values = true)]
    sample_time: Option<Time>,
}

/// The result.
#[derive(Serialize)]
struct Weights {
    order: f64,
    scheme: String,
    weights: Vec<f64>,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// An order or sample time outside its range, a scheme that cannot be made.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let mu = order(self.order)?;
        let count = usize::try_from(self.count).map_err(Failure::input)?;
        let weights = if self.scheme == Scheme::Exact {
            grunwald_weights(mu).take(count).collect()
        } else {
            let t = sample_time_of(self.scheme, self.sample_time.map(|t| t.0))?;
            let rate = rate(t, mu)?;
            let operator: Operator<f64> = self
                .scheme
                .build(mu, t, 1.05 * self.count as f64)
                .map_err(Failure::input)?;
            let mut channel = Channel::new(operator);
            let impulse = std::iter::once(1.0).chain(std::iter::repeat(0.0));
            impulse
                .take(count)
                .map(|x| channel.step(x) / rate)
                .collect()
        };
        let result = Weights {
            order: mu.get(),
            scheme: self.scheme.to_string(),
            weights,
        };
        output.text(&result, |out| {
            writeln!(out, "lag,weight")?;
            for (lag, weight) in result.weights.iter().enumerate() {
                writeln!(out, "{lag},{weight}")?;
            }
            Ok(())
        })
    }
}
