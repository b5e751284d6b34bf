//! The two-phase step that every operator shares.

use crate::Real;
use core::fmt::Debug;

/// A discrete differintegrator y = D^μ x: immutable coefficients that apply to any number of
/// histories.
///
/// ```text
/// y[n] = g·x[n] + S[n]        S[n] depends on x[n−1], x[n−2], … only
/// ```
/// - *Units*: x any unit \[x\], y \[x\]·s^(−μ), g s^(−μ).
/// - *Two phases*: [`output`](Self::output) costs one multiply-add whatever the memory (operators on increments: two
///   subtractions before it), so a force can leave at once; [`advance`](Self::advance) takes x\[n\] into the
///   history afterwards.
/// - *Start-up*: [`at_rest`](Self::at_rest) is a signal that was zero for ever.
/// - *Not finite*: a NaN or infinity in x is never hidden. It makes that output, and S from then
///   on, not finite: for the memory's length in a finite memory ([`ShortMemory`](crate::ShortMemory),
///   [`MuirPolynomial`](crate::MuirPolynomial)), until the history is reset in all others (of a whole
///   order, at most as many samples as they have taps or coefficients).
pub trait Differintegrator<F: Real> {
    /// What one signal leaves behind.
    type History: Clone + Debug;

    /// The history of a signal that was always zero.
    fn at_rest(&self) -> Self::History;

    /// g, the factor of the newest sample, in s^(−μ).
    fn direct_gain(&self) -> F;

    /// S\[n\], what the past contributes to the next output: the output for x\[n\] = 0.
    fn past(&self, history: &Self::History) -> F;

    /// Takes x\[n\] into the history and computes S\[n+1\].
    fn advance(&self, history: &mut Self::History, x: F);

    /// [`advance`](Self::advance) of D axes at once, to the bit as one after the other. Operators with many
    /// coefficients read each once for all axes, so that an axis costs less than alone.
    #[inline]
    fn advance_many<const D: usize>(&self, histories: [&mut Self::History; D], x: [F; D]) {
        for (history, x) in histories.into_iter().zip(x) {
            self.advance(history, x);
        }
    }

    /// y\[n\] for the newest sample x\[n\]; leaves the history alone.
    ///
    /// An operator on increments says it in its own way, g·(x\[n\] − x\[n−1\]) + …, which equals g·x\[n\] + S\[n\] but
    /// for the digits that g·x\[n\] and S\[n\] lose against each other. An operator that wraps another one passes
    /// this call on.
    #[inline]
    fn output(&self, history: &Self::History, x: F) -> F {
        // y[n] = g·x[n] + S[n]
        self.direct_gain() * x + self.past(history)
    }

    /// [`output`](Self::output), then [`advance`](Self::advance).
    #[inline]
    fn step(&self, history: &mut Self::History, x: F) -> F {
        let y = self.output(history, x);
        self.advance(history, x);
        y
    }

    /// Number of samples, the newest included, that reach the output: `None` if all of them do.
    fn memory_length(&self) -> Option<usize>;
}

/// One signal and its operator: the convenient owner for a single axis.
///
/// The operator acts on x − x₀. The reference x₀ is zero unless
/// [`reset_to`](Self::reset_to) set it. With x₀ the first sample of the signal this is the Caputo
/// derivative for 0 < μ < 1: the Riemann–Liouville (Grünwald) derivative of x − x₀
/// (I. Podlubny, *Fractional Differential Equations*, 1999, eq. 2.165).
///
/// ```
/// use fracdiff::{Channel, Order, Seconds, ShortMemory};
///
/// let half = ShortMemory::<f64, 256>::new(Order::new(0.5)?, Seconds(1e-3))?;
/// let mut axis = Channel::new(half);
/// axis.reset_to(2.0); // starts at 2, not from 0 with a jump
/// assert_eq!(axis.step(2.0), 0.0);
/// # Ok::<(), fracdiff::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Channel<F: Real, O: Differintegrator<F>> {
    operator: O,
    history: O::History,
    reference: F,
}

impl<F: Real, O: Differintegrator<F>> Channel<F, O> {
    /// At rest, with the reference value 0.
    pub fn new(operator: O) -> Self {
        let history = operator.at_rest();
        Self {
            operator,
            history,
            reference: F::ZERO,
        }
    }

    /// y\[n\] for the newest sample; leaves the history alone.
    #[inline]
    pub fn output(&self, x: F) -> F {
        self.operator.output(&self.history, x - self.reference)
    }

    /// Takes the newest sample into the history.
    #[inline]
    pub fn advance(&mut self, x: F) {
        self.operator.advance(&mut self.history, x - self.reference);
    }

    /// Both, output first.
    #[inline]
    pub fn step(&mut self, x: F) -> F {
        let y = self.output(x);
        self.advance(x);
        y
    }

    /// Forgets everything; the reference value is 0 again.
    pub fn reset(&mut self) {
        self.reset_to(F::ZERO);
    }

    /// Forgets everything; from now on the operator acts on x − `reference` (Caputo).
    pub fn reset_to(&mut self, reference: F) {
        self.history = self.operator.at_rest();
        self.reference = reference;
    }

    /// The operator.
    pub const fn operator(&self) -> &O {
        &self.operator
    }
}
