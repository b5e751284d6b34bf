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
/// A_m(w, φ) = A_m(−w, −φ), so b_i = (−1)^i·g·a_i,  g = b₀:   a alone is kept
/// s_i ← s_{i+1} − a_i·(s₁ + [i odd]·2x)                       y[k] = g·x[k] + g·s₁
/// ```
/// - *Units*: as [`ShortMemory`](crate::ShortMemory).
/// - *Stable*: the reflection coefficients of `A_m(w, −φ)` are −φ/i, all inside (−1, 1), so its poles are too. This is why the integer part
///   is taken by differences (or sums): at |φ| ≥ 1 the recursion would ring for ever or grow.
/// - *Accuracy*: good in the middle of the band, from about π/m to π/2 rad/sample; at rest the gain is not zero but (4/(m + 1))^φ·Γ((1 +
///   φ)/2)/Γ((1 − φ)/2) for odd m and large, so it forgets a slow relaxation.
/// - *Start-up*: zero for ever before. *Not finite*: no output is finite until reset.
/// - *Cost*: `output` one multiply-add, `advance` m + 1 multiplications. Memory m samples.
///
/// Source: B. M. Vinagre, Y. Q. Chen, I. Petráš, J. Franklin Inst. 340, 2003, §4.
#[derive(Clone, Debug, PartialEq)]
pub struct TustinMuir<F, const N: usize>(WithIntegerPart<Mirrored<F, N>>);

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
        let (_, a) = muir_split::<N>(Order::new(-fraction)?, degree);
        let core = Mirrored {
            rate,
            degree,
            direct: F::from_f64(gain),
            backward: a.map(F::from_f64),
        };
        Ok(Self(WithIntegerPart { integer, core }))
    }
}

operator_from_its_core!(TustinMuir<N>, TustinMuirHistory);

/// A recursive filter whose zeros are its poles with the other sign, `b_i` = (−1)^i·g·`a_i`, in transposed direct form II.
/// ```text
/// y = g·(x + s₁):   b_i·x − a_i·y = −g·a_i·(s₁ + 2x) for odd i,  −g·a_i·s₁ for even i
/// ```
/// The states have the unit of x, so that g is outside the loop: 2x is exact, where the rounding of 2g·x would go round in it and be up to
/// three times as large in `f32` at orders of 0.9. Half the multiplications of free coefficients.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mirrored<F, const N: usize> {
    rate: f64,
    degree: usize,
    direct: F,
    backward: [F; N],
}

/// A coefficient of w^(index + 1) with the sign it has in A(−w).
#[inline]
fn mirrored<F: Real>(index: usize, coefficient: F) -> F {
    if index.is_multiple_of(2) {
        -coefficient
    } else {
        coefficient
    }
}

/// −`a_i`·(z + \[i odd\]·2x), by index i − 1 and `a_i`, for s₁ = z.
#[inline]
fn fed<F: Real>(z: F, x: F) -> impl Fn(usize, F) -> F {
    let odd = z + (x + x);
    move |index, a| -(a * if index.is_multiple_of(2) { odd } else { z })
}

/// s₁ of a mirrored filter that has settled: −Σ `a_i`·(s₁ + \[i odd\]·2x). The poles are inside the circle, so 1 + Σ `a_i` is not zero.
fn settled_at<F: Real>(a: impl Iterator<Item = F> + Clone, x: F) -> F {
    let odd = a.clone().step_by(2).fold(F::ZERO, |sum, a| sum + a);
    -(odd / a.fold(F::ONE, |sum, a| sum + a) * (x + x))
}

