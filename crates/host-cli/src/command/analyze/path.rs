//! The way of the force, its delay and current lag: what an analysis is told, and what it answers.

use crate::within::{number_within, within};
use clap::Args;
use haptic_analysis::ForcePath;
use haptic_experiment::Failure;
use haptic_experiment::parameters;
use haptic_experiment::parameters::range;
use haptic_experiment::run::DeviceValues;
use haptic_quantity::Time;
use serde::Serialize;

/// The way of the force: delay and current lag.
#[derive(Clone, Copy, Debug, Args)]
pub(super) struct PathArguments {
    /// Delay between measuring and acting beside that of the hold, in samples, whole or not [default: 0]
    #[arg(long, value_name = "SAMPLES", value_parser = number_within(range::DELAY_SAMPLES), allow_hyphen_values = true)]
    delay_samples: Option<f64>,
    /// The same as a time, up to 10000 samples: instead of --delay-samples, with --sample-time
    #[arg(long, value_parser = within::<Time>(parameters::DELAY.range()), value_name = "TIME", allow_hyphen_values = true)]
    delay: Option<Time>,
    /// Time constant of the motor current that follows a command, with --sample-time [default: 0]
    #[arg(long, value_parser = within::<Time>(parameters::CURRENT_LAG.range()), value_name = "TIME", allow_hyphen_values = true)]
    current_lag: Option<Time>,
}

impl PathArguments {
    /// Delay and lag in samples; `sample_time_s` is that of the loop, if it was given. What is not given is of the device file.
    ///
    /// # Errors
    /// A delay in both units, a time without a sample time, something outside its range.
    pub(super) fn resolve(
        &self,
        sample_time_s: Option<f64>,
        file: Option<&DeviceValues>,
    ) -> Result<ForcePath, Failure> {
        if self.delay.is_some() && self.delay_samples.is_some() {
            return Err(Failure::bad_input(
                "the delay is given both in samples and in seconds: give either --delay-samples or --delay",
            ));
        }
        let samples = |time: Time, option: &str| match sample_time_s {
            Some(t) => Ok(time.0 / t),
            None => Err(Failure::bad_input(format_args!(
                "{option} {} s is a time, and the loop has none: give --sample-time{}",
                time.0,
                if option == "--delay" {
                    ", or --delay-samples"
                } else {
                    ""
                }
            ))),
        };
        let delay = match (self.delay, self.delay_samples) {
            (Some(time), _) => samples(time, "--delay")?,
            (None, Some(given)) => given,
            (None, None) => match file {
                Some(file) => samples(Time(file.delay_s), "the delay of --device-model,")?,
                None => 0.0,
            },
        };
        let lag = match (self.current_lag, file) {
            (Some(time), _) => samples(time, "--current-lag")?,
            (None, Some(file)) => samples(Time(file.current_lag_s), "the lag of --device-model,")?,
            (None, None) => 0.0,
        };
        ForcePath::new(delay, lag).map_err(|error| {
            Failure::input_with_advice(error, "change --delay, --delay-samples or --current-lag")
        })
    }
}

/// Delay and lag in a result.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct PathResult {
    delay_samples: f64,
    /// Null without a sample time.
    delay_s: Option<f64>,
    current_lag_samples: f64,
    /// Null without a sample time.
    current_lag_s: Option<f64>,
}

impl PathResult {
    /// Of a loop with this sample time, if it has one.
    #[must_use]
    pub fn new(path: ForcePath, sample_time_s: Option<f64>) -> Self {
        Self {
            delay_samples: path.delay_samples(),
            delay_s: sample_time_s.map(|t| path.delay_samples() * t),
            current_lag_samples: path.lag_samples(),
            current_lag_s: sample_time_s.map(|t| path.lag_samples() * t),
        }
    }

    /// In words: `delay 1.3 samples`, and the lag if there is one.
    #[must_use]
    pub fn words(&self) -> String {
        // 1.3 ms / 1 ms is 1.2999999999999998.
        let rounded = |samples: f64| (samples * 1e9).round() / 1e9;
        let lag = if self.current_lag_samples > 0.0 {
            format!(
                ", current lag {} samples",
                rounded(self.current_lag_samples)
            )
        } else {
            String::new()
        };
        format!("delay {} samples{lag}", rounded(self.delay_samples))
    }
}
