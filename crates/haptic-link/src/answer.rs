//! The answer to a request, and why it may be refused.

use crate::field::Field;
use crate::status::State;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// The answer to a request.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Ack {
    /// Sequence number of the request, its lower half.
    #[serde(with = "postcard::fixint::le")]
    pub sequence: u16,
    /// First byte of the request.
    pub request: u8,
    /// The fate of the request.
    pub outcome: Outcome,
}

/// The fate of a request.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum Outcome {
    /// Done, or true already.
    Done,
    /// Refused; nothing has changed.
    Refused(Refusal),
}

/// Why a request was refused.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum Refusal {
    /// Not in this state.
    State(State),
    /// A parameter outside the range of this device.
    Range {
        /// The field.
        field: Field,
        /// As it was sent.
        value: f32,
        /// Least value allowed.
        least: f32,
        /// Largest value allowed.
        most: f32,
    },
    /// The digest is not that of what is staged: something was lost on the way.
    Digest,
    /// Nothing is staged, or not all coefficients.
    Incomplete,
    /// Not on this board.
    Unsupported(Field),
    /// A fault has latched that the host does not know of yet.
    UnknownFault,
    /// The force has not fallen to zero yet.
    ForceNotZero,
    /// The force at this position would be larger than a start allows.
    ForceNotSmall {
        /// Wanted force, N.
        wanted_n: f32,
        /// Largest allowed at a start, N.
        allowed_n: f32,
    },
    /// The condition of this fault still holds, as an open emergency stop.
    FaultPersists(u8),
    /// The device does not know this connection, or another one has armed it.
    Connection,
    /// A limit of a configuration for a run is looser than what was set to last.
    Looser(Field),
}
