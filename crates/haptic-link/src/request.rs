//! What a host says to a device.

use crate::configuration::{COEFFICIENTS_PER_BLOCK, Configuration};
use crate::report::Report;
use postcard_schema::Schema;
use postcard_schema::key::Key;
use serde::{Deserialize, Serialize};

/// From host to device. The number of a variant is its first byte on the wire, from 0.
///
/// Every request but [`Force`](Self::Force) is answered: with a report of its own where one is named,
/// with a [`Report::Ack`] otherwise. All but `Force` may be sent again when the answer does not come.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum Request {
    /// Begins a session: stops streams, forgets staged parameters. Answer: [`Report::Hello`].
    Hello(Keys),
    /// Answer: [`Report::Capabilities`].
    GetCapabilities,
    /// Stages everything but the coefficients, and forgets those staged before.
    Configure(Configuration),
    /// Stages 16 coefficients.
    Coefficients(CoefficientBlock),
    /// Makes what is staged the configuration, all of it or nothing. Only while idle or in a fault.
    Commit {
        /// See [`DigestBuilder`](crate::DigestBuilder).
        #[serde(with = "postcard::fixint::le")]
        digest: u32,
    },
    /// Answer: [`Report::Configuration`].
    GetConfiguration,
    /// Answer: [`Report::Coefficients`].
    GetCoefficients {
        /// Of the first coefficient.
        #[serde(with = "postcard::fixint::le")]
        offset: u16,
    },
    /// From idle, or from a fault whose force has fallen to zero, to armed: zero force, but ready. Clears
    /// the fault.
    Arm {
        /// Number of faults since power-up that the host knows of, from [`Status`](crate::Status): an arm
        /// that was on its way when a fault latched cannot clear it.
        #[serde(with = "postcard::fixint::le")]
        faults: u16,
    },
    /// To idle; the force falls to zero within the stop time. A fault stays.
    Disarm,
    /// From armed to running.
    Start(Start),
    /// Ends a run: the force falls to zero within the stop time, then the device is armed.
    Stop,
    /// The force on the device from the next tick on, in [`LoopMode::Host`](crate::LoopMode::Host). Not
    /// answered.
    Force {
        /// The tick whose sample it answers.
        #[serde(with = "postcard::fixint::le")]
        tick: u32,
        /// N; not finite latches a fault.
        force_n: f32,
    },
    /// The host is there. Any other frame says so too. Answer: [`Report::Alive`].
    KeepAlive {
        /// Comes back in the answer, to measure the round trip.
        #[serde(with = "postcard::fixint::le")]
        token: u32,
    },
    /// Answer: [`Report::Statistics`].
    GetStatistics,
    /// A sample from before and after the last fault. Answer: [`Report::Flight`].
    ReadFlight {
        /// From 0, the oldest.
        #[serde(with = "postcard::fixint::le")]
        index: u16,
    },
    /// Which samples are sent while none but a run's are asked for, and how.
    Stream {
        /// Each how manyth tick is sent; 0 none.
        #[serde(with = "postcard::fixint::le")]
        every: u16,
        /// Samples in a frame: 1 sends [`Report::Sample`], 2 to [`BATCH_MAX`](crate::BATCH_MAX)
        /// [`Report::Batch`].
        batch: u8,
    },
}

impl Request {
    /// Names of the requests, by number.
    pub const NAMES: [&'static str; 16] = [
        "hello",
        "get-capabilities",
        "configure",
        "coefficients",
        "commit",
        "get-configuration",
        "get-coefficients",
        "arm",
        "disarm",
        "start",
        "stop",
        "force",
        "keep-alive",
        "get-statistics",
        "read-flight",
        "stream",
    ];

    /// The first byte of this request on the wire.
    #[must_use]
    pub const fn number(&self) -> u8 {
        match self {
            Self::Hello(_) => 0,
            Self::GetCapabilities => 1,
            Self::Configure(_) => 2,
            Self::Coefficients(_) => 3,
            Self::Commit { .. } => 4,
            Self::GetConfiguration => 5,
            Self::GetCoefficients { .. } => 6,
            Self::Arm { .. } => 7,
            Self::Disarm => 8,
            Self::Start(_) => 9,
            Self::Stop => 10,
            Self::Force { .. } => 11,
            Self::KeepAlive { .. } => 12,
            Self::GetStatistics => 13,
            Self::ReadFlight { .. } => 14,
            Self::Stream { .. } => 15,
        }
    }

    /// Its name.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        Self::NAMES[self.number() as usize]
    }
}

/// Hashes of the message definitions: FNV-1a over the names and types of all fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Keys {
    /// Of [`Request`].
    #[serde(with = "postcard::fixint::le")]
    pub request: u64,
    /// Of [`Report`].
    #[serde(with = "postcard::fixint::le")]
    pub report: u64,
}

impl Keys {
    /// Of the messages in this version of the crate.
    pub const CURRENT: Self = Self {
        // The schema does not see that integers have a fixed length, hence the name.
        request: u64::from_le_bytes(
            Key::for_path::<Request>("haptic-link/request/fixint").to_bytes(),
        ),
        report: u64::from_le_bytes(Key::for_path::<Report>("haptic-link/report/fixint").to_bytes()),
    };
}

/// Sixteen coefficients of the operator; the last block is filled up with zeros.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct CoefficientBlock {
    /// Of the first one, a multiple of 16.
    #[serde(with = "postcard::fixint::le")]
    pub offset: u16,
    /// In the order of [`OperatorForm`](crate::OperatorForm).
    pub values: [f32; COEFFICIENTS_PER_BLOCK],
}

/// A run to begin: history at rest, tick 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Start {
    /// A number that the host chooses. Asking for the run that is under way changes nothing, so the
    /// request can be repeated.
    #[serde(with = "postcard::fixint::le")]
    pub run: u32,
    /// Ticks until the device stops by itself; 0 for none.
    #[serde(with = "postcard::fixint::le")]
    pub ticks: u32,
    /// Each how manyth tick is sent, at least 1.
    #[serde(with = "postcard::fixint::le")]
    pub every: u16,
    /// Samples in a frame, as in [`Request::Stream`].
    pub batch: u8,
}
