//! The law of a port at work: what it hears, wants and says.

use crate::account::Account;
use crate::coupled::{Coupled, Observed};
use crate::wave::WavePort;
use fracdiff::Differintegrator;
use haptic_link::HandState;

/// A law with its state.
#[derive(Clone, Debug)]
pub(crate) enum Law<O: Differintegrator<f64>> {
    /// A coupler that tells its place.
    Position(Coupled<O>),
    /// A coupler that tells its force: the slave of position–force.
    Reflecting(Coupled<O>),
    /// The master of position–force: the force of the slave's coupler, turned round.
    Reflected { force_n: f64 },
    /// Waves.
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

    /// What the other side is told.
    pub(crate) fn said(&self, position_m: f64, applied_n: f64) -> HandState {
        match self {
            Self::Position(_) | Self::Reflected { .. } => HandState::Position { position_m },
            Self::Reflecting(_) => HandState::Force { force_n: applied_n },
            Self::Wave(law) => {
                let (sum, energy_j) = law.said();
                HandState::Wave { sum, energy_j }
            }
            Self::Observed(law) => HandState::Energy {
                position_m,
                energy_j: law.account().sent_j(),
            },
        }
    }

    /// The account of a passive law.
    pub(crate) const fn account(&self) -> Option<&Account> {
        match self {
            Self::Wave(law) => Some(law.account()),
            Self::Observed(law) => Some(law.account()),
            _ => None,
        }
    }
}
