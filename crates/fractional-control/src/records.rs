//! Whole responses of a transfer function: to a step, to an impulse, to any record.

use crate::{ControlError, FractionalTransferFunction, PowerMemory, SampledTransferFunction};
use fracdiff::{Differintegrator, Seconds};
use std::vec::Vec;

/// Room for the modes of offline work: enough for a tolerance of 1e-11.
pub const MODES: usize = 112;

pub(crate) fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(0.0, |most: f64, x| most.max(x.abs()))
}

/// The response to u(t) = 1 for t > 0, at t = 0, T, 2T, …, for `samples` samples.
///
/// With [`Rule::Bdf2`](crate::Rule::Bdf2) the error falls with T² at any fixed t > 0: the first sample is halved.
/// ```
/// use fractional_control::{FractionalTransferFunction, PowerMemory, Rule, step_response};
/// use fracdiff::Seconds;
///
/// let lag: FractionalTransferFunction = "1/(s+1)".parse()?;
/// let y = step_response(&lag, PowerMemory::new(Rule::Bdf2, 1e-8, 10.0)?, Seconds(0.01), 101)?;
/// assert!((y[100] - (1.0 - f64::exp(-1.0))).abs() < 2e-5);
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
///
/// # Errors
/// As [`SampledTransferFunction::new`].
pub fn step_response(
    function: &FractionalTransferFunction,
    memory: PowerMemory,
    sample_time: Seconds,
    samples: usize,
) -> Result<Vec<f64>, ControlError> {
    let first = core::iter::once(0.5).chain(core::iter::repeat(1.0));
    run(function, memory, sample_time, first.take(samples))
}

/// The response to a unit impulse at t = 0, at t = 0, T, 2T, …; in \[output\]/\[input\]/s. At t = 0
/// it is the sampled function's value, because the true one may be infinite.
///
/// # Errors
/// As [`SampledTransferFunction::new`].
pub fn impulse_response(
    function: &FractionalTransferFunction,
    memory: PowerMemory,
    sample_time: Seconds,
    samples: usize,
) -> Result<Vec<f64>, ControlError> {
    let first = core::iter::once(1.0 / sample_time.0).chain(core::iter::repeat(0.0));
    run(function, memory, sample_time, first.take(samples))
}

/// The response to a record of samples, from rest.
///
/// # Errors
/// As [`SampledTransferFunction::new`].
pub fn respond(
    function: &FractionalTransferFunction,
    memory: PowerMemory,
    sample_time: Seconds,
    input: &[f64],
) -> Result<Vec<f64>, ControlError> {
    run(function, memory, sample_time, input.iter().copied())
}

fn run(
    function: &FractionalTransferFunction,
    memory: PowerMemory,
    sample_time: Seconds,
    input: impl Iterator<Item = f64>,
) -> Result<Vec<f64>, ControlError> {
    let running = SampledTransferFunction::new(function, memory, sample_time)?;
    Ok(through(&running, input))
}

/// The response of a function that is sampled already, from rest.
pub fn through(
    running: &SampledTransferFunction<f64, MODES>,
    input: impl Iterator<Item = f64>,
) -> Vec<f64> {
    let mut history = running.at_rest();
    input.map(|u| running.step(&mut history, u)).collect()
}
