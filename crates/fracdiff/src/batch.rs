//! Whole records at once, for files: the defining sums by FFT, in `f64`.
//! ```text
//! y[n] = T^(−μ) · Σ_{j=0}^{min(n, N−1)} w_j·(x[n−j] − x₀)     for every n
//! ```
//! - *Start-up*: the signal stood at x₀ before the first sample: 0, a value, or the first sample itself (Caputo).
//! - *Accuracy*: rounding of about 1e-15 of the largest value, 1e-12 at most of T^(−μ)·Σ|`w_j`|·max|x|. Same bits on every machine.
//! - *Cost*: O(n log N) time, 70 to 120 bytes a sample for the full history, much less for a short one.
//! - *Not finite*: a NaN or infinity makes exactly those outputs NaN that it reaches, itself first; see [`Batch::mask`].

use crate::fft::{Bins, LANES, QuarterTurn, factors_from, forward_all, inverse_all};
use crate::full_memory::Kernel;
use crate::order::check_length;
use crate::parameter::{RangeError, positive, range};
use crate::weights::{grunwald_weights, piecewise_linear_weight};
use crate::{Order, ParameterError, Seconds, ShortMemoryVec, bdf2_short_filter};
use std::vec;
use std::vec::Vec;

/// D^μ of whole records: kernel, memory and reference, for any number of channels.
/// ```
/// use fracdiff::batch::Batch;
/// use fracdiff::{Order, Seconds, full_memory::Kernel};
///
/// // The half derivative of a ramp is 2·√(t/π); straight lines are exact with this kernel.
/// let (order, t) = (Order::new(0.5)?, Seconds(1e-3));
/// let ramp: Vec<f64> = (0..1000).map(|n| f64::from(n) * 1e-3).collect();
/// let y = Batch::full_history(Kernel::PiecewiseLinear, order, t)?.run(&ramp);
/// assert!((y[999] - 2.0 * (0.999 / std::f64::consts::PI).sqrt()).abs() < 1e-10);
///
/// let half = Batch::full_history(Kernel::Grunwald, order, t)?.caputo();
/// // Two axes that start away from zero; the second has a gap.
/// let (x, z) = ([2.0, 2.0, 2.5], [1.0, f64::NAN, 1.0]);
/// let y = half.channels(&[&x, &z]);
/// assert!(y[0][1].abs() < 1e-12 && y[0][2] > 0.0); // no jump at the start
/// assert_eq!(half.mask(&z), [false, true, true]); // what not to look at
/// assert!(y[1][0] == 0.0 && y[1][1].is_nan());
/// # Ok::<(), fracdiff::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    weights: Weights,
    order: Order,
    rate: f64,
    /// Samples; `None` for all.
    memory: Option<usize>,
    reference: Reference,
}

/// The weights of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Weights {
    Of(Kernel),
    Bdf2,
}

/// The value at which the signal stood before the record, x₀.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Reference {
    Value(f64),
    FirstSample,
}

impl Batch {
    /// No memory cut; x₀ = 0. From order 1 on both kernels are backward differences.
    ///
    /// # Errors
    /// [`ParameterError::SampleTime`] unless 1e-9 s ≤ T ≤ 1e6 s.
    pub fn full_history(
        kernel: Kernel,
        order: Order,
        sample_time: Seconds,
    ) -> Result<Self, ParameterError> {
        Ok(Self {
            weights: Weights::Of(kernel),
            order,
            rate: sample_time.rate_to_the(order)?,
            memory: None,
            reference: Reference::Value(0.0),
        })
    }

    /// The weights of [`Bdf2Memory`](crate::Bdf2Memory), of second order in T, no memory cut; x₀ = 0.
    ///
    /// # Errors
    /// [`ParameterError::SampleTime`] as above.
    pub fn full_bdf2(order: Order, sample_time: Seconds) -> Result<Self, ParameterError> {
        let full = Self::full_history(Kernel::Grunwald, order, sample_time)?;
        Ok(Self {
            weights: Weights::Bdf2,
            ..full
        })
    }

    /// The newest `length` samples, as [`ShortMemoryVec`]; x₀ = 0.
    ///
    /// # Errors
    /// [`ParameterError::SampleTime`] as above, [`ParameterError::Length`] unless 1 ≤ length ≤ [`ShortMemoryVec::MOST`].
    pub fn short_memory(
        order: Order,
        length: usize,
        sample_time: Seconds,
    ) -> Result<Self, ParameterError> {
        check_length("memory length", length, ShortMemoryVec::<f64>::MOST)?;
        let full = Self::full_history(Kernel::Grunwald, order, sample_time)?;
        Ok(Self {
            memory: Some(length),
            ..full
        })
    }

