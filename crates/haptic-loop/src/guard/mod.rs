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
//! *Start-up*: no energy. *Cost*: see each. *Precision*: all in the loop's number type, the sum compensated.

mod bounding;
mod observer;
mod profile;

pub use bounding::EnergyBounding;
pub use observer::PassivityObserver;
pub(crate) use profile::GuardState;
pub use profile::{MAX_GUARD_DELAY_SAMPLES, MAX_GUARD_LAG_SAMPLES};

use crate::error::Checks;
use bounding::Bounding;
use fracdiff::Real;
use nalgebra::SVector;
use observer::Observer;
use profile::Sent;

/// A choice of guard, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PassivityGuard {
    /// Adds damping while more energy has come out than went in.
    Observer(PassivityObserver),
    /// Makes the force no larger than the energy at hand can pay for.
    EnergyBounding(EnergyBounding),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum GuardLaw<F> {
    Observer(Observer<F>),
    Bounding(Bounding<F>),
}

impl<F: Real> GuardLaw<F> {
    pub(crate) fn new(guard: &PassivityGuard, sample_time: f64, checks: &mut Checks) -> Self {
        match guard {
            PassivityGuard::Observer(observer) => {
                Self::Observer(Observer::new(observer, sample_time, checks))
            }
            PassivityGuard::EnergyBounding(bounding) => {
                Self::Bounding(Bounding::new(bounding, sample_time, checks))
            }
        }
    }

    /// The observer's force for a wanted one, and true if the two differ. `moved` is Δ, m.
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
    /// `None` if it is not known. Not inlined: it would lengthen the path of loops without a guard.
    #[inline(never)]
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
