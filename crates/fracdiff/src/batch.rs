//! Whole records at once, for files: the defining sums by FFT, in `f64`.
//!
//! ```text
//! y[n] = T^(−μ) · Σ_{j=0}^{min(n, N−1)} w_j·x[n−j]     for every n
//! ```
//! - *Start-up*: zero before the first sample. For Caputo give x − x₀.
//! - *Accuracy*: rounding of about 1e-15 of the largest value, 1e-12 at most of T^(−μ)·Σ|`w_j`|·max|x|.
//!   Not the same bits everywhere: the transform takes the instructions that the processor has.
//! - *Cost*: O(n log N) time, some 100 bytes a sample for the full history, much less for a short one.
//! - *Not finite*: a NaN or infinity spoils its whole block, earlier samples as well. Check before.

use crate::error::check_length;
use crate::full_memory::Kernel;
use crate::weights::{grunwald_weights, piecewise_linear_weight};
use crate::{Order, ParameterError, Seconds, ShortMemoryVec};
use realfft::{FftError, RealFftPlanner};
use std::vec;
use std::vec::Vec;

/// D^μ of a record by its full history, no memory cut. From order 1 on both kernels are backward
/// differences.
///
/// ```
/// use fracdiff::{Order, Seconds, batch, full_memory::Kernel};
///
/// // The half derivative of a ramp is 2·√(t/π); straight lines are exact with this kernel.
/// let ramp: Vec<f64> = (0..1000).map(|n| f64::from(n) * 1e-3).collect();
/// let (half, t) = (Order::new(0.5)?, Seconds(1e-3));
/// let y = batch::full_history(Kernel::PiecewiseLinear, half, t, &ramp)?;
/// assert!((y[999] - 2.0 * (0.999 / std::f64::consts::PI).sqrt()).abs() < 1e-10);
/// # Ok::<(), fracdiff::ParameterError>(())
/// ```
/// # Errors
/// [`ParameterError::SampleTime`] unless 1e-9 s ≤ T ≤ 1e6 s.
pub fn full_history(
    kernel: Kernel,
    order: Order,
    sample_time: Seconds,
    x: &[f64],
) -> Result<Vec<f64>, ParameterError> {
    let rate = sample_time.rate_to_the(order)?;
    Ok(scaled(rate, convolve(&weights(kernel, order, x.len()), x)))
}

/// What [`ShortMemoryVec`] of this length makes of the record, to rounding. Faster than running it from
/// some 500 samples of memory on.
///
/// # Errors
/// [`ParameterError::SampleTime`] as above, [`ParameterError::Length`] unless 1 ≤ length ≤
/// [`ShortMemoryVec::MOST`].
pub fn short_memory(
    order: Order,
    length: usize,
    sample_time: Seconds,
    x: &[f64],
) -> Result<Vec<f64>, ParameterError> {
    check_length("memory length", length, ShortMemoryVec::<f64>::MOST)?;
    let rate = sample_time.rate_to_the(order)?;
    let weights = weights(Kernel::Grunwald, order, length.min(x.len()));
    Ok(scaled(rate, convolve(&weights, x)))
}

fn scaled(rate: f64, mut y: Vec<f64>) -> Vec<f64> {
    for y in &mut y {
        *y *= rate;
    }
    y
}

/// The first weights of a kernel.
fn weights(kernel: Kernel, order: Order, count: usize) -> Vec<f64> {
    match kernel {
        Kernel::PiecewiseLinear if order.get() < 1.0 => (0..count as u64)
            .filter_map(|lag| piecewise_linear_weight(order, lag))
            .collect(),
        _ => grunwald_weights(order).take(count).collect(),
    }
}

/// The first `x.len()` values of the convolution.
fn convolve(weights: &[f64], x: &[f64]) -> Vec<f64> {
    // A transform fails for wrong lengths only, and these are right; if ever, nothing that looks like a result.
    try_convolve(weights, x).unwrap_or_else(|_| vec![f64::NAN; x.len()])
}

/// Blocks of a long record are this many times as long as a short memory.
const BLOCK: usize = 8;

/// By overlap-add: each block of x is convolved with all weights, and the parts are added.
fn try_convolve(weights: &[f64], x: &[f64]) -> Result<Vec<f64>, FftError> {
    let block = if BLOCK * weights.len() < x.len() {
        BLOCK * weights.len()
    } else {
        x.len()
    };
    let length = smooth_length(block + weights.len());
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, inverse) = (
        planner.plan_fft_forward(length),
        planner.plan_fft_inverse(length),
    );
    drop(planner);
    let mut padded = forward.make_input_vec();
    let mut scratch = forward.make_scratch_vec();
    scratch.resize(
        scratch.len().max(inverse.get_scratch_len()),
        Default::default(),
    );
    let mut factors = forward.make_output_vec();
    padded[..weights.len()].copy_from_slice(weights);
    forward.process_with_scratch(&mut padded, &mut factors, &mut scratch)?;
    let mut spectrum = forward.make_output_vec();
    let mut y = vec![0.0; x.len()];
    for (x, start) in x.chunks(block.max(1)).zip((0..).step_by(block.max(1))) {
        padded.fill(0.0);
        padded[..x.len()].copy_from_slice(x);
        forward.process_with_scratch(&mut padded, &mut spectrum, &mut scratch)?;
        for (bin, factor) in spectrum.iter_mut().zip(&factors) {
            *bin *= factor / length as f64;
        }
        inverse.process_with_scratch(&mut spectrum, &mut padded, &mut scratch)?;
        for (y, part) in y[start..].iter_mut().zip(&padded) {
            *y += part;
        }
    }
    Ok(y)
}

/// The smallest even number of at least `least` without prime factors above 5, where an FFT is fast.
fn smooth_length(least: usize) -> usize {
    let is_smooth = |mut n: usize| {
        for prime in [2, 3, 5] {
            while n.is_multiple_of(prime) {
                n /= prime;
            }
        }
        n == 1
    };
    let mut length = least.next_multiple_of(2).max(2);
    while !is_smooth(length) {
        length += 2;
    }
    length
}

#[cfg(test)]
mod tests {
    use super::smooth_length;

    #[test]
    fn smooth_lengths_are_the_next_ones() {
        for (least, want) in [(0, 2), (1, 2), (7, 8), (14, 16), (2_000_000, 2_000_000)] {
            assert_eq!(smooth_length(least), want);
        }
    }
}
