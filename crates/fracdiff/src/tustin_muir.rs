//! Recursive (infinite impulse response) operator from the Tustin rule and Muir polynomials.

use crate::integer_part::{IntegerHistory, WithIntegerPart, operator_from_its_core};
use crate::list::ListError;
use crate::muir::muir_split;
use crate::order::check_length;
use crate::response::polynomial;
use crate::{Differintegrator, FrequencyResponse, Order, ParameterError, Real, Seconds};
use num_complex::Complex;

/// D^μ ≈ (1 − w)^n T^(−n) · `(2/T)^φ·A_m(w, φ)/A_m(w, −φ)`, m ≤ N, where μ = n + φ and n is the integer part towards zero.
/// ```text
/// ((1 − w)/(1 + w))^φ = lim A_m(w, φ)/A_m(w, −φ),   m → ∞
/// y[k] = Σ_{i=0}^{m} b_i·x[k−i] − Σ_{i=1}^{m} a_i·y[k−i],   b = (2/T)^φ·A_m(φ),  a = A_m(−φ)
/// ```
/// - *Units*: as [`ShortMemory`](crate::ShortMemory).
/// - *Stable*: the reflection coefficients of `A_m(w, −φ)` are −φ/i, all inside (−1, 1), so its poles are too. This is why the integer part
///   is taken by differences (or sums): at |φ| ≥ 1 the recursion would ring for ever or grow.
/// - *Accuracy*: good in the middle of the band, from about π/m to π/2 rad/sample; at rest the gain is not zero but (4/(m + 1))^φ·Γ((1 +
///   φ)/2)/Γ((1 − φ)/2) for odd m and large, so it forgets a slow relaxation.
/// - *Start-up*: zero for ever before. *Not finite*: no output is finite until reset.
/// - *Cost*: `output` one multiply-add, `advance` 2m. Memory m samples.
///
/// Source: B. M. Vinagre, Y. Q. Chen, I. Petráš, J. Franklin Inst. 340, 2003, §4.
#[derive(Clone, Debug, PartialEq)]
pub struct TustinMuir<F, const N: usize>(WithIntegerPart<Recursion<F, N>>);

/// History of [`TustinMuir`].
pub type TustinMuirHistory<F, const N: usize> = IntegerHistory<F, RecursionHistory<F, N>>;

impl<F: Real, const N: usize> TustinMuir<F, N> {
    /// Degree m = N.
    ///
    /// # Errors
    /// As [`with_degree`](Self::with_degree).
    pub fn new(order: Order, sample_time: Seconds) -> Result<Self, ParameterError> {
        Self::with_degree(order, N, sample_time)
    }

    /// Degree m ≤ N, chosen at run time. Coefficients in `f64`, rounded once.
    ///
    /// # Errors
    /// [`ParameterError::Length`] unless 1 ≤ m ≤ N; [`ParameterError::SampleTime`].
    pub fn with_degree(
        order: Order,
        degree: usize,
        sample_time: Seconds,
    ) -> Result<Self, ParameterError> {
        check_length("polynomial degree", degree, N)?;
        let rate = sample_time.rate_to_the(order)?;
        let (integer, fraction) = order.split();
        // T^(−n)·(2/T)^φ = T^(−μ)·2^φ
        let gain = rate * libm::pow(2.0, fraction);
        let (b0, b) = muir_split::<N>(Order::new(fraction)?, degree);
        let (_, a) = muir_split::<N>(Order::new(-fraction)?, degree);
        let core = Recursion {
            rate,
            degree,
            direct: F::from_f64(gain * b0),
            forward: b.map(|b| F::from_f64(gain * b)),
            backward: a.map(F::from_f64),
        };
        Ok(Self(WithIntegerPart { integer, core }))
    }
}

operator_from_its_core!(TustinMuir<N>, TustinMuirHistory);

/// A recursive filter in transposed direct form II: `s_i` ← s_{i+1} + `b_i·x` − `a_i·y`, S = s₁.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Recursion<F, const N: usize> {
    rate: f64,
    degree: usize,
    direct: F,
    forward: [F; N],
    backward: [F; N],
}

