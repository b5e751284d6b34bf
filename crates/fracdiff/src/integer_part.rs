//! Exact integer part of an order, wrapped around a core that does the fractional part.

use crate::real::add_compensated;
use crate::response::integer_difference;
use crate::{Differintegrator, FrequencyResponse, Real};
use num_complex::Complex;

/// D^(n+φ) from a core that does D^φ: n backward differences of the input, or −n accumulations of the output.
/// ```text
/// n ≥ 0:  y[n] = core(Δⁿ x)[n]          n < 0:  y[n] = y[n−1] + core(x)[n], once or twice
/// ```
/// The output is g·Δⁿx\[n\] + S\[n\], with the core's own g: differences are taken before anything is multiplied, so
/// that a large and slow x does not cancel against its own past. The running sums carry a compensation
/// word, so that a million small increments are not lost in `f32`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WithIntegerPart<C> {
    pub(crate) integer: i32,
    pub(crate) core: C,
}

/// History of the core; x\[n−1\] and its difference, or the running sums; S\[n\].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct IntegerHistory<F, H> {
    pub(crate) core: H,
    /// x\[n−1\] where differences are taken, else zero.
    base: F,
    /// x\[n−1\] − x\[n−2\] where second differences are taken, else zero.
    slope: F,
    /// Inner and outer running sum, each with its compensation word.
    sums: [(F, F); 2],
    past: F,
}

impl<F: Real, H> IntegerHistory<F, H> {
    /// Around a core's history at rest.
    #[inline]
    pub(crate) const fn at_rest(core: H) -> Self {
        Self {
            core,
            base: F::ZERO,
            slope: F::ZERO,
            sums: [(F::ZERO, F::ZERO); 2],
            past: F::ZERO,
        }
    }

    /// Δⁿx\[n\]; x itself where no differences are taken.
    #[inline]
    fn increment(&self, x: F) -> F {
        (x - self.base) - self.slope
    }
}

impl<F: Real, C: Differintegrator<F>> Differintegrator<F> for WithIntegerPart<C> {
    type History = IntegerHistory<F, C::History>;

    fn at_rest(&self) -> Self::History {
        IntegerHistory::at_rest(self.core.at_rest())
    }

    fn rest(&self, history: &mut Self::History) {
        self.core.rest(&mut history.core);
        (history.base, history.slope, history.past) = (F::ZERO, F::ZERO, F::ZERO);
        history.sums = [(F::ZERO, F::ZERO); 2];
    }

    fn settled(&self, x: F) -> Option<Self::History> {
        let rest = self.at_rest();
        if self.integer < 0 {
            return (x == F::ZERO).then_some(rest);
        }
        if self.integer > 0 {
            // No increments for ever.
            return Some(IntegerHistory { base: x, ..rest });
        }
        let core = self.core.settled(x)?;
        let past = self.core.past(&core);
        Some(IntegerHistory { core, past, ..rest })
    }

    #[inline]
    fn direct_gain(&self) -> F {
        self.core.direct_gain()
    }

    #[inline]
    fn past(&self, history: &Self::History) -> F {
        self.output(history, F::ZERO)
    }

    #[inline]
    fn output(&self, history: &Self::History, x: F) -> F {
        self.core.direct_gain() * history.increment(x) + history.past
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, x: F) {
        let input = self.before(history, x);
        self.core.advance(&mut history.core, input);
        self.after(history, x);
    }

    // A core in a loop of its own keeps the registers that it needs.
    fn process(&self, history: &mut Self::History, samples: &mut [F]) {
        for sample in samples {
            *sample = step_apart(self, history, *sample);
        }
    }

    #[inline]
    fn advance_many<const D: usize>(&self, mut histories: [&mut Self::History; D], x: [F; D]) {
        let inputs = core::array::from_fn(|axis| self.before(histories[axis], x[axis]));
        let cores = histories.each_mut().map(|history| &mut history.core);
        self.core.advance_many(cores, inputs);
        for (history, x) in histories.into_iter().zip(x) {
            self.after(history, x);
        }
    }

    fn memory_length(&self) -> Option<usize> {
        match self.integer {
            n @ 0.. => Some(self.core.memory_length()? + n.unsigned_abs() as usize),
            _ => None,
        }
    }
}

#[cfg(feature = "std")]
impl<C> WithIntegerPart<C> {
    /// Integer part, and the values of the core's list up to its end.
    pub(crate) fn list<F>(
        &self,
        value: impl Fn(&C, usize) -> Option<F>,
    ) -> (i32, std::vec::Vec<F>) {
        let values = (0..).map_while(|index| value(&self.core, index));
        (self.integer, values.collect())
    }
}

impl<C> WithIntegerPart<C> {
    /// The core's input for x\[n\]: its n-th difference, or itself; running sums take in the core's output.
    #[inline]
    fn before<F: Real>(&self, history: &mut IntegerHistory<F, C::History>, x: F) -> F
    where
        C: Differintegrator<F>,
    {
        if self.integer < 0 {
            let y = self.core.output(&history.core, x);
            let (sum, carry) = &mut history.sums[0];
            add_compensated(sum, carry, y);
        }
        history.increment(x)
    }

    /// x\[n\] becomes the past, and S\[n+1\] is made, once the core has advanced.
    #[inline]
    fn after<F: Real>(&self, history: &mut IntegerHistory<F, C::History>, x: F)
    where
        C: Differintegrator<F>,
    {
        if self.integer > 1 {
            history.slope = x - history.base;
        }
        if self.integer > 0 {
            history.base = x;
        }
        history.past = self.core.past(&history.core);
        if self.integer < 0 {
            let [(inner, _), (outer, carry)] = &mut history.sums;
            if self.integer < -1 {
                add_compensated(outer, carry, *inner);
            }
            history.past = (history.past + *inner) + *outer;
        }
    }
}

impl<C: FrequencyResponse> FrequencyResponse for WithIntegerPart<C> {
    fn response(&self, theta: f64) -> Complex<f64> {
        self.core.response(theta) * integer_difference(theta, self.integer)
    }
}

/// Makes a newtype around a [`WithIntegerPart`] an operator: all calls go inside.
macro_rules! operator_from_its_core {
    ($operator:ident<$($size:ident),+>, $history:ident) => {
        impl<F: $crate::Real, $(const $size: usize),+> $crate::Differintegrator<F>
            for $operator<F, $($size),+>
        {
            $crate::differintegrator::forward_differintegrator!(
                $history<F, $($size),+>, self => self.0, many
            );
        }

        impl<F: $crate::Real, $(const $size: usize),+> $crate::FrequencyResponse
            for $operator<F, $($size),+>
        {
            fn response(&self, theta: f64) -> num_complex::Complex<f64> {
                self.0.response(theta)
            }
        }
    };
}

pub(crate) use operator_from_its_core;

#[inline(never)]
fn step_apart<F: Real, O: Differintegrator<F>>(operator: &O, history: &mut O::History, x: F) -> F {
    operator.step(history, x)
}
