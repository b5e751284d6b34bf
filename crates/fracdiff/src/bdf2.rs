//! Full memory of second order in the sample time: fractional BDF2.

use crate::differintegrator::past_is_kept;
use crate::fir::{Fir, FirHistory};
use crate::full_memory::{Design, FullMemory, FullMemoryHistory, PORTABLE_TAPS};
use crate::list::ListError;
use crate::{Differintegrator, FrequencyResponse, Order, ParameterError, Real, Seconds};
use num_complex::Complex;

/// Taps of the short filter. The weights left off sum to less than 1e-12 of all, for −2 ≤ μ ≤ 2.
pub const BDF2_TAPS: usize = 28;

/// Weights of ((3 − w)/2)^μ, the short factor of [`Bdf2Memory`]: `f_j = 1.5^μ·c_j(μ)·3^(−j)`.
#[must_use]
pub fn bdf2_short_filter(order: Order) -> [f64; BDF2_TAPS] {
    let mu = order.get();
    let mut weight = libm::pow(1.5, mu);
    let mut lag = 0.0;
    core::array::from_fn(|_| {
        let this = weight;
        lag += 1.0;
        weight *= (lag - 1.0 - mu) / (3.0 * lag);
        this
    })
}

/// D^μ with the whole history and an error that falls with T²: a [`FullMemory`], then a short filter.
/// ```text
/// P(w) = (3/2 − 2w + w²/2)^μ = (1 − w)^μ·((3 − w)/2)^μ
/// z[n] = FullMemory(x)[n],   y[n] = Σ_{j<28} f_j·z[n−j],   f_j = 1.5^μ·c_j(μ)·3^(−j)
/// ```
/// - *Units*: x any unit \[x\], y \[x\]·s^(−μ), T s. *Start-up*: zero for ever before.
/// - *Convergence*: O(T²) for a signal that starts smoothly. A step lies between two samples: halve its first sample.
/// - *Accuracy*: |error| ≤ `ε·Σ|f_i|` times the bound of the full memory, and `Σ|f_i|` ≤ 2·1.5^μ − 1 for 0 ≤ μ ≤ 1; with
///   1e-12 for the taps left off.
/// - *Passive*: Re P ≥ 0 on the circle for 0 < μ ≤ 1, as of any A-stable formula; of the weights held, to ε.
/// - *At rest, not finite*: as [`FullMemory`].
/// - *Cost*: `output` as [`FullMemory`] and a multiply-add; `advance` 27 multiply-adds more.
/// ```
/// use fracdiff::full_memory::{Design, Kernel};
/// use fracdiff::{Bdf2Memory, Channel, Order, Seconds};
///
/// let design = Design::<16, 48>::closed_form(Kernel::Grunwald, Order::new(0.5)?, 1e-8, 1e4)?;
/// let mut half = Channel::new(Bdf2Memory::<f64, 16, 48>::new(&design, Seconds(1e-3))?);
/// // The half derivative of t² is t^1.5·Γ(3)/Γ(2.5).
/// let y = (0..=1000).map(|n| half.step((f64::from(n) * 1e-3).powi(2))).last().unwrap();
/// assert!((y - 2.0 / 1.329_340_388_179_137).abs() < 3e-6); // the plain kernel: 6e-4
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
/// Source: Ch. Lubich, *Discretized fractional calculus*, SIAM J. Math. Anal. 17, 1986.
#[derive(Clone, Debug, PartialEq)]
pub struct Bdf2Memory<F, const TAPS: usize, const MODES: usize> {
    memory: FullMemory<F, TAPS, MODES>,
    filter: Fir<F, BDF2_TAPS>,
    direct: F,
}

/// History of [`Bdf2Memory`]: that of the full memory, that of the short filter, and S\[n\].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "F: Real"))]
pub struct Bdf2History<F, const TAPS: usize, const MODES: usize> {
    memory: FullMemoryHistory<F, TAPS, MODES>,
    filter: FirHistory<F, BDF2_TAPS>,
    past: F,
}

