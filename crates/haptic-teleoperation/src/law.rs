//! The laws of a port: couplers and waves, the energy that each may spend, what it hears, wants and says.

use fracdiff::Differintegrator;
use haptic_link::HandState;

#[derive(Clone, Debug)]
pub(crate) enum Law<O: Differintegrator<f64>> {
    /// A coupler that sends its position.
    Position(Coupled<O>),
    /// A coupler that sends its force: the slave of position–force.
    Reflecting(Coupled<O>),
    /// The master of position–force: the force of the slave's coupler, turned round.
    Reflected {
        force_n: f64,
    },
    Wave(WavePort),
    /// A coupler with an account.
    Observed(Observed<O>),
}

impl<O: Differintegrator<f64>> Law<O> {
    /// Takes in the newest of the other side; false if it is of another architecture.
    pub(crate) fn hear(&mut self, state: HandState) -> bool {
        match (self, state) {
            (Self::Position(law) | Self::Reflecting(law), HandState::Position { position_m }) => {
                law.hear(position_m);
            }
            (Self::Reflected { force_n }, HandState::Force { force_n: heard }) => {
                if heard.is_finite() {
                    *force_n = -heard;
                }
            }
            (Self::Wave(law), HandState::Wave { sum, energy_j }) => law.hear(sum, energy_j),
            (
                Self::Observed(law),
                HandState::Energy {
                    position_m,
                    energy_j,
                },
            ) => law.hear(position_m, energy_j),
            _ => return false,
        }
        true
    }

    /// The force on the device at this displacement, m, after moving by `moved`, N.
    #[inline]
    pub(crate) fn wanted_n(&self, position_m: f64, moved: f64) -> f64 {
        match self {
            Self::Position(law) | Self::Reflecting(law) => law.wanted_n(position_m),
            Self::Reflected { force_n } => *force_n,
            Self::Wave(law) => law.wanted_n(moved),
            Self::Observed(law) => law.wanted_n(position_m, moved),
        }
    }

    /// Takes the tick in, with the force on the device that was really sent.
    pub(crate) fn advance(&mut self, position_m: f64, moved: f64, applied_n: f64) {
        match self {
            Self::Position(law) | Self::Reflecting(law) => law.advance(position_m),
            Self::Reflected { .. } => {}
            Self::Wave(law) => law.advance(moved, applied_n),
            Self::Observed(law) => law.advance(position_m, moved, applied_n),
        }
    }

    /// State for the other side.
    pub(crate) fn state(&self, position_m: f64, applied_n: f64) -> HandState {
        match self {
            Self::Position(_) | Self::Reflected { .. } => HandState::Position { position_m },
            Self::Reflecting(_) => HandState::Force { force_n: applied_n },
            Self::Wave(law) => {
                let (sum, energy_j) = law.integrals();
                HandState::Wave { sum, energy_j }
            }
            Self::Observed(law) => HandState::Energy {
                position_m,
                energy_j: law.account.sent_j,
            },
        }
    }

    pub(crate) const fn account(&self) -> Option<&Account> {
        match self {
            Self::Wave(law) => Some(&law.account),
            Self::Observed(law) => Some(&law.account),
            Self::Position(_) | Self::Reflecting(_) | Self::Reflected { .. } => None,
        }
    }
}

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
            // Scaled down in the same direction; given > 0.
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
}

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
    impedance: f64,
    /// √(2b).
    root: f64,
    /// 1/N.
    share: f64,
    sample_time: f64,
    /// T·Σw that has come and that was taken, T·Σu that has left.
    received: f64,
    taken: f64,
    left: f64,
    account: Account,
}

impl WavePort {
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
        // Energy that comes out of the line, and energy that the device puts in.
        let came = 0.5 * t * wave * wave;
        let budget = came - applied_n * moved;
        let outgoing = (self.impedance * moved / t - applied_n) / self.root;
        let most = libm::sqrt(2.0 * budget.max(0.0) / t);
        let outgoing = outgoing.clamp(-most, most);
        let sent = 0.5 * t * outgoing * outgoing;
        self.left += t * outgoing;
        // The remainder is given up: as heat it can do no harm. A debt stays.
        self.account.book(budget.min(sent) - came);
        self.account.send(sent);
    }

    /// T·Σu and T·Σu²/2.
    const fn integrals(&self) -> (f64, f64) {
        (self.left, self.account.sent_j)
    }
}

/// Books of a port: no more leaves it, into the device or to the other side, than has come in.
///
/// ```text
/// balance = received from the other side + Σ F·Δx of this side − sent to the other side − what was dissipated
/// ```
/// All energies are sums from the start, so a message that is lost costs nothing once the next one has come.
/// A balance below 0 is a debt: the safety chain made a force that nobody wanted. It is paid from what comes in next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Account {
    pub balance_j: f64,
    received_j: f64,
    sent_j: f64,
}

impl Account {
    /// Takes in the sum that the other side has sent. A smaller one than before is ignored.
    pub(crate) fn receive(&mut self, total_j: f64) {
        let fresh = total_j - self.received_j;
        // Not for a NaN.
        if fresh > 0.0 && fresh.is_finite() {
            self.balance_j += fresh;
            self.received_j = total_j;
        }
    }

    /// Energy that may be spent now, J, at least 0.
    const fn available_j(&self) -> f64 {
        self.balance_j.max(0.0)
    }

    /// Books what went in, J; what came out is negative.
    fn book(&mut self, energy_j: f64) {
        self.balance_j += energy_j;
    }

    /// Sends this energy, J ≥ 0.
    pub(crate) fn send(&mut self, energy_j: f64) {
        self.balance_j -= energy_j;
        self.sent_j += energy_j;
    }
}
