//! Time-domain passivity observer and controller.

use super::profile::{GuardState, dot, forgotten};
use crate::error::Checks;
use crate::units::{Kilograms, NewtonSecondsPerMetre, Seconds};
use core::array;
use fracdiff::Real;
use nalgebra::SVector;

/// Time-domain passivity observer and controller.
///
/// ```text
/// E\[n\] = E\[n−1\] − f\[n−1\]·Δ\[n\],    then E ← E·(1 − T/τ) if E > 0          forgotten: only what was dissipated
/// g = f_wanted·Δ\[n\] − E\[n\]                                          what the next sample would owe
/// f = f_wanted − b_c·Δ\[n\]/T,    b_c = 0 if g ≤ 0,  else min(b_max, g·T/|Δ|²)
/// ```
/// - *Along the force*: with several axes Δ in the last line is its part along the wanted force, for only that part works:
///   a guard adds no friction to a hand that slides. Without a force it is the whole of Δ.
/// - *Prediction*: the next sample moves as the last did.
/// - *No small divisor*: the quotient is formed only where it is below `b_max`.
/// - *Forgetting* shrinks a credit, never a debt, so it makes the guard stricter: what a held spring has
///   stored is forgotten too after some τ, and its release is damped.
/// - *Limit*: damping holds no wall beyond α = KT²/m of about 0.8 and none with a sample of delay.
/// - *Cost*: per axis four multiply-adds; while it acts, one division.
///
/// Source: B. Hannaford, J.-H. Ryu, *Time-domain passivity control of haptic interfaces*, IEEE Trans. Robotics
/// and Automation 18(1), 2002, in the impedance form; cap, forgetting and exact work are ours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassivityObserver {
    /// `b_max` > 0, the most damping that the device bears: see [`bearable`](Self::bearable).
    pub damping_max: NewtonSecondsPerMetre,
    /// τ, at least a sample time: how long a credit of energy lasts.
    pub forget: Seconds,
}

impl PassivityObserver {
    /// m/(2T), and half a second of credit.
    ///
    /// A sampled damper −B·Δ/T on a mass m is stable for β = B·T/m below 2, and with a spring beside it for
    /// α < 2β(2 − β)/(2 + β). β = 1/2 keeps a margin of four alone and bears a spring of α = 0.6; no β bears more
    /// than 0.69.
    #[must_use]
    pub fn bearable(mass: Kilograms, sample_time: Seconds) -> Self {
        Self {
            damping_max: NewtonSecondsPerMetre(mass.0 / (2.0 * sample_time.0)),
            forget: Seconds(0.5),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Observer<F> {
    /// The most damping, over T: N/m.
    damping_max: F,
    /// T/τ, the share of the stored energy that a tick forgets.
    forgotten: F,
}

impl<F: Real> Observer<F> {
    pub(super) fn new(observer: &PassivityObserver, sample_time: f64, checks: &mut Checks) -> Self {
        let what = "most damping of the guard";
        let damping = checks.positive(what, observer.damping_max.0, "N·s/m");
        checks.positive("time in which the guard forgets", observer.forget.0, "s");
        Self {
            damping_max: checks.rounded(what, damping / sample_time, "N/m"),
            forgotten: forgotten(observer.forget, sample_time, checks),
        }
    }

    /// The wanted force with damping along the last motion, and whether there is any.
    #[inline]
    pub(super) fn steer<const D: usize>(
        &self,
        state: &mut GuardState<F, D>,
        moved: &SVector<F, D>,
        wanted: &SVector<F, D>,
    ) -> (SVector<F, D>, bool) {
        state.add(-dot(&state.sent[0].force, moved));
        state.forget(state.energy(), self.forgotten);
        // g = f·Δ − E
        let owed = dot(wanted, moved) - state.energy();
        let moved = &along(moved, wanted);
        let square = dot(moved, moved);
        if owed.is_finite() && owed <= F::ZERO {
            return (*wanted, false);
        }
        let damping = if owed < self.damping_max * square {
            owed / square
        } else {
            self.damping_max
        };
        let damped = |axis| wanted[axis] - damping * moved[axis];
        (SVector::from(array::from_fn(damped)), square > F::ZERO)
    }
}

/// The part of a motion along a force, of which it is all if there is no force or no other axis.
#[inline]
fn along<F: Real, const D: usize>(moved: &SVector<F, D>, force: &SVector<F, D>) -> SVector<F, D> {
    let square = dot(force, force);
    if D == 1 || !(square.is_finite() && square > F::ZERO) {
        return *moved;
    }
    let share = dot(moved, force) / square;
    SVector::from(array::from_fn(|axis| share * force[axis]))
}
