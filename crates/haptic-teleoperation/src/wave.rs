//! Wave variables: a port whose line gives no energy at any delay.

use crate::account::Account;

/// A port of a wave line.
///
/// ```text
/// u = (b·v + F)/√(2b) leaves,   w = (b·v − F)/√(2b) comes in        power into the line F·v = (u² − w²)/2
/// F[n] = b·v[n] − √(2b)·w[n],   v[n] = (x[n] − x[n−1])/T            F force of the device on the line
/// w[n] = (Σ received − Σ taken)/(N·T), at most what the energy received bears
/// ```
/// - *Sums travel*, T·Σu and T·Σu²/2, not samples: what was lost comes with the next message, so no displacement is lost for
///   good, and a message that comes twice gives nothing twice.
/// - *Playout*: N ≥ 1 samples smooth what jitter has bunched. It costs (N − 1)·T of delay.
/// - *The energy limit* makes it passive: waves come out with no more energy than went in. A limited wave catches up later.
/// - *A limited force*, F below what was wanted: u is made of the force that was really sent, and of its energy.
///
/// Source: G. Niemeyer, J.-J. Slotine, *Telemanipulation with time delays*, Int. J. Robotics Research 23(9), 2004; energy of
/// the waves sent along after N. Chopra, P. Berestesky, M. Spong, *Bilateral teleoperation over unreliable communication
/// networks*, IEEE Trans. Control Systems Technology 16(2), 2008.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WavePort {
    /// b, N·s/m.
    impedance: f64,
    /// √(2b).
    root: f64,
    /// 1/N.
    share: f64,
    sample_time: f64,
    /// T·Σw that has come.
    received: f64,
    /// T·Σw that was taken.
    taken: f64,
    /// T·Σu that has left.
    left: f64,
    account: Account,
}

impl WavePort {
    /// Of checked parameters.
    pub(crate) fn new(impedance: f64, playout_samples: u32, sample_time: f64) -> Self {
        Self {
            impedance,
            root: libm::sqrt(2.0 * impedance),
            share: 1.0 / f64::from(playout_samples),
            sample_time,
            received: 0.0,
            taken: 0.0,
            left: 0.0,
            account: Account::default(),
        }
    }

    pub(crate) fn hear(&mut self, sum: f64, energy_j: f64) {
        if sum.is_finite() {
            self.received = sum;
        }
        self.account.receive(energy_j);
    }

    /// w of this tick.
    fn incoming(&self) -> f64 {
        let wanted = (self.received - self.taken) * self.share / self.sample_time;
        // T·w²/2 ≤ available
        let most = libm::sqrt(2.0 * self.account.available_j() / self.sample_time);
        wanted.clamp(-most, most)
    }

    /// The force on the device, N, after a displacement in this sample, m.
    pub(crate) fn wanted_n(&self, moved: f64) -> f64 {
        // f = −F
        self.root * self.incoming() - self.impedance * moved / self.sample_time
    }

    /// Takes the tick in, with the force on the device that was really sent.
    pub(crate) fn advance(&mut self, moved: f64, applied_n: f64) {
        let t = self.sample_time;
        let wave = self.incoming();
        self.taken += t * wave;
        // What comes out of the line and what the device puts in.
        let came = 0.5 * t * wave * wave;
        let budget = came - applied_n * moved;
        let outgoing = (self.impedance * moved / t - applied_n) / self.root;
        let most = libm::sqrt(2.0 * budget.max(0.0) / t);
        let outgoing = outgoing.clamp(-most, most);
        let sent = 0.5 * t * outgoing * outgoing;
        self.left += t * outgoing;
        // What is left over is given up: as heat it can do no harm. A debt stays.
        self.account.book(budget.min(sent) - came);
        self.account.send(sent);
    }

    /// T·Σu and T·Σu²/2.
    pub(crate) const fn said(&self) -> (f64, f64) {
        (self.left, self.account.sent_j())
    }

    pub(crate) const fn account(&self) -> &Account {
        &self.account
    }
}
