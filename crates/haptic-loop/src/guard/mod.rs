//! The passivity guard: keeps a sampled wall from feeding energy into the device that holds it.
//!
//! A loop is passive if the energy that the device has given to it stays above a constant. The guards keep books of that
//! energy, from positions and from the forces that *were sent*, after all limits:
//!
//! ```text
//! E\[n\] = E\[n−1\] − ḡ·Δ\[n\] + …        Δ\[n\] = x\[n\] − x\[n−1\], m;   ḡ mean force over that sample, N;   E J
//! ```
//! - [`EnergyBounding`] knows the viscous damping b of the device, and when and how its force acts. It promises: no
//!   motion whatever can make the sampled loop and that damping together give energy. It makes the force smaller.
//! - [`PassivityObserver`] knows nothing and promises less: it adds damping while more energy has come out
//!   than went in. It leaves the stiffness at rest as it is, and cannot hold what damping cannot hold.
//!
//! *Where*: the observer acts on the wanted force. Energy bounding is the last stage of the safety chain, after every
//! limit, so that nothing can keep up a force that it takes away.
//! *Start-up*: no energy. *Cost*: see each. *Precision*: all in the loop's number type.

mod bounding;
mod observer;
mod profile;

pub use bounding::EnergyBounding;
pub use observer::PassivityObserver;
pub use profile::{MAX_GUARD_DELAY_SAMPLES, MAX_GUARD_LAG_SAMPLES};

use crate::error::{ParameterError, not_negative, range};
use crate::units::Seconds;
use bounding::Bounding;
use fracdiff::Real;
use nalgebra::SVector;
use observer::Observer;
use profile::{HISTORY, Sent};

/// A choice of guard, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Guard {
    /// Adds damping.
    Observer(PassivityObserver),
    /// Bounds the force.
    EnergyBounding(EnergyBounding),
}

/// A guard made of good parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum GuardLaw<F> {
    /// [`PassivityObserver`].
    Observer(Observer<F>),
    /// [`EnergyBounding`].
    Bounding(Bounding<F>),
}

/// Energy and the forces on their way, newest first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GuardState<F, const D: usize> {
    energy: F,
    /// What is still to be paid for noise, J.
    owed: F,
    sent: [Sent<F, D>; HISTORY],
}

impl<F: Real, const D: usize> GuardState<F, D> {
    pub(crate) fn at_rest() -> Self {
        Self {
            energy: F::ZERO,
            owed: F::ZERO,
            sent: [Sent::none(); HISTORY],
        }
    }

    /// E, J.
    pub(crate) const fn energy(&self) -> F {
        self.energy
    }

    /// E ← min(0, E).
    pub(crate) fn forget_credit(&mut self) {
        if self.energy > F::ZERO {
            self.energy = F::ZERO;
        }
    }

    /// The device has let go by itself: no force is on its way any more, and no credit is left.
    pub(crate) fn let_go(&mut self) {
        self.sent = [Sent::none(); HISTORY];
        self.forget_credit();
    }

    /// Takes the energy of a sample, J. A sum that is not finite is no credit, and keeps a debt.
    #[inline]
    fn add(&mut self, work: F) {
        let energy = self.energy + work;
        if energy.is_finite() {
            self.energy = energy;
        } else {
            self.forget_credit();
        }
    }

    /// Keeps what goes to the device.
    #[inline]
    fn push(&mut self, sent: Sent<F, D>) {
        for age in (1..HISTORY).rev() {
            self.sent[age] = self.sent[age - 1];
        }
        self.sent[0] = sent;
    }
}

impl<F: Real> GuardLaw<F> {
    /// # Errors
    /// A parameter outside the range that its field states.
    pub(crate) fn new(guard: &Guard, sample_time: f64) -> Result<Self, ParameterError> {
        Ok(match guard {
            Guard::Observer(observer) => Self::Observer(Observer::new(observer, sample_time)?),
            Guard::EnergyBounding(bounding) => {
                Self::Bounding(Bounding::new(bounding, sample_time)?)
            }
        })
    }

    /// What the observer makes of a wanted force, and whether that is another. `moved` is Δ, m.
    #[inline(never)]
    pub(crate) fn steer<const D: usize>(
        &self,
        state: &mut GuardState<F, D>,
        moved: &SVector<F, D>,
        wanted: &SVector<F, D>,
    ) -> (SVector<F, D>, bool) {
        match self {
            Self::Observer(observer) => observer.steer(state, moved, wanted),
            Self::Bounding(_) => (*wanted, false),
        }
    }

    /// Bounds the force that is about to be sent, and keeps it; says whether it was made smaller. `moved` is Δ, m;
    /// `None` if it is not known.
    #[inline]
    pub(crate) fn settle<const D: usize>(
        &self,
        state: &mut GuardState<F, D>,
        moved: Option<&SVector<F, D>>,
        force: &mut SVector<F, D>,
    ) -> bool {
        match self {
            Self::Observer(_) => {
                state.push(Sent::plain(force));
                false
            }
            Self::Bounding(bounding) => bounding.bound(state, moved, force),
        }
    }
}

/// 1 − T/τ; 0 for τ = 0.
fn keep<F: Real>(forget: Seconds, sample_time: f64) -> Result<F, ParameterError> {
    let what = "time in which the guard forgets";
    not_negative(what, forget.0, "s")?;
    if forget.0 <= 0.0 {
        return Ok(F::ZERO);
    }
    let whole = forget.0 >= sample_time;
    range(what, forget.0, whole, "0 or at least the sample time", "s")?;
    Ok(F::from_f64(1.0 - sample_time / forget.0))
}

#[inline]
fn dot<F: Real, const D: usize>(left: &SVector<F, D>, right: &SVector<F, D>) -> F {
    let mut sum = F::ZERO;
    for (&left, &right) in left.iter().zip(right) {
        sum += left * right;
    }
    sum
}
