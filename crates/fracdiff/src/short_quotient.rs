//! Quotient of two sums over the newest samples: elements in series with short memories.

use crate::order::check_length;
use crate::response::polynomial;
use crate::{
    Differintegrator, FrequencyResponse, Order, ParameterError, Real, Seconds, ShortMemoryVec,
};
use alloc::vec;
use alloc::vec::Vec;
use num_complex::Complex;

/// B(w)/A(w)·T^(−μ), where both sums reach N samples back; on the heap.
/// ```text
/// y[n] = b₀·x[n] + s₁        s_i ← s_{i+1} + (b_i·x − a_i·y), 1 ≤ i < N        b = T^(−μ)·B/A₀,  a = A/A₀
/// ```
/// What a model of spring-pots in series becomes, each of which remembers N samples: the output hears its own past too.
/// - *Stable*: A₀ > Σ|`A_j`|, 1 ≤ j < N, is asked for. Sums and products of Grünwald–Letnikov weights of orders from 0 to 1 keep it.
/// - *Units*: as [`ShortMemory`](crate::ShortMemory). It runs as its list does in [`PortableOperator`](crate::PortableOperator), to the bit.
/// - *Start-up*: zero for ever before. *Not finite*: no output is finite until reset.
/// - *Cost*: `output` one addition and multiplication, `advance` 2N of them; memory N samples in the history.
/// ```
/// use fracdiff::{Differintegrator, Order, Seconds, ShortQuotient};
///
/// // A dashpot of 0.1 s in series with a spring: s/(s + 10) as (1 − w)/(1 + 10·T − w), T = 0.01 s.
/// let sums = [&[1.0, -1.0][..], &[1.1, -1.0]];
/// let maxwell = ShortQuotient::<f64>::new(Order::new(0.0)?, sums, Seconds(0.01))?;
/// let mut history = maxwell.at_rest();
/// let first = maxwell.step(&mut history, 1.0);
/// assert!((maxwell.step(&mut history, 1.0) - first / 1.1).abs() < 1e-15);
/// # Ok::<(), fracdiff::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ShortQuotient<F> {
    rate: f64,
    direct: F,
    /// `b_i` and `a_i` from i = 1 on; at least one pair.
    pairs: Vec<[F; 2]>,
}

/// History of [`ShortQuotient`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "F: Real"))]
pub struct ShortQuotientHistory<F> {
    state: Vec<F>,
}

impl<F: Real> ShortQuotient<F> {
    /// The quotient of an order μ from B and A in powers of w. Divided in `f64` and rounded once.
    ///
    /// # Errors
    /// [`ParameterError::Length`] unless both have 1 to 2²⁰ coefficients; [`ParameterError::SampleTime`]; [`ParameterError::Quotient`] unless
    /// all are finite and A₀ is above the sum of the sizes of those after it.
    pub fn new(
        order: Order,
        [above, below]: [&[f64]; 2],
        sample_time: Seconds,
    ) -> Result<Self, ParameterError> {
        for coefficients in [above, below] {
            check_length(
                "memory length",
                coefficients.len(),
                ShortMemoryVec::<F>::MOST,
            )?;
        }
        let rate = sample_time.rate_to_the(order)?;
        let size = |values: &[f64]| {
            values
                .iter()
                .fold(0.0, |sum, value| sum + libm::fabs(*value))
        };
        let (newest, others) = (below[0], size(&below[1..]));
        // False of a NaN, too.
        if !(newest > others && size(above).is_finite() && newest.is_finite()) {
            return Err(ParameterError::Quotient { newest, others });
        }
        let at = |values: &[f64], index: usize| values.get(index).copied().unwrap_or(0.0) / newest;
        let length = above.len().max(below.len()).max(2);
        let pair = |index| [rate * at(above, index), at(below, index)].map(F::from_f64);
        Ok(Self {
            rate,
            direct: F::from_f64(rate * at(above, 0)),
            pairs: (1..length).map(pair).collect(),
        })
    }

    /// The values of [`Form::Recursion`](crate::portable::Form::Recursion).
    #[cfg(feature = "std")]
    pub(crate) fn list(&self) -> Vec<F> {
        let older = self.pairs.as_flattened().iter().copied();
        core::iter::once(self.direct).chain(older).collect()
    }
}

impl<F: Real> Differintegrator<F> for ShortQuotient<F> {
    type History = ShortQuotientHistory<F>;

    fn at_rest(&self) -> Self::History {
        let state = vec![F::ZERO; self.pairs.len()];
        ShortQuotientHistory { state }
    }

    fn settled(&self, x: F) -> Option<Self::History> {
        let sum = |first: F, which: usize| self.pairs.iter().fold(first, |sum, c| sum + c[which]);
        let y = sum(self.direct, 0) / sum(F::ONE, 1) * x;
        let (mut history, mut next) = (self.at_rest(), F::ZERO);
        for (state, [b, a]) in history.state.iter_mut().zip(&self.pairs).rev() {
            next += *b * x - *a * y;
            *state = next;
        }
        Some(history)
    }

    #[inline]
    fn direct_gain(&self) -> F {
        self.direct
    }

    #[inline]
    fn past(&self, history: &Self::History) -> F {
        // The history of another length: never a panic, and nothing that looks like a result.
        let own = (history.state.first()).filter(|_| history.state.len() == self.pairs.len());
        own.copied().unwrap_or(F::from_f64(f64::NAN))
    }

    fn advance(&self, history: &mut Self::History, x: F) {
        let y = self.output(history, x);
        let mut next = F::ZERO;
        let older = history.state.iter_mut().zip(&self.pairs).rev();
        for (state, &[b, a]) in older {
            next = core::mem::replace(state, next + (b * x - a * y));
        }
    }

    fn memory_length(&self) -> Option<usize> {
        None
    }
}

impl<F: Real> FrequencyResponse for ShortQuotient<F> {
    fn response(&self, theta: f64) -> Complex<f64> {
        let column = |first: f64, which: usize| {
            let older = self.pairs.iter().map(|pair| pair[which].to_f64());
            polynomial(core::iter::once(first).chain(older), theta)
        };
        column(self.direct.to_f64(), 0) / column(1.0, 1) / self.rate
    }
}
