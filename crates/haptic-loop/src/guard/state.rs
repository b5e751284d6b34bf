//! Energy and the forces on their way, as every guard keeps them.

use super::profile::{HISTORY, Sent};
use crate::error::Checks;
use crate::units::Seconds;
use fracdiff::Real;

/// Energy and the forces on their way, newest first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GuardState<F, const D: usize> {
    pub(super) energy: F,
    /// The energy still to be paid for noise, J.
    pub(super) owed: F,
    pub(super) sent: [Sent<F, D>; HISTORY],
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
    pub(super) fn add(&mut self, work: F) {
        let energy = self.energy + work;
        if energy.is_finite() {
            self.energy = energy;
        } else {
            self.forget_credit();
        }
    }

    /// Keeps what goes to the device.
    #[inline]
    pub(super) fn push(&mut self, sent: Sent<F, D>) {
        for age in (1..HISTORY).rev() {
            self.sent[age] = self.sent[age - 1];
        }
        self.sent[0] = sent;
    }
}

/// 1 − T/τ; 0 for τ = 0.
pub(super) fn keep<F: Real>(forget: Seconds, sample_time: f64, checks: &mut Checks) -> F {
    let what = "time in which the guard forgets";
    checks.not_negative(what, forget.0, "s");
    if forget.0 <= 0.0 {
        return F::ZERO;
    }
    let whole = forget.0 >= sample_time;
    checks.range(what, forget.0, whole, "0 or at least the sample time", "s");
    F::from_f64(1.0 - sample_time / forget.0)
}