impl<F: Real, const N: usize> Recursion<F, N> {
    /// From g, then b and a of each degree, all finite. The response is not to be asked for: the rate is not in the list.
    pub(crate) fn from_list(values: &[F]) -> Result<Self, ListError> {
        let (count, most) = (values.len(), 1 + 2 * N);
        let wrong = ListError::Count { count, most };
        let (&direct, rest) = values.split_first().ok_or(wrong)?;
        let (pairs, rest) = rest.as_chunks::<2>();
        if !rest.is_empty() || !(1..=N).contains(&pairs.len()) {
            return Err(wrong);
        }
        let mut recursion = Self {
            rate: 1.0,
            degree: pairs.len(),
            direct,
            forward: [F::ZERO; N],
            backward: [F::ZERO; N],
        };
        for (i, &[b, a]) in pairs.iter().enumerate() {
            recursion.forward[i] = b;
            recursion.backward[i] = a;
        }
        Ok(recursion)
    }

    /// Value `index` of the list that [`from_list`](Self::from_list) takes.
    pub(crate) fn value(&self, index: usize) -> Option<F> {
        if index == 0 {
            return Some(self.direct);
        }
        let (i, second) = ((index - 1) / 2, (index - 1) % 2 == 1);
        let list = if second {
            &self.backward
        } else {
            &self.forward
        };
        list[..self.degree.min(N)].get(i).copied()
    }
}

#[cfg(feature = "std")]
impl<F: Real, const N: usize> TustinMuir<F, N> {
    /// Integer part, and the values of [`Form::Recursion`](crate::portable::Form::Recursion).
    pub(crate) fn list(&self) -> (i32, std::vec::Vec<F>) {
        self.0.list(Recursion::value)
    }
}

/// The history of one signal in a recursive filter.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "F: Real"))]
pub struct RecursionHistory<F, const N: usize> {
    #[cfg_attr(feature = "serde", serde(with = "crate::saved"))]
    state: [F; N],
}

impl<F: Real, const N: usize> Differintegrator<F> for Recursion<F, N> {
    type History = RecursionHistory<F, N>;

    fn at_rest(&self) -> Self::History {
        RecursionHistory {
            state: [F::ZERO; N],
        }
    }

    fn settled(&self, x: F) -> Option<Self::History> {
        let sum = |first: F, rest: &[F; N]| rest.iter().fold(first, |sum, &c| sum + c);
        // The gain at rest, P(1): the poles are inside the circle, so the lower sum is not zero.
        let y = sum(self.direct, &self.forward) / sum(F::ONE, &self.backward) * x;
        let mut state = [F::ZERO; N];
        let mut next = F::ZERO;
        for i in (0..self.degree.min(N)).rev() {
            next += self.forward[i] * x - self.backward[i] * y;
            state[i] = next;
        }
        Some(RecursionHistory { state })
    }

    #[inline]
    fn direct_gain(&self) -> F {
        self.direct
    }

    #[inline]
    fn past(&self, history: &Self::History) -> F {
        history.state[0]
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, x: F) {
        let y = self.output(history, x);
        let state = &mut history.state;
        let degree = self.degree.min(N);
        // One state after the other: a vector of them would wait for the stores of the last sample that it spans. A core
        // without vectors spares the flash of a loop that is written out.
        let end = if cfg!(target_arch = "arm") { degree } else { N };
        for i in 0..end {
            if i >= degree {
                break;
            }
            let next = if i + 1 < degree {
                state[i + 1]
            } else {
                F::ZERO
            };
            state[i] = next + (self.forward[i] * x - self.backward[i] * y);
        }
    }

    fn memory_length(&self) -> Option<usize> {
        None
    }
}

impl<F: Real, const N: usize> FrequencyResponse for Recursion<F, N> {
    fn response(&self, theta: f64) -> Complex<f64> {
        let ratio = |first: F, rest: &[F; N]| {
            let all = core::iter::once(first).chain(*rest);
            polynomial(all.map(|c| c.to_f64()), theta)
        };
        ratio(self.direct, &self.forward) / (ratio(F::ONE, &self.backward) * self.rate)
    }
}