    /// Takes x₀ from the record, its first sample: the Caputo derivative for 0 < μ ≤ 1. Each channel has its own.
    #[must_use]
    pub fn caputo(self) -> Self {
        Self {
            reference: Reference::FirstSample,
            ..self
        }
    }

    /// Takes this x₀, in the unit of x.
    #[must_use]
    pub fn relative_to(self, reference: f64) -> Self {
        Self {
            reference: Reference::Value(reference),
            ..self
        }
    }

    /// The outputs of one channel, one for each sample.
    #[must_use]
    pub fn run(&self, x: &[f64]) -> Vec<f64> {
        self.channels(&[x]).pop().unwrap_or_default()
    }

    /// The outputs of several channels, which may differ in length. The weights are transformed once for all.
    #[must_use]
    pub fn channels(&self, channels: &[&[f64]]) -> Vec<Vec<f64>> {
        let longest = channels.iter().map(|x| x.len()).max().unwrap_or(0);
        let weights = self.weights(longest);
        let convolution = Convolution::new(&weights, longest);
        let one = |x: &&[f64]| {
            let reference = self.reference_of(x);
            let mut y = convolution.of(x, reference);
            for (y, spoiled) in y.iter_mut().zip(reached(x, reference, weights.len())) {
                *y = if spoiled { f64::NAN } else { *y * self.rate };
            }
            y
        };
        channels.iter().map(one).collect()
    }

    /// True for the outputs that a sample which is not finite reaches: those are NaN.
    #[must_use]
    pub fn mask(&self, x: &[f64]) -> Vec<bool> {
        reached(x, self.reference_of(x), self.weights(x.len()).len()).collect()
    }

    fn reference_of(&self, x: &[f64]) -> f64 {
        match self.reference {
            Reference::Value(value) => value,
            Reference::FirstSample => x.first().copied().unwrap_or(0.0),
        }
    }

    /// The weights of a record of `samples` samples, up to the last that is not zero.
    fn weights(&self, samples: usize) -> Vec<f64> {
        let count = self.memory.unwrap_or(samples).min(samples);
        let mut weights: Vec<f64> = match self.weights {
            Weights::Bdf2 => bdf2_weights(self.order, count),
            Weights::Of(Kernel::PiecewiseLinear) if self.order.get() < 1.0 => (0..count as u64)
                .filter_map(|lag| piecewise_linear_weight(self.order, lag))
                .collect(),
            _ => grunwald_weights(self.order).take(count).collect(),
        };
        let last = weights.iter().rposition(|weight| *weight != 0.0);
        weights.truncate(last.map_or(0, |last| last + 1));
        weights
    }
}

/// D^μ at uneven times, μ < 1: exact for the straight lines between the samples, from the first on.
/// ```text
/// y(t) = Σ_j s_j·[(t − t_j)^(1−μ) − (t − t_{j+1})^(1−μ)]/Γ(2 − μ) + (x(t₀) − x₀)·(t − t₀)^(−μ)/Γ(1 − μ),   s_j the slopes
/// ```
/// The signal stood at x₀ before: 0 gives the derivative of Riemann and Liouville, which is infinite at t₀ for μ > 0 where x(t₀) is not 0; x(t₀) gives that of Caputo.
/// Source: K. Diethelm, *The Analysis of Fractional Differential Equations*, Springer, 2010, appendix C, for steps of any length.
///
/// - *Accuracy*: rounding, 2e-16 of Σ|`s_j`|·(t − t₀)^(1−μ)/Γ(2 − μ): a short and steep line costs digits.
/// - *Cost*: n²/2 powers.
///
/// # Errors
/// Unless μ < 1, and every time is above the one before. Times and samples are as many.
pub fn uneven(
    order: Order,
    time_s: &[f64],
    x: &[f64],
    reference: f64,
) -> Result<Vec<f64>, RangeError> {
    let mu = order.get();
    range("order of uneven times", mu, mu < 1.0, "below 1", "")?;
    for pair in time_s.windows(2) {
        positive("step of time", pair[1] - pair[0], "s")?;
    }
    let exponent = 1.0 - mu;
    let scale = 1.0 / libm::tgamma(1.0 + exponent);
    let jump = (x.first().copied().unwrap_or(0.0) - reference) * exponent * scale;
    let slopes: Vec<f64> = std::iter::zip(time_s.windows(2), x.windows(2))
        .map(|(t, x)| scale * (x[1] - x[0]) / (t[1] - t[0]))
        .collect();
    let at = |n: usize| {
        let age = |j: usize| time_s[n] - time_s[j];
        // 0 times an infinite power is no jump.
        let jump = if jump == 0.0 {
            0.0
        } else {
            jump * libm::pow(age(0), -mu)
        };
        let mut older = libm::pow(age(0), exponent);
        let parts = (0..n).map(|j| {
            let newer = libm::pow(age(j + 1), exponent);
            let part = slopes[j] * (older - newer);
            older = newer;
            part
        });
        jump + parts.sum::<f64>()
    };
    Ok((0..x.len().min(time_s.len())).map(at).collect())
}