#[cfg(feature = "std")]
impl<F: Real, const N: usize> TustinMuir<F, N> {
    /// Integer part, and the values of [`Form::Recursion`](crate::portable::Form::Recursion).
    pub(crate) fn list(&self) -> (i32, std::vec::Vec<F>) {
        let WithIntegerPart { integer, core } = &self.0;
        let a = core.backward[..core.degree].iter().enumerate();
        let pairs = a.flat_map(|(i, &a)| [mirrored(i, core.direct * a), a]);
        let values = core::iter::once(core.direct).chain(pairs);
        (*integer, values.collect())
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

impl<F: Real, const N: usize> RecursionHistory<F, N> {
    const AT_REST: Self = Self {
        state: [F::ZERO; N],
    };

    /// `s_i` ← s_{i+1} + what is fed to it, by its index and coefficients; s_{degree+1} = 0.
    #[inline]
    fn advance<C: Copy>(
        &mut self,
        degree: usize,
        coefficients: &[C; N],
        fed: impl Fn(usize, C) -> F,
    ) {
        let degree = degree.min(N);
        if cfg!(target_arch = "arm") {
            // A core without vectors spares the flash of a loop that is written out. From the last on, what follows a state is at hand.
            let mut next = F::ZERO;
            let pairs = self.state[..degree].iter_mut().zip(&coefficients[..degree]);
            for (i, (state, c)) in pairs.enumerate().rev() {
                next = core::mem::replace(state, next + fed(i, *c));
            }
            return;
        }
        // One state after the other: a vector of them would wait for the stores of the last sample that it spans. In pairs, so that a
        // loop that is not written out knows which is odd.
        for pair in 0..N.div_ceil(2) {
            for i in [2 * pair, 2 * pair + 1] {
                if i >= degree {
                    return;
                }
                let next = if i + 1 < degree {
                    self.state[i + 1]
                } else {
                    F::ZERO
                };
                self.state[i] = next + fed(i, coefficients[i]);
            }
        }
    }

    /// States that stay as they are while this is fed to them: each is the sum from its own place to the end.
    fn standing<C: Copy>(coefficients: &[C], fed: impl Fn(usize, C) -> F) -> Self {
        let (mut history, mut next) = (Self::AT_REST, F::ZERO);
        let pairs = coefficients.iter().zip(&mut history.state);
        for (i, (c, state)) in pairs.enumerate().rev() {
            next += fed(i, *c);
            *state = next;
        }
        history
    }
}

impl<F: Real, const N: usize> Differintegrator<F> for Mirrored<F, N> {
    type History = RecursionHistory<F, N>;

    fn at_rest(&self) -> Self::History {
        RecursionHistory::AT_REST
    }

    fn settled(&self, x: F) -> Option<Self::History> {
        let z = settled_at(self.backward.iter().copied(), x);
        Some(RecursionHistory::standing(&self.backward, fed(z, x)))
    }

    #[inline]
    fn direct_gain(&self) -> F {
        self.direct
    }

    #[inline]
    fn past(&self, history: &Self::History) -> F {
        self.direct * history.state[0]
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, x: F) {
        let fed = fed(history.state[0], x);
        history.advance(self.degree, &self.backward, fed);
    }

    fn memory_length(&self) -> Option<usize> {
        None
    }
}

impl<F: Real, const N: usize> FrequencyResponse for Mirrored<F, N> {
    fn response(&self, theta: f64) -> Complex<f64> {
        let a = self.backward.map(Real::to_f64);
        let b = core::array::from_fn(|i| mirrored(i, a[i]));
        let all = |rest: [f64; N]| polynomial(core::iter::once(1.0).chain(rest), theta);
        all(b) * self.direct.to_f64() / (all(a) * self.rate)
    }
}

/// A recursive filter from a list: mirrored where its b are, else of coefficients of any origin, `s_i` ← s_{i+1} + `b_i·x` − `a_i·y`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Recursion<F, const N: usize> {
    degree: usize,
    direct: F,
    /// b and a of each degree, then zeros.
    pairs: [[F; 2]; N],
    /// Each b is −g·a₁, g·a₂, … to the last bit.
    is_mirrored: bool,
    /// Output of s₁: g where it is mirrored, else 1.
    scale: F,
}

impl<F: Real, const N: usize> Recursion<F, N> {
    /// No output, until it is [filled](Self::fill).
    pub(crate) const SILENT: Self = Self {
        degree: 0,
        direct: F::ZERO,
        pairs: [[F::ZERO; 2]; N],
        is_mirrored: false,
        scale: F::ZERO,
    };

    /// Accepts g, then b and a of 1 to N degrees.
    pub(crate) fn check(values: &[F]) -> Result<(), ListError> {
        let (count, most) = (values.len(), 1 + 2 * N);
        if count % 2 == 1 && (3..=most).contains(&count) {
            Ok(())
        } else {
            Err(ListError::Count { count, most })
        }
    }

    /// Takes the list in, which was checked and is finite, where there was silence.
    pub(crate) fn fill(&mut self, values: &[F]) {
        let Some((&direct, rest)) = values.split_first() else {
            return;
        };
        let (pairs, _) = rest.as_chunks();
        (self.degree, self.direct) = (pairs.len(), direct);
        (self.scale, self.is_mirrored) = (direct, true);
        for (i, (to, &[b, a])) in self.pairs.iter_mut().zip(pairs).enumerate() {
            *to = [b, a];
            if b != mirrored(i, direct * a) {
                (self.scale, self.is_mirrored) = (F::ONE, false);
            }
        }
    }

    /// Value `index` of the list that [`fill`](Self::fill) takes.
    pub(crate) fn value(&self, index: usize) -> Option<F> {
        let Some(index) = index.checked_sub(1) else {
            return Some(self.direct);
        };
        let pairs = &self.pairs[..self.degree.min(N)];
        pairs.as_flattened().get(index).copied()
    }
}

impl<F: Real, const N: usize> Differintegrator<F> for Recursion<F, N> {
    type History = RecursionHistory<F, N>;

    fn at_rest(&self) -> Self::History {
        RecursionHistory::AT_REST
    }

    fn settled(&self, x: F) -> Option<Self::History> {
        let column = |which: usize| self.pairs.iter().map(move |pair| pair[which]);
        Some(if self.is_mirrored {
            let fed = fed(settled_at(column(1), x), x);
            RecursionHistory::standing(&self.pairs, |i, [_, a]| fed(i, a))
        } else {
            // The gain at rest, P(1): the poles are inside the circle, so the lower sum is not zero.
            let sum = |first: F, which| column(which).fold(first, |sum, c| sum + c);
            let y = sum(self.direct, 0) / sum(F::ONE, 1) * x;
            RecursionHistory::standing(&self.pairs, |_, [b, a]| b * x - a * y)
        })
    }

    #[inline]
    fn direct_gain(&self) -> F {
        self.direct
    }

    #[inline]
    fn past(&self, history: &Self::History) -> F {
        self.scale * history.state[0]
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, x: F) {
        if self.is_mirrored {
            let fed = fed(history.state[0], x);
            history.advance(self.degree, &self.pairs, |i, [_, a]| fed(i, a));
        } else {
            let y = self.direct * x + history.state[0];
            history.advance(self.degree, &self.pairs, |_, [b, a]| b * x - a * y);
        }
    }

    fn memory_length(&self) -> Option<usize> {
        None
    }
}
