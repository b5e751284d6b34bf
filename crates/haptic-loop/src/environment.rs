//! Virtual environments: control laws from position to force.

use crate::error::{Checks, LoopParameterError};
use core::array;
use core::fmt::Debug;
use fracdiff::{Differintegrator, Real};
use nalgebra::SVector;

/// A virtual environment with D degrees of freedom: position in, force on the device out.
///
/// - *Units*: position m, force N. *Sign*: a positive displacement into the environment is pushed
///   back, f = −H x.
/// - *Two phases*: [`force`](Self::force) costs the same whatever the memory and leaves the history
///   alone; [`advance`](Self::advance) takes the position into the history after the force is sent.
/// - *Not finite*: a position that is not finite makes a force that is not finite, which the safety
///   chain turns into a fault. Nothing here panics.
pub trait Environment<F: Real, const D: usize> {
    /// The motion so far, as far as the environment remembers it.
    type History: Clone + Debug;

    /// The history of a device that always rested at zero.
    fn at_rest(&self) -> Self::History;

    /// Makes a history that of a device that always rested at zero, as [`at_rest`](Self::at_rest), in its place where an
    /// environment can: for a stack without room for another one.
    fn rest(&self, history: &mut Self::History) {
        *history = self.at_rest();
    }

    /// Makes a history at rest that of a device which always stood here, held by no force: for a law to which the way from zero
    /// would be a motion. By default the history stays at rest, so that a tissue is entered from outside.
    fn settle(&self, history: &mut Self::History, position_m: &SVector<F, D>) {
        let _ = (history, position_m);
    }

    /// The force on the device at this position, N.
    fn force(&self, history: &Self::History, position_m: &SVector<F, D>) -> SVector<F, D>;

    /// Takes this tick's position into the history.
    fn advance(&self, history: &mut Self::History, position_m: &SVector<F, D>);

    /// The force, and the input by which [`advance_input`](Self::advance_input) takes this tick into the history: what both halves
    /// of a tick need of a position is computed once. By default the input is the position.
    fn force_and_input(
        &self,
        history: &Self::History,
        position_m: &SVector<F, D>,
    ) -> (SVector<F, D>, SVector<F, D>) {
        (self.force(history, position_m), *position_m)
    }

    /// [`advance`](Self::advance) by the input that came with the force.
    fn advance_input(&self, history: &mut Self::History, input: &SVector<F, D>) {
        self.advance(history, input);
    }

    /// [`advance_input`](Self::advance_input) with the force that was sent, N, where it differs from what was wanted: for what
    /// would wind up. By default it makes no difference.
    fn advance_applied(
        &self,
        history: &mut Self::History,
        input: &SVector<F, D>,
        applied_n: &SVector<F, D>,
    ) {
        let _ = applied_n;
        self.advance_input(history, input);
    }

    /// A force, N, that has the size of the largest one next to this position: what a start there is judged by. It is
    /// [`force`](Self::force), unless that falls to zero at a place that a device cannot stay at, as in the middle of a ball.
    fn starting_force(&self, history: &Self::History, position_m: &SVector<F, D>) -> SVector<F, D> {
        self.force(history, position_m)
    }
}

/// A spring and a fractional damper, the same on each axis.
///
/// ```text
/// f = −(K·x + B·D^μ x)        K N/m ≥ 0,   B N·s^μ/m ≥ 0,   μ the operator's order
/// ```
/// At μ = 1 a spring and a viscous damper, at μ = 0 two springs, at μ = 2 a spring and a mass.
/// *Cost*: `force` two multiply-adds an axis, `advance` costs what the operator's does.
///
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, eq. 3.8.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringDamper<F, O> {
    stiffness: F,
    dissipation: F,
    operator: O,
}

/// K and B of a [`SpringDamper`], checked and rounded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gains<F> {
    stiffness: F,
    dissipation: F,
}

impl<F: Real> Gains<F> {
    pub(crate) const NONE: Self = Self {
        stiffness: F::ZERO,
        dissipation: F::ZERO,
    };

    pub(crate) fn new(stiffness: f64, dissipation: f64, checks: &mut Checks) -> Self {
        checks.not_negative("stiffness", stiffness, "N/m");
        checks.not_negative("dissipation", dissipation, "N·s^μ/m");
        Self {
            stiffness: checks.rounded("stiffness", stiffness, "N/m"),
            dissipation: checks.rounded("dissipation", dissipation, "N·s^μ/m"),
        }
    }
}

impl<F: Real, O: Differintegrator<F>> SpringDamper<F, O> {
    /// K in N/m and B in N·s^μ/m. Plain numbers, because the unit of B depends on μ.
    ///
    /// # Errors
    /// Both must be finite and at least zero, in the precision of the loop too.
    pub fn new(stiffness: f64, dissipation: f64, operator: O) -> Result<Self, LoopParameterError> {
        let mut checks = Checks::default();
        let gains = Gains::new(stiffness, dissipation, &mut checks);
        checks.done().map(|()| Self::of(gains, operator))
    }

    #[inline]
    pub(crate) fn of(gains: Gains<F>, operator: O) -> Self {
        Self {
            stiffness: gains.stiffness,
            dissipation: gains.dissipation,
            operator,
        }
    }

    /// The operator D^μ of the dissipation.
    pub const fn operator(&self) -> &O {
        &self.operator
    }

    /// Takes other gains, and gives its operator to be changed.
    pub(crate) const fn reshape(&mut self, gains: Gains<F>) -> &mut O
    where
        F: Copy,
    {
        self.stiffness = gains.stiffness;
        self.dissipation = gains.dissipation;
        &mut self.operator
    }
}

impl<F: Real, O: Differintegrator<F>, const D: usize> Environment<F, D> for SpringDamper<F, O> {
    type History = [O::History; D];

    fn at_rest(&self) -> Self::History {
        array::from_fn(|_| self.operator.at_rest())
    }

    /// An operator that cannot rest, as an integral of a constant, keeps its history.
    fn settle(&self, history: &mut Self::History, position_m: &SVector<F, D>) {
        for (history, &x) in history.iter_mut().zip(position_m.iter()) {
            if let Some(settled) = self.operator.settled(x) {
                *history = settled;
            }
        }
    }

    #[inline]
    fn force(&self, history: &Self::History, position_m: &SVector<F, D>) -> SVector<F, D> {
        SVector::from(array::from_fn(|axis| {
            let x = position_m[axis];
            // f = −(K·x + B·D^μ x)
            -(self.stiffness * x + self.dissipation * self.operator.output(&history[axis], x))
        }))
    }

    #[inline]
    fn advance(&self, history: &mut Self::History, position_m: &SVector<F, D>) {
        for (history, &x) in history.iter_mut().zip(position_m.iter()) {
            self.operator.advance(history, x);
        }
    }
}