/// The first weights of (3/2 − 2w + w²/2)^μ: those of (1 − w)^μ behind the short filter.
fn bdf2_weights(order: Order, count: usize) -> Vec<f64> {
    let plain: Vec<f64> = grunwald_weights(order).take(count).collect();
    let short = bdf2_short_filter(order);
    (0..count)
        .map(|lag| {
            let newest = plain[..=lag].iter().rev();
            newest.zip(&short).rev().map(|(c, f)| c * f).sum()
        })
        .collect()
}

/// True for each sample where x − x₀ is not finite for one of the newest `memory`.
fn reached(x: &[f64], reference: f64, memory: usize) -> impl Iterator<Item = bool> {
    let mut left = 0;
    x.iter().map(move |x| {
        left = if (x - reference).is_finite() {
            usize::saturating_sub(left, 1)
        } else {
            memory
        };
        left > 0
    })
}

/// Blocks of a long record are about this many times as long as a short memory.
const BLOCK: usize = 8;

/// Convolution of records with the same weights, by overlap-add: each block of a record is convolved with all weights,
/// and the parts are added.
/// ```text
/// z[i] = (x[i] + j·x[i + S])·e^(jπi/2S),  i < S:   Z = FFT z,   V = Z·H,   v = IFFT V
/// y[i] + j·y[i + S] = v[i]·e^(−jπi/2S)
/// ```
/// is real convolution modulo X^2S + 1 by complex transforms of S numbers (R. E. Crandall and B. Fagin, *Discrete weighted transforms and
/// large-integer arithmetic*, Math. Comp. 62, 1994); a block and the weights together are no longer than 2S, so nothing wraps.
struct Convolution {
    block: usize,
    /// e^(jπi/2S)
    twist: QuarterTurn,
    factors: Vec<Bins<f64>>,
    spectrum: Vec<Bins<f64>>,
}

impl Convolution {
    /// Convolution for records of at most `samples` samples.
    fn new(weights: &[f64], samples: usize) -> Self {
        let length = if BLOCK * weights.len() < samples {
            BLOCK * weights.len()
        } else {
            samples + weights.len()
        };
        let size = length.div_ceil(2).max(LANES).next_power_of_two();
        let twist = QuarterTurn::new(size);
        let mut convolution = Self {
            block: 2 * size - weights.len(),
            factors: factors_from(&twist),
            twist,
            spectrum: Vec::new(),
        };
        // The inverse transform is not scaled: 1/S goes in here.
        convolution.spectrum = convolution.transform(weights, |weight| weight / size as f64);
        convolution
    }

    /// Z of a function of up to 2S samples.
    fn transform(&self, x: &[f64], value: impl Fn(f64) -> f64) -> Vec<Bins<f64>> {
        let size = self.twist.size();
        let (early, late) = x.split_at(size.min(x.len()));
        let at = |x: &[f64], i: usize| x.get(i).map_or(0.0, |&x| value(x));
        let mut bins = Bins::collect(size, |i| {
            let ((cos, sin), re, im) = (self.twist.at(i), at(early, i), at(late, i));
            (re * cos - im * sin, re * sin + im * cos)
        });
        forward_all(&mut bins, &self.factors);
        bins
    }

    /// The first `x.len()` values of the convolution of x − x₀, where it is finite.
    fn of(&self, x: &[f64], reference: f64) -> Vec<f64> {
        let finite = |x: f64| Some(x - reference).filter(|x| x.is_finite()).unwrap_or(0.0);
        let mut y = vec![0.0; x.len()];
        for (index, block) in x.chunks(self.block).enumerate() {
            let mut bins = self.transform(block, finite);
            for (z, h) in bins.iter_mut().zip(&self.spectrum) {
                let mut product = Bins::default();
                product.add_product(z, h);
                *z = product;
            }
            inverse_all(&mut bins, &self.factors);
            self.add(&bins, &mut y[index * self.block..]);
        }
        y
    }

    /// Adds the first `y.len()` of the 2S values v·e^(−jπi/2S).
    fn add(&self, v: &[Bins<f64>], y: &mut [f64]) {
        let size = self.twist.size();
        let (early, late) = y.split_at_mut(size.min(y.len()));
        let mut late = late.iter_mut();
        for (i, early) in early.iter_mut().enumerate() {
            let (cos, sin) = self.twist.at(i);
            let (re, im) = (v[i / LANES].re[i % LANES], v[i / LANES].im[i % LANES]);
            *early += re * cos + im * sin;
            if let Some(late) = late.next() {
                *late += im * cos - re * sin;
            }
        }
    }
}
