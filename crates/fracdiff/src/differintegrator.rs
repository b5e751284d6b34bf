//! The two-phase step that every operator shares.

use crate::Real;
use core::fmt::Debug;

/// A discrete differintegrator y = D^μ x: immutable coefficients that apply to any number of histories.
/// ```text
/// y[n] = g·x[n] + S[n]        S[n] depends on x[n−1], x[n−2], … only
/// ```
/// - *Units*: x any unit \[x\], y \[x\]·s^(−μ), g s^(−μ).
/// - *Two phases*: [`output`](Self::output) costs one multiply-add whatever the memory (operators on increments: two subtractions before
///   it), so a force can leave at once; [`advance`](Self::advance) takes x\[n\] into the history afterwards.
/// - *Start-up*: [`at_rest`](Self::at_rest) is a signal that was zero for ever.
/// - *Not finite*: a NaN or infinity in x is never hidden. It makes that output, and S from then on, not finite: for the memory's length in
///   a finite memory ([`ShortMemory`](crate::ShortMemory), [`MuirPolynomial`](crate::MuirPolynomial)), until the history is reset in all
///   others (of a whole order, at most as many samples as they have taps or coefficients).
/// - *By reference*: `&O` is an operator as O is, so one serves many owners; so is `Box<O>` (`alloc`).
/// - *As `dyn`*: operators of one history type can be `&dyn Differintegrator<F, History = H>`.
/// ```
/// use fracdiff::{Differintegrator, Fir, FirHistory};
///
/// let (slope, mean) = (Fir::<f32, 4>::from_slice(&[1.0, -1.0])?, Fir::<f32, 4>::from_slice(&[0.25; 4])?);
/// let both: [&dyn Differintegrator<f32, History = FirHistory<f32, 4>>; 2] = [&slope, &mean];
/// assert_eq!(both.map(|operator| operator.output(&operator.at_rest(), 4.0)), [4.0, 1.0]);
/// # Ok::<(), fracdiff::portable::ListError>(())
/// ```
pub trait Differintegrator<F: Real> {
    /// The past of one signal, as far as the operator remembers it.
    type History: Clone + Debug;

    /// The history of a signal that was always zero.
    fn at_rest(&self) -> Self::History;

    /// Makes a history that of a signal that was always zero, as [`at_rest`](Self::at_rest), in its place where an operator
    /// can: for a stack without room for another one.
    fn rest(&self, history: &mut Self::History) {
        *history = self.at_rest();
    }

    /// The history of a signal that has stood at `x` for ever: a start without a bump. The output for `x` is then that
    /// of a constant, and stays so.
    ///
    /// - Exactly 0 for orders above 0 of [`FullMemory`](crate::FullMemory), and for whole orders above 0 of all others but
    ///   [`MuirPolynomial`](crate::MuirPolynomial).
    /// - Elsewhere the gain at rest that the coefficients have. To start from 0 whatever the operator let it act on
    ///   x − x₀, as [`Channel::reset_to`] does.
    /// - `None` where the sum over such a past has no end, as in running sums (μ ≤ −1), or where an operator does not say.
    fn settled(&self, x: F) -> Option<Self::History> {
        (x == F::ZERO).then(|| self.at_rest())
    }

    /// g, the factor of the newest sample, in s^(−μ).
    fn direct_gain(&self) -> F;

    /// S\[n\], what the past contributes to the next output: the output for x\[n\] = 0.
    fn past(&self, history: &Self::History) -> F;

    /// Takes x\[n\] into the history and computes S\[n+1\].
    fn advance(&self, history: &mut Self::History, x: F);

    /// [`advance`](Self::advance) of D axes at once, to the bit as one after the other. Operators with many
    /// coefficients read each once for all axes, so that an axis costs less than alone.
    #[inline]
    fn advance_many<const D: usize>(&self, histories: [&mut Self::History; D], x: [F; D])
    where
        Self: Sized,
    {
        for (history, x) in histories.into_iter().zip(x) {
            self.advance(history, x);
        }
    }

    /// y\[n\] for the newest sample x\[n\]; leaves the history alone.
    ///
    /// An operator on increments says it in its own way, g·(x\[n\] − x\[n−1\]) + …, which equals g·x\[n\] + S\[n\] but for the digits that
    /// g·x\[n\] and S\[n\] lose against each other. An operator that wraps another one passes this call on.
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

    /// [`step`](Self::step) of each of some samples, with the outputs in their place. An operator that is one of several looks once
    /// which it is.
    #[inline]
    fn process(&self, history: &mut Self::History, samples: &mut [F]) {
        for sample in samples {
            *sample = self.step(history, *sample);
        }
    }

    /// Number of samples, the newest included, that reach the output: `None` if all of them do.
    fn memory_length(&self) -> Option<usize>;
}

/// Functions of an operator whose history keeps S\[n\] as `past`: its direct gain, by the path to it, and S.
macro_rules! past_is_kept {
    ($($direct:tt)+) => {
        #[inline]
        fn direct_gain(&self) -> F {
            self.$($direct)+
        }

        #[inline]
        fn past(&self, history: &Self::History) -> F {
            history.past
        }
    };
}

