//! Energy and the forces on their way, as every guard keeps them.

use super::profile::{HISTORY, Sent};
use crate::error::Checks;
use crate::units::Seconds;
use fracdiff::Real;

/// Energy and the forces on their way, newest first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GuardState<F, const D: usize> {
    /// E is this and `rest`.
    energy: F,
    /// What rounding took from `energy`, and what was spent since the last sample, J.
    rest: F,
    /// The energy still to be paid for noise, J.
    pub(super) owed: F,
    pub(super) sent: [Sent<F, D>; HISTORY],
}

impl<F: Real, const D: usize> GuardState<F, D> {
    pub(crate) fn at_rest() -> Self {
        Self {
            energy: F::ZERO,
            rest: F::ZERO,
            owed: F::ZERO,
            sent: [Sent::none(); HISTORY],
        }
    }

    /// E, J.
    #[inline]
    pub(crate) fn energy(&self) -> F {
        self.energy + self.rest
    }

    /// E ← min(0, E), also of what is not finite.
    pub(crate) fn forget_credit(&mut self) {
        let is_debt = self.energy() < F::ZERO;
        if !is_debt {
            (self.energy, self.rest) = (F::ZERO, F::ZERO);
        }
    }

    /// The device has let go by itself: no force is on its way any more, and no credit is left.
    pub(crate) fn let_go(&mut self) {
        self.sent = [Sent::none(); HISTORY];
        self.forget_credit();
    }

    /// Takes the energy of a sample, J. The sum is compensated (W. Kahan, Comm. ACM 8(1), 1965); it is off by a rounding of `work` at
    /// most. One that is not finite is no credit, and keeps a debt.
    #[inline]
    pub(super) fn add(&mut self, work: F) {
        let work = work + self.rest;
        let energy = self.energy + work;
        if energy.is_finite() {
            self.rest = work - (energy - self.energy);
            self.energy = energy;
        } else {
            self.forget_credit();
        }
    }

    /// Takes away energy, J.
    #[inline]
    pub(super) fn spend(&mut self, cost: F) {
        self.rest -= cost;
    }

    /// Spends this share of a surplus, J, if there is one.
    #[inline]
    pub(super) fn forget(&mut self, surplus: F, share: F) {
        /// No force is felt for less, J, which stays: it would soon be no normal number.
        const NOTHING: f64 = 1e-25;
        if surplus > F::from_f64(NOTHING) {
            self.spend(surplus * share);
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

/// T/τ, the share of a surplus that is forgotten in a sample; 1 for τ = 0.
pub(super) fn forgotten<F: Real>(forget: Seconds, sample_time: f64, checks: &mut Checks) -> F {
    let what = "time in which the guard forgets";
    checks.not_negative(what, forget.0, "s");
    if forget.0 <= 0.0 {
        return F::ONE;
    }
    let whole = forget.0 >= sample_time;
    checks.range(what, forget.0, whole, "0 or at least the sample time", "s");
    F::from_f64(sample_time / forget.0)
}
