//! Grünwald–Letnikov operator with a fixed memory of N samples (*short-memory principle*).

use crate::differintegrator::past_is_kept;
use crate::fir::FirHistory;
#[cfg(feature = "alloc")]
use crate::fir::Ring;
use crate::response::polynomial;
use crate::weights::grunwald_weights;
use crate::{Differintegrator, FrequencyResponse, Order, ParameterError, Real, Seconds};
use num_complex::Complex;

/// D^μ from the N newest samples, in a ring buffer.
/// ```text
/// y[n] = T^(−μ) · Σ_{j=0}^{N−1} c_j·x[n−j],    c₀ = 1,    c_j = c_{j−1}·(j − 1 − μ)/j
/// ```
/// - *Units*: μ 1, T s, N samples, x any unit \[x\], y \[x\]·s^(−μ).
/// - *Discretisation error*: O(T) for smooth x that starts from rest.
/// - *Truncation error*: for 0 < μ < 1 and |x| ≤ M at most M·T^(−μ)·Σ_{j<N} `c_j`, as all weights sum to 0 and only the first is above 0. It falls
///   only like N^(−μ): a small order and a long experiment need [`FullMemory`](crate::FullMemory). An integral (μ < 0) leaks everything older
///   than N samples.
/// - *Start-up*: zero for ever before the first sample.
/// - *Not finite*: a NaN or infinity spoils N outputs, its own first, and is then forgotten.
/// - *Cost*: `output` one multiply-add, `advance` N − 1 of them; memory 2N samples in the history
///   (each is kept twice, see the source) and N coefficients. No division, allocation or panic.
/// ```
/// use fracdiff::{Differintegrator, Order, Seconds, ShortMemory};
///
/// let half = ShortMemory::<f32, 256>::new(Order::new(0.5)?, Seconds(1e-3))?;
/// let mut x_axis = half.at_rest(); // one operator can serve several axes
/// let y = half.step(&mut x_axis, 1e-3); // m in, m·s^(−1/2) out
/// assert!((y - 0.031_623).abs() < 1e-6); // the first output is T^(−μ)·x
/// # Ok::<(), fracdiff::ParameterError>(())
/// ```
/// Source: I. Podlubny, *Fractional Differential Equations*, Academic Press, 1999, §7.3.
#[derive(Clone, Debug, PartialEq)]
pub struct ShortMemory<F, const N: usize> {
    rate: f64,
    taps: [F; N],
}

impl<F: Real, const N: usize> ShortMemory<F, N> {
    /// Computes the taps in `f64` and rounds each once. `N = 0` does not compile.
    ///
    /// # Errors
    /// [`ParameterError::SampleTime`] unless 1e-9 s ≤ T ≤ 1e6 s.
    pub fn new(order: Order, sample_time: Seconds) -> Result<Self, ParameterError> {
        const { assert!(N > 0, "the memory holds at least one sample") };
        let rate = sample_time.rate_to_the(order)?;
        let mut weights = grunwald_weights(order);
        let taps = core::array::from_fn(|_| {
            // The iterator never ends.
            F::from_f64(rate * weights.next().unwrap_or(0.0))
        });
        Ok(Self { rate, taps })
    }
}

impl<F: Real, const N: usize> Differintegrator<F> for ShortMemory<F, N> {
    type History = FirHistory<F, N>;

    fn at_rest(&self) -> Self::History {
        FirHistory::AT_REST
    }

    fn settled(&self, x: F) -> Option<Self::History> {
        Some(FirHistory::settled(&self.taps[1..], x))
    }

    past_is_kept!(taps[0]);

    #[inline]
    fn advance(&self, history: &mut Self::History, x: F) {
        // S[n+1] = Σ_{j=1}^{N−1} c_j·x[n+1−j]
        history.advance(&self.taps[1..], x);
    }

    #[inline]
    fn advance_many<const D: usize>(&self, histories: [&mut Self::History; D], x: [F; D]) {
        FirHistory::advance_many(histories, &self.taps[1..], x);
    }

