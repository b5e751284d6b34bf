//! The energy that a port may spend.

/// Books of a port: no more leaves it, into the device or to the other side, than has come in.
///
/// ```text
/// balance = received from the other side + Σ F·Δx of this side − sent to the other side − what was dissipated
/// ```
/// All energies are sums from the start, so a message that is lost costs nothing once the next one has come.
/// A balance below 0 is a debt: the safety chain made a force that nobody wanted. It is paid from what comes in next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Account {
    balance_j: f64,
    received_j: f64,
    sent_j: f64,
}

impl Account {
    /// Takes in the sum that the other side has sent. A smaller one than before is none.
    pub(crate) fn receive(&mut self, total_j: f64) {
        let fresh = total_j - self.received_j;
        // Not for a NaN.
        if fresh > 0.0 && fresh.is_finite() {
            self.balance_j += fresh;
            self.received_j = total_j;
        }
    }

    /// Energy that may be spent now, J, at least 0.
    pub(crate) const fn available_j(&self) -> f64 {
        self.balance_j.max(0.0)
    }

    /// Books what went in, J; what came out is negative.
    pub(crate) fn book(&mut self, energy_j: f64) {
        self.balance_j += energy_j;
    }

    /// Sends so much, J ≥ 0.
    pub(crate) fn send(&mut self, energy_j: f64) {
        self.balance_j -= energy_j;
        self.sent_j += energy_j;
    }

    /// All that was sent, J.
    pub(crate) const fn sent_j(&self) -> f64 {
        self.sent_j
    }

    /// What is in it, J.
    pub(crate) const fn balance_j(&self) -> f64 {
        self.balance_j
    }
}
