//! What the operators are compared with: the Grünwald sum as one writes it first. It sums all N taps
//! between sample and force, in order, in one accumulator; the history only stores. N is a constant, so for a power of two the `%` of the
//! ring is a mask, not a division.

use crate::input::{SAMPLE_TIME, order};
use fractional_haptics::fracdiff::{Differintegrator, Real, grunwald_weights};

/// No operator at all, y = x: what the measurement itself costs.
#[derive(Debug)]
pub(crate) struct Nothing;

impl<F: Real> Differintegrator<F> for Nothing {
    type History = F;

    fn at_rest(&self) -> F {
        F::ZERO
    }

    fn direct_gain(&self) -> F {
        F::ONE
    }

    fn past(&self, _: &F) -> F {
        F::ZERO
    }

    fn advance(&self, _: &mut F, _: F) {}

    fn output(&self, _: &F, x: F) -> F {
        x
    }

    fn memory_length(&self) -> Option<usize> {
        Some(1)
    }
}

/// A ring buffer, its index taken modulo N for each tap.
#[derive(Debug)]
pub(crate) struct ModuloRing<F, const N: usize>([F; N]);

impl<F: Real, const N: usize> ModuloRing<F, N> {
    /// The factors of the newest N samples, in s^(−μ).
    pub(crate) fn new() -> Self {
        let gain = libm::pow(SAMPLE_TIME.0, -order().get());
        let mut weights = grunwald_weights(order());
        Self(std::array::from_fn(|_| {
            F::from_f64(gain * weights.next().unwrap_or(0.0))
        }))
    }
}

impl<F: Real, const N: usize> Differintegrator<F> for ModuloRing<F, N> {
    /// Samples, and where the newest is.
    type History = ([F; N], usize);

    fn at_rest(&self) -> Self::History {
        ([F::ZERO; N], 0)
    }

    fn direct_gain(&self) -> F {
        self.0[0]
    }

    fn past(&self, (samples, newest): &Self::History) -> F {
        let mut sum = F::ZERO;
        for j in 1..N {
            sum += self.0[j] * samples[(newest + N + 1 - j) % N];
        }
        sum
    }

    fn advance(&self, (samples, newest): &mut Self::History, x: F) {
        *newest = (*newest + 1) % N;
        samples[*newest] = x;
    }

    fn memory_length(&self) -> Option<usize> {
        Some(N)
    }
}
