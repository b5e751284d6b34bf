//! A long finite memory at a fraction of its cost, the work spread evenly over the ticks.

mod level;

use crate::differintegrator::past_is_kept;
use crate::fir::Ring;
use crate::response::polynomial;
use crate::weights::grunwald_weights;
use crate::{
    Differintegrator, FrequencyResponse, Order, ParameterError, Real, Seconds, ShortMemoryVec,
};
use alloc::vec::Vec;
use level::{FIRST, Level, LevelHistory};
use num_complex::Complex;

/// Blocks grow by this factor from level to level.
const GROWTH: usize = 8;
/// A level that would take more partitions than this to reach the end leaves the rest to a next one.
const MOST_PARTITIONS: usize = 32;

/// D^μ from the N newest samples, as [`ShortMemoryVec`](crate::ShortMemoryVec), for long memories.
/// ```text
/// y[n] = T^(−μ) · Σ_{j=0}^{N−1} c_j·x[n−j]
///        j < 64 directly;  64 ≤ j < 512 in blocks of 32;  < 4096 of 256;  < 32 768 of 2048;  …  by FFT
/// ```
/// - *Units, start-up, truncation*: as [`ShortMemory`](crate::ShortMemory).
/// - *Accuracy*: not its bits, but the same weights: outputs within 1e-14 (`f64`) of what is summed in
///   magnitude, T^(−μ)·Σ|`c_j`|·max|x|, and in `f32` as near to the truth. Same bits on every target.
/// - *Not finite*: a NaN or infinity spoils N outputs, its own first, and fewer than two blocks of the
///   last level more; never as many as 2N in a memory of more than 64.
/// - *Cost*: `output` one multiply-add; `advance` 63 of them and for each level some 100 to 200. Each tick
///   does the same share of the transforms, so the worst takes two to three times the mean. Memory some 4N
///   numbers and 8 a tick of the last block; allocates in `new` and `at_rest` only. No division, no panic.
///
/// Source: W. G. Gardner, *Efficient convolution without input-output delay*, J. Audio Eng. Soc. 43
/// (3), 1995; here the transforms themselves are spread over the ticks.
#[derive(Clone, Debug, PartialEq)]
pub struct PartitionedMemory<F> {
    order: Order,
    rate: f64,
    length: usize,
    /// Taps of lags 0 to 63.
    head: Vec<F>,
    levels: Vec<Level<F>>,
}

/// History of [`PartitionedMemory`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "F: Real"))]
pub struct PartitionedHistory<F> {
    ring: Ring<F>,
    #[cfg_attr(feature = "serde", serde(deserialize_with = "level::whole"))]
    levels: Vec<LevelHistory<F>>,
    past: F,
}

impl<F: Real> PartitionedMemory<F> {
    /// As [`ShortMemoryVec::new`](crate::ShortMemoryVec::new).
    ///
    /// # Errors
    /// [`ParameterError::SampleTime`] unless 1e-9 s ≤ T ≤ 1e6 s, [`ParameterError::Length`] unless 1 ≤ length ≤ [`ShortMemoryVec::MOST`].
    pub fn new(order: Order, length: usize, sample_time: Seconds) -> Result<Self, ParameterError> {
        crate::order::check_length("memory length", length, ShortMemoryVec::<F>::MOST)?;
        let rate = sample_time.rate_to_the(order)?;
        let weights = grunwald_weights(order).take(length);
        let taps: Vec<f64> = weights.map(|weight| rate * weight).collect();
        let mut levels = Vec::new();
        let mut block = FIRST;
        while 2 * block < length {
            let left = &taps[2 * block..];
            let wanted = left.len().div_ceil(block);
            if wanted <= MOST_PARTITIONS {
                levels.push(Level::new(block, left));
                break;
            }
            levels.push(Level::new(block, &left[..2 * (GROWTH - 1) * block]));
            block *= GROWTH;
        }
        let head = taps.iter().take(2 * FIRST);
        Ok(Self {
            order,
            rate,
            length,
            head: head.map(|&tap| F::from_f64(tap)).collect(),
            levels,
        })
    }
}

#[cfg(feature = "std")]
impl<F: Real> PartitionedMemory<F> {
    /// The values of [`Form::Taps`](crate::portable::Form::Taps), rounded as [`ShortMemoryVec`] rounds them.
    pub(crate) fn list(&self) -> Vec<F> {
        let weights = grunwald_weights(self.order).take(self.length);
        weights.map(|c| F::from_f64(self.rate * c)).collect()
    }
}

impl<F: Real> Differintegrator<F> for PartitionedMemory<F> {
    type History = PartitionedHistory<F>;

    fn at_rest(&self) -> Self::History {
        PartitionedHistory {
            ring: Ring::of(F::ZERO, self.head.len()),
            levels: self.levels.iter().map(Level::at_rest).collect(),
            past: F::ZERO,
        }
    }

    fn settled(&self, x: F) -> Option<Self::History> {
        let mut history = self.at_rest();
        // All samples, and the two blocks that the last level is behind.
        for _ in 0..3 * self.length {
            self.advance(&mut history, x);
        }
        Some(history)
    }

    past_is_kept!(head[0]);

    fn advance(&self, history: &mut Self::History, x: F) {
        let levels = self.levels.iter().zip(&mut history.levels);
        if history.ring.length() != self.head.len() || self.levels.len() != levels.len() {
            // The history of another length: never a panic, and nothing that looks like a result.
            history.past = F::from_f64(f64::NAN);
            return;
        }
        let mut past = F::ZERO;
        // Smallest first: the oldest samples have the smallest weights.
        for (level, own) in levels.rev() {
            if !level.fits(own) {
                history.past = F::from_f64(f64::NAN);
                return;
            }
            past += level.advance(own, x);
        }
        history.past = past + history.ring.advance(&self.head[1..], x);
    }

    fn memory_length(&self) -> Option<usize> {
        Some(self.length)
    }
}

impl<F: Real> FrequencyResponse for PartitionedMemory<F> {
    /// Of the taps rounded to the sample type, as [`ShortMemoryVec`] holds them.
    fn response(&self, theta: f64) -> Complex<f64> {
        let weights: Vec<f64> = grunwald_weights(self.order).take(self.length).collect();
        let taps = weights.iter().map(|c| F::from_f64(self.rate * c).to_f64());
        polynomial(taps, theta) / self.rate
    }
}