    fn memory_length(&self) -> Option<usize> {
        Some(N)
    }
}

impl<F: Real, const N: usize> FrequencyResponse for ShortMemory<F, N> {
    fn response(&self, theta: f64) -> Complex<f64> {
        polynomial(self.taps.iter().map(|tap| tap.to_f64()), theta) / self.rate
    }
}

/// [`ShortMemory`] whose length is known only at run time; the history is on the heap.
///
/// Same numbers, bit for bit, as `ShortMemory<F, N>` with N = the length.
#[cfg(feature = "alloc")]
#[derive(Clone, Debug, PartialEq)]
pub struct ShortMemoryVec<F> {
    rate: f64,
    taps: alloc::vec::Vec<F>,
}

/// History of [`ShortMemoryVec`].
#[cfg(feature = "alloc")]
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "F: Real"))]
pub struct ShortHistoryVec<F> {
    ring: Ring<F>,
    past: F,
}

#[cfg(feature = "alloc")]
impl<F: Real> ShortMemoryVec<F> {
    /// Longest memory, samples: 2²⁰, 17 minutes at 1 kHz.
    pub const MOST: usize = 1 << 20;

    /// Operator like that of [`ShortMemory::new`], for `length` samples.
    ///
    /// # Errors
    /// [`ParameterError::SampleTime`] unless 1e-9 s ≤ T ≤ 1e6 s, [`ParameterError::Length`] unless 1 ≤ length ≤ [`MOST`](Self::MOST).
    pub fn new(order: Order, length: usize, sample_time: Seconds) -> Result<Self, ParameterError> {
        crate::order::check_length("memory length", length, Self::MOST)?;
        let rate = sample_time.rate_to_the(order)?;
        let taps = grunwald_weights(order)
            .take(length)
            .map(|weight| F::from_f64(rate * weight))
            .collect();
        Ok(Self { rate, taps })
    }

    /// The values of [`Form::Taps`](crate::portable::Form::Taps).
    #[cfg(feature = "std")]
    pub(crate) fn list(&self) -> alloc::vec::Vec<F> {
        self.taps.clone()
    }
}

#[cfg(feature = "alloc")]
impl<F: Real> Differintegrator<F> for ShortMemoryVec<F> {
    type History = ShortHistoryVec<F>;

    fn at_rest(&self) -> Self::History {
        ShortHistoryVec {
            ring: Ring::of(F::ZERO, self.taps.len()),
            past: F::ZERO,
        }
    }

    fn settled(&self, x: F) -> Option<Self::History> {
        let mut history = self.at_rest();
        history.ring = Ring::of(x, self.taps.len());
        self.advance(&mut history, x);
        Some(history)
    }

    past_is_kept!(taps[0]);

    fn advance(&self, history: &mut Self::History, x: F) {
        if history.ring.length() != self.taps.len() {
            // The history of another length: never a panic, and nothing that looks like a result.
            history.past = F::from_f64(f64::NAN);
            return;
        }
        history.past = history.ring.advance(&self.taps[1..], x);
    }

    fn advance_many<const D: usize>(&self, histories: [&mut Self::History; D], x: [F; D]) {
        let length = self.taps.len();
        if histories
            .iter()
            .all(|history| history.ring.length() == length)
        {
            let axes = histories.map(|history| {
                let (samples, newest) = history.ring.parts();
                (samples, newest, &mut history.past)
            });
            crate::fir::advance_many(axes, &self.taps[1..], x);
        } else {
            for (history, x) in histories.into_iter().zip(x) {
                self.advance(history, x);
            }
        }
    }

    fn memory_length(&self) -> Option<usize> {
        Some(self.taps.len())
    }
}

#[cfg(feature = "alloc")]
impl<F: Real> FrequencyResponse for ShortMemoryVec<F> {
    fn response(&self, theta: f64) -> Complex<f64> {
        polynomial(self.taps.iter().map(|tap| tap.to_f64()), theta) / self.rate
    }
}
