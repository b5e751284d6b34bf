//! Exact integer part of an order, wrapped around a core that does the fractional part.

use crate::real::add_compensated;
use crate::response::integer_difference;
use crate::{Differintegrator, FrequencyResponse, Real};
use num_complex::Complex;

/// D^(n+φ) from a core that does D^φ: n backward differences of the input, or −n accumulations of
/// the output.
///
/// ```text
/// n ≥ 0:  y[n] = core(Δⁿ x)[n]          n < 0:  y[n] = y[n−1] + core(x)[n], once or twice
/// ```
/// Both leave y\[n\] = g·x\[n\] + S\[n\] with the core's own g. The running sums carry a compensation
/// word, so that a million small increments are not lost in `f32`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WithIntegerPart<C> {
    pub(crate) integer: i32,
    pub(crate) core: C,
}

/// History of the core; x\[n−1\], x\[n−2\] or the running sums; S\[n\].
#[derive(Clone, Debug, PartialEq)]
pub struct IntegerHistory<F, H> {
    pub(crate) core: H,
    /// Differences: the two newest samples. Accumulations: inner and outer sum.
    words: [F; 2],
    carries: [F; 2],
    past: F,
}

impl<F: Real, C: Differintegrator<F>> Differintegrator<F> for WithIntegerPart<C> {
    type History = IntegerHistory<F, C::History>;

    fn at_rest(&self) -> Self::History {
        IntegerHistory {
            core: self.core.at_rest(),
            words: [F::ZERO; 2],
            carries: [F::ZERO; 2],
            past: F::ZERO,
        }
    }

    #[inline]
    fn direct_gain(&self) -> F {
        self.core.direct_gain()
    }

    #[inline]
    fn past(&self, history: &Self::History) -> F {
        history.past
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, x: F) {
        let input = self.before(history, x);
        self.core.advance(&mut history.core, input);
        self.after(history, x);
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

impl<C> WithIntegerPart<C> {
    /// What the core takes in for x\[n\]: its n-th difference, or itself; running sums take in the core's output.
    #[inline]
    fn before<F: Real>(&self, history: &mut IntegerHistory<F, C::History>, x: F) -> F
    where
        C: Differintegrator<F>,
    {
        let [first, second] = &mut history.words;
        match self.integer {
            0 => x,
            1 => x - *first,
            2 => (x - *first) - (*first - *second),
            _ => {
                let y = self.core.output(&history.core, x);
                add_compensated(first, &mut history.carries[0], y);
                x
            }
        }
    }

    /// S\[n+1\], once the core has advanced.
    #[inline]
    fn after<F: Real>(&self, history: &mut IntegerHistory<F, C::History>, x: F)
    where
        C: Differintegrator<F>,
    {
        let gain = self.core.direct_gain();
        let past = self.core.past(&history.core);
        let [first, second] = &mut history.words;
        history.past = match self.integer {
            0 => past,
            1 => {
                *first = x;
                // g·(x − x[n−1]) + S = g·x + (S − g·x[n−1])
                past - gain * *first
            }
            2 => {
                *second = *first;
                *first = x;
                past - gain * (*first + (*first - *second))
            }
            -2 => {
                let inner = past + *first;
                add_compensated(second, &mut history.carries[1], *first);
                inner + *second
            }
            _ => past + *first,
        };
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
            type History = $history<F, $($size),+>;

            fn at_rest(&self) -> Self::History {
                self.0.at_rest()
            }

            #[inline]
            fn direct_gain(&self) -> F {
                self.0.direct_gain()
            }

            #[inline]
            fn past(&self, history: &Self::History) -> F {
                self.0.past(history)
            }

            #[inline]
            fn advance(&self, history: &mut Self::History, x: F) {
                self.0.advance(history, x);
            }

            #[inline]
            fn advance_many<const D: usize>(&self, histories: [&mut Self::History; D], x: [F; D]) {
                self.0.advance_many(histories, x);
            }

            fn memory_length(&self) -> Option<usize> {
                self.0.memory_length()
            }
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
