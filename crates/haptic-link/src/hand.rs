//! Two hands over a line: what each side says to the other, in frames [from a host](crate::Direction::FromHost), one
//! to a datagram. The connection is 0 in a hello and then the numbers of both, xored.

use crate::report::MessageKey;
use haptic_loop::enumerated;
use postcard_schema::{Schema, key::Key};
use serde::{Deserialize, Serialize};

/// A message from one side to the other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum HandMessage {
    /// Identity and settings of the speaker. Its layout stays in all versions to come.
    Hello(HandHello),
    /// One tick of the speaker, for the law of the other.
    Sample(HandSample),
    /// The speaker has come to rest and goes.
    Bye,
    /// Answer to a stranger: the speaker is at work with somebody else.
    Busy {
        /// Number of the one that asked.
        #[serde(with = "postcard::fixint::le")]
        heard: u32,
    },
}

/// Side of a line between two hands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum HandSide {
    /// The hand that the operator holds.
    Master,
    /// The hand in the remote place, which follows.
    Slave,
}

impl core::fmt::Display for HandSide {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Master => "master",
            Self::Slave => "slave",
        })
    }
}

enumerated! {
    /// Coupling of the two sides.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
    pub enum Architecture {
        /// Each side is pulled to the place of the other by a fractional coupler.
        PositionPosition "position-position",
        /// The slave is pulled to the place of the master, which feels the force of that coupler.
        PositionForce "position-force",
        /// Waves (b·v + F)/√(2b): passive at any delay.
        Wave "wave",
        /// Position–position, whose force gives back no more energy than has come from the other side: passive at any delay.
        TimeDomain "time-domain",
    }
}

impl Architecture {
    /// True if the line between the two sides gives no energy, whatever its delay.
    #[must_use]
    pub const fn is_passive(self) -> bool {
        match self {
            Self::PositionPosition | Self::PositionForce => false,
            Self::Wave | Self::TimeDomain => true,
        }
    }
}

impl core::fmt::Display for Architecture {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.name())
    }
}

/// The first message of each side.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct HandHello {
    /// Hash of the messages that the sender knows.
    pub key: MessageKey,
    /// A random number that the sender chose for this connection.
    #[serde(with = "postcard::fixint::le")]
    pub nonce: u32,
    /// The other side's nonce once it has arrived; 0 before.
    #[serde(with = "postcard::fixint::le")]
    pub heard: u32,
    /// Side of the sender; two masters or two slaves refuse to connect.
    pub side: HandSide,
    /// Architecture of the sender; both sides must use the same.
    pub architecture: Architecture,
    /// Sample time T of the sender, s; both sides must use the same.
    pub sample_time_s: f64,
    /// b of the waves, N·s/m; 0 for other architectures.
    pub wave_impedance_n_s_per_m: f64,
    /// Digest of the coupler, which both sides must share, see [`hand_digest`](crate::hand_digest); 0 for waves.
    #[serde(with = "postcard::fixint::le")]
    pub coupler_digest: u32,
}

impl HandHello {
    /// Hash of the messages of this version of the crate.
    pub const KEY: MessageKey = {
        let hash = u64::from_le_bytes(Key::for_path::<HandMessage>("hand").to_bytes());
        MessageKey((hash >> 32) as u32 ^ hash as u32)
    };
}

/// One tick of one side, sent to the other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct HandSample {
    /// Number of the sample, modulo 2³².
    #[serde(with = "postcard::fixint::le")]
    pub sequence: u32,
    /// The device's own time since its start, s.
    pub time_s: f64,
    /// The quantities that the other side's law needs.
    pub state: HandState,
}

/// The state that one side sends. Sums run from its start, so the next sample makes up for a lost
/// one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum HandState {
    /// Displacement from the start, m.
    Position {
        /// x, the displacement since the start, m.
        position_m: f64,
    },
    /// Force of the coupler on the slave.
    Force {
        /// f, the force that acts on the slave, N.
        force_n: f64,
    },
    /// Sums over all waves that have left.
    Wave {
        /// T·Σu of all of them, √J·√s.
        sum: f64,
        /// T·Σu²/2, J.
        energy_j: f64,
    },
    /// Displacement, and energy that the other side may spend.
    Energy {
        /// x, the displacement since the start, m.
        position_m: f64,
        /// All energy that has been sent, J.
        energy_j: f64,
    },
}
