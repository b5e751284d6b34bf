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
        let IntegerHistory {
            core,
            words: [first, second],
            carries: [first_carry, second_carry],
            past,
        } = history;
        let gain = self.core.direct_gain();
        match self.integer {
            0 => {
                self.core.advance(core, x);
                *past = self.core.past(core);
            }
            1 => {
                self.core.advance(core, x - *first);
                *first = x;
                // g·(x − x[n−1]) + S = g·x + (S − g·x[n−1])
                *past = self.core.past(core) - gain * *first;
            }
            2 => {
                self.core.advance(core, (x - *first) - (*first - *second));
                *second = *first;
                *first = x;
                *past = self.core.past(core) - gain * (*first + (*first - *second));
            }
            integrations => {
                add_compensated(first, first_carry, self.core.output(core, x));
                self.core.advance(core, x);
                *past = self.core.past(core) + *first;
                if integrations == -2 {
                    add_compensated(second, second_carry, *first);
                    *past += *second;
                }
            }
        }
    }

    fn memory_length(&self) -> Option<usize> {
        match self.integer {
            n @ 0.. => Some(self.core.memory_length()? + n.unsigned_abs() as usize),
            _ => None,
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