impl<F: Real, const TAPS: usize, const MODES: usize> Bdf2Memory<F, TAPS, MODES> {
    /// An operator from a design of the Grünwald kernel, which also gives the order. Coefficients
    /// in `f64`, rounded once.
    ///
    /// # Errors
    /// [`ParameterError::SampleTime`] unless 1e-9 s ≤ T ≤ 1e6 s.
    pub fn new(design: &Design<TAPS, MODES>, sample_time: Seconds) -> Result<Self, ParameterError> {
        let memory = FullMemory::new(design, sample_time)?;
        let filter = Fir::of(bdf2_short_filter(design.order()).map(F::from_f64));
        Ok(Self::of(memory, filter))
    }

    fn of(memory: FullMemory<F, TAPS, MODES>, filter: Fir<F, BDF2_TAPS>) -> Self {
        let direct = filter.direct_gain() * memory.direct_gain();
        Self {
            memory,
            filter,
            direct,
        }
    }

    /// The full memory, and the coefficients of the filter behind it.
    #[cfg(feature = "std")]
    pub(crate) fn parts(&self) -> (&FullMemory<F, TAPS, MODES>, &[F]) {
        (&self.memory, self.filter.coefficients())
    }

    /// S\[n\] of the two in series.
    #[inline]
    fn both(&self, history: &Bdf2History<F, TAPS, MODES>) -> F {
        self.filter
            .output(&history.filter, self.memory.past(&history.memory))
    }
}

impl<F: Real, const MODES: usize> Bdf2Memory<F, PORTABLE_TAPS, MODES> {
    /// Builds the operator from its full memory's list and its filter's coefficients, as an
    /// [`OperatorList`](crate::OperatorList) has them: it gives the same bits as the original
    /// operator, without the design.
    ///
    /// # Errors
    /// As [`FullMemory::from_list`]; a filter without coefficients, with more than [`BDF2_TAPS`], or with one that is not finite.
    pub fn from_list(integer: i8, values: &[F], filter: &[F]) -> Result<Self, ListError> {
        let memory = FullMemory::from_list(integer, values)?;
        Ok(Self::of(memory, Fir::from_slice(filter)?))
    }
}

impl<F: Real, const TAPS: usize, const MODES: usize> Differintegrator<F>
    for Bdf2Memory<F, TAPS, MODES>
{
    type History = Bdf2History<F, TAPS, MODES>;

    fn at_rest(&self) -> Self::History {
        Bdf2History {
            memory: self.memory.at_rest(),
            filter: self.filter.at_rest(),
            past: F::ZERO,
        }
    }

    fn settled(&self, x: F) -> Option<Self::History> {
        let memory = self.memory.settled(x)?;
        let filter = self.filter.settled(self.memory.output(&memory, x))?;
        let mut history = Bdf2History {
            memory,
            filter,
            past: F::ZERO,
        };
        history.past = self.both(&history);
        Some(history)
    }

    past_is_kept!(direct);

    #[inline]
    fn output(&self, history: &Self::History, x: F) -> F {
        let z = self.memory.output(&history.memory, x);
        self.filter.output(&history.filter, z)
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, x: F) {
        let z = self.memory.output(&history.memory, x);
        self.memory.advance(&mut history.memory, x);
        self.filter.advance(&mut history.filter, z);
        history.past = self.both(history);
    }

    #[inline]
    fn advance_many<const D: usize>(&self, mut histories: [&mut Self::History; D], x: [F; D]) {
        let z: [F; D] =
            core::array::from_fn(|axis| self.memory.output(&histories[axis].memory, x[axis]));
        let memories = histories.each_mut().map(|history| &mut history.memory);
        self.memory.advance_many(memories, x);
        for (history, z) in histories.into_iter().zip(z) {
            self.filter.advance(&mut history.filter, z);
            history.past = self.both(history);
        }
    }

    fn memory_length(&self) -> Option<usize> {
        // Two in series reach one sample less than both together.
        Some(self.memory.memory_length()? + self.filter.memory_length()? - 1)
    }
}

impl<F: Real, const TAPS: usize, const MODES: usize> FrequencyResponse
    for Bdf2Memory<F, TAPS, MODES>
{
    fn response(&self, theta: f64) -> Complex<f64> {
        self.memory.response(theta) * self.filter.response(theta)
    }
}
