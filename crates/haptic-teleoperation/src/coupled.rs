//! A fractional coupler from this device to the place of the other.

use crate::account::Account;
use fracdiff::Differintegrator;

/// Gains of a coupler `k_c` + `b_c·D^μ`; the operator has the order μ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CouplerGains {
    /// `k_c`, N/m, at least 0.
    pub stiffness_n_per_m: f64,
    /// `b_c`, N·s^μ/m, at least 0.
    pub dissipation_n_s_mu_per_m: f64,
}

/// One side of a coupler.
///
/// ```text
/// f = −(k_c·y + b_c·D^μ y),   y = x − x_other        both displacements from their starts; x_other the newest that has come
/// ```
#[derive(Clone, Debug)]
pub(crate) struct Coupled<O: Differintegrator<f64>> {
    gains: CouplerGains,
    operator: O,
    history: O::History,
    other_m: f64,
}

impl<O: Differintegrator<f64>> Coupled<O> {
    pub(crate) fn new(gains: CouplerGains, operator: O) -> Self {
        Self {
            gains,
            history: operator.at_rest(),
            operator,
            other_m: 0.0,
        }
    }

    pub(crate) fn hear(&mut self, position_m: f64) {
        if position_m.is_finite() {
            self.other_m = position_m;
        }
    }

    /// The force on the device, N.
    #[inline]
    pub(crate) fn wanted_n(&self, position_m: f64) -> f64 {
        let y = position_m - self.other_m;
        -(self.gains.stiffness_n_per_m * y
            + self.gains.dissipation_n_s_mu_per_m * self.operator.output(&self.history, y))
    }

    pub(crate) fn advance(&mut self, position_m: f64) {
        let y = position_m - self.other_m;
        self.operator.advance(&mut self.history, y);
    }

    /// Energy of its spring, J.
    fn stored_j(&self, position_m: f64) -> f64 {
        let y = position_m - self.other_m;
        0.5 * self.gains.stiffness_n_per_m * y * y
    }
}

/// Time-domain passivity of a coupled port: it gives the device no more energy than its account holds.
///
/// ```text
/// W = −f·Δx into the line;   W < −balance/N: f is scaled so that W = −balance/N
/// balance ← balance + W,   then what is above the energy of the own spring (on one side) is sent to the other
/// ```
/// - *Passive*: the accounts of both sides and what is on its way never fall below 0, whatever line and motion.
/// - *The spring* of the coupler stores energy once for both sides, so one side, the master, keeps `k_c·y²/2` for its way back.
///   (Sent away too, its hand would feel the spring push but not push back.)
/// - *While the account has* N times what a tick spends it is position–position to the bit. N > 1 lets energy that came in a
///   bunch, by jitter, last until the next; at 1 the force would chatter between all and nothing.
///
/// Source: J.-H. Ryu, J. Artigas, C. Preusche, *A passive bilateral control scheme for a teleoperator with time-varying
/// communication delay*, Mechatronics 20, 2010.
#[derive(Clone, Debug)]
pub(crate) struct Observed<O: Differintegrator<f64>> {
    coupled: Coupled<O>,
    account: Account,
    /// 1/N.
    share: f64,
    keeps_spring: bool,
}

impl<O: Differintegrator<f64>> Observed<O> {
    pub(crate) fn new(coupled: Coupled<O>, playout_samples: u32, keeps_spring: bool) -> Self {
        Self {
            coupled,
            account: Account::default(),
            share: 1.0 / f64::from(playout_samples),
            keeps_spring,
        }
    }

    pub(crate) fn hear(&mut self, position_m: f64, energy_j: f64) {
        self.coupled.hear(position_m);
        self.account.receive(energy_j);
    }

    pub(crate) fn wanted_n(&self, position_m: f64, moved: f64) -> f64 {
        let wanted = self.coupled.wanted_n(position_m);
        let given = wanted * moved;
        let available = self.share * self.account.available_j();
        if given > available {
            // The same direction, less of it; given > 0.
            wanted * (available / given)
        } else {
            wanted
        }
    }

    pub(crate) fn advance(&mut self, position_m: f64, moved: f64, applied_n: f64) {
        self.account.book(-applied_n * moved);
        let kept = if self.keeps_spring {
            self.coupled.stored_j(position_m)
        } else {
            0.0
        };
        let surplus = self.account.available_j() - kept;
        if surplus > 0.0 {
            self.account.send(surplus);
        }
        self.coupled.advance(position_m);
    }

    pub(crate) const fn account(&self) -> &Account {
        &self.account
    }
}
