//! The way of the force, its delay and current lag: what an analysis is told, and what it answers.

use crate::options::Given;
use haptic_analysis::ForcePath;
use haptic_experiment::Failure;
use haptic_experiment::parameters::Parameter;
use haptic_experiment::parameters::analysis::{ANALYSED_DELAY, ANALYSED_LAG, DELAY_SAMPLES};
use haptic_experiment::run::DeviceValues;
use serde::Serialize;

/// Delay and lag of a loop in samples; `sample_time_s` is its own, if it was given. What is not given is of the device file.
///
/// # Errors
/// A delay in both units, a time without a sample time, something outside its range.
pub(super) fn path(
    given: &Given,
    sample_time_s: Option<f64>,
    file: Option<&DeviceValues>,
) -> Result<ForcePath, Failure> {
    let in_samples = given.number(&DELAY_SAMPLES);
    if in_samples.is_some() && given.has(&ANALYSED_DELAY) {
        return Err(Failure::bad_input(
            "the delay is given both in samples and in seconds: give either --delay-samples or --delay",
        ));
    }
    let samples = |parameter: &Parameter, of_file: fn(&DeviceValues) -> f64| {
        let time_s = given.number(parameter).or(file.map(of_file)).unwrap_or(0.0);
        match sample_time_s {
            Some(t) => Ok(time_s / t),
            None if time_s == 0.0 => Ok(0.0),
            None => Err(Failure::bad_input(format_args!(
                "{parameter} {time_s} s is a time, and the loop has none: give --sample-time"
            ))),
        }
    };
    let delay = match in_samples {
        Some(samples) => samples,
        None => samples(&ANALYSED_DELAY, |file| file.delay_s)?,
    };
    let lag = samples(&ANALYSED_LAG, |file| file.current_lag_s)?;
    ForcePath::new(delay, lag).map_err(|error| {
        Failure::input_with_advice(error, "change --delay, --delay-samples or --current-lag")
    })
}

/// Delay and lag in a result.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct PathResult {
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
    pub(super) fn new(path: ForcePath, sample_time_s: Option<f64>) -> Self {
        Self {
            delay_samples: path.delay_samples(),
            delay_s: sample_time_s.map(|t| path.delay_samples() * t),
            current_lag_samples: path.lag_samples(),
            current_lag_s: sample_time_s.map(|t| path.lag_samples() * t),
        }
    }

    /// In words: `delay 1.3 samples`, and the lag if there is one.
    #[must_use]
    pub(super) fn words(&self) -> String {
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