pub(crate) use past_is_kept;

/// The calls of an operator that are those of another one.
macro_rules! forward_differintegrator {
    ($history:ty, $self:ident => $inner:expr) => {
        type History = $history;

        fn at_rest(&$self) -> Self::History {
            $inner.at_rest()
        }

        fn settled(&$self, x: F) -> Option<Self::History> {
            $inner.settled(x)
        }

        #[inline]
        fn direct_gain(&$self) -> F {
            $inner.direct_gain()
        }

        #[inline]
        fn past(&$self, history: &Self::History) -> F {
            $inner.past(history)
        }

        #[inline]
        fn output(&$self, history: &Self::History, x: F) -> F {
            $inner.output(history, x)
        }

        #[inline]
        fn advance(&$self, history: &mut Self::History, x: F) {
            $inner.advance(history, x);
        }

        #[inline]
        fn process(&$self, history: &mut Self::History, samples: &mut [F]) {
            $inner.process(history, samples);
        }

        fn memory_length(&$self) -> Option<usize> {
            $inner.memory_length()
        }
    };
    ($history:ty, $self:ident => $inner:expr, many) => {
        $crate::differintegrator::forward_differintegrator!($history, $self => $inner);

        #[inline]
        fn advance_many<const D: usize>(&$self, histories: [&mut Self::History; D], x: [F; D]) {
            $inner.advance_many(histories, x);
        }
    };
}

pub(crate) use forward_differintegrator;

/// The calls of an operator that is one of several, each with a history of its own. The history of another kind gives NaN,
/// and stays as it is.
macro_rules! one_of {
    ($history:ident, $advance:path: $($kind:ident)+) => {
        fn at_rest(&self) -> Self::History {
            match self {
                $(Self::$kind(operator) => $history::$kind(operator.at_rest().into()),)+
            }
        }

        fn settled(&self, x: F) -> Option<Self::History> {
            Some(match self {
                $(Self::$kind(operator) => $history::$kind(operator.settled(x)?.into()),)+
            })
        }

        #[inline]
        fn direct_gain(&self) -> F {
            match self {
                $(Self::$kind(operator) => operator.direct_gain(),)+
            }
        }

        #[inline]
        fn past(&self, history: &Self::History) -> F {
            match (self, history) {
                $((Self::$kind(operator), $history::$kind(past)) => operator.past(past),)+
                _ => F::from_f64(f64::NAN),
            }
        }

        #[inline]
        fn output(&self, history: &Self::History, x: F) -> F {
            match (self, history) {
                $((Self::$kind(operator), $history::$kind(past)) => operator.output(past, x),)+
                _ => F::from_f64(f64::NAN),
            }
        }

        #[inline]
        fn advance(&self, history: &mut Self::History, x: F) {
            match (self, history) {
                $((Self::$kind(operator), $history::$kind(past)) => $advance(operator, past, x),)+
                _ => {}
            }
        }

        fn process(&self, history: &mut Self::History, samples: &mut [F]) {
            match (self, history) {
                $((Self::$kind(operator), $history::$kind(past)) => operator.process(past, samples),)+
                _ => samples.fill(F::from_f64(f64::NAN)),
            }
        }

        fn memory_length(&self) -> Option<usize> {
            match self {
                $(Self::$kind(operator) => operator.memory_length(),)+
            }
        }
    };
}

pub(crate) use one_of;

impl<F: Real, O: Differintegrator<F>> Differintegrator<F> for &O {
    forward_differintegrator!(O::History, self => (**self), many);
}

#[cfg(feature = "alloc")]
impl<F: Real, O: Differintegrator<F> + ?Sized> Differintegrator<F> for alloc::boxed::Box<O> {
    forward_differintegrator!(O::History, self => (**self));
}

/// One signal and its operator: the convenient owner for a single axis.
///
/// The operator acts on x − x₀. The reference x₀ is zero unless [`reset_to`](Self::reset_to) set it. With x₀ the first sample of the signal
/// this is the Caputo derivative for 0 < μ < 1: the Riemann–Liouville (Grünwald) derivative of x − x₀ (I. Podlubny, *Fractional
/// Differential Equations*, 1999, eq. 2.165).
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
    /// Channel at rest, with the reference value 0.
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

    /// The output for the newest sample, which is then taken into the history.
    #[inline]
    pub fn step(&mut self, x: F) -> F {
        let y = self.output(x);
        self.advance(x);
        y
    }

    /// [`step`](Self::step) of each of some samples, with the outputs in their place.
    pub fn process(&mut self, samples: &mut [F]) {
        for sample in &mut *samples {
            *sample -= self.reference;
        }
        self.operator.process(&mut self.history, samples);
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

    /// Goes on from a history, kept or restored, and its reference value.
    pub fn resume(&mut self, history: O::History, reference: F) {
        self.history = history;
        self.reference = reference;
    }

    /// The history of the signal, and the reference value.
    pub const fn state(&self) -> (&O::History, F) {
        (&self.history, self.reference)
    }

    /// The operator that this history belongs to, as for its frequency response.
    pub const fn operator(&self) -> &O {
        &self.operator
    }
}
