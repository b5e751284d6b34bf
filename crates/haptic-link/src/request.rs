//! Messages of a host to a device, and why they may be refused.

#[cfg(feature = "controllers")]
use crate::configuration::WorkspaceBox;
#[cfg(feature = "controllers")]
use crate::controller::ControllerLaw;
#[cfg(feature = "several-axes")]
use crate::surface::SurfaceShape;
use crate::{
    configuration::{CoefficientBlock, Configuration},
    sample::AXES_MAX,
};
use heapless::Vec;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Number of requests, the first ones, that a device of one axis accepts.
pub(crate) const ONE_AXIS_REQUESTS: usize = 17;
/// Number of those that a device of several axes accepts too.
pub(crate) const AXES_REQUESTS: usize = 18;
pub(crate) const CONTROLLER_REQUESTS: usize = 20;
pub(crate) const REQUESTS: usize = if cfg!(feature = "several-axes") {
    21
} else if cfg!(feature = "controllers") {
    CONTROLLER_REQUESTS
} else {
    ONE_AXIS_REQUESTS
};

/// A message from host to device. The number of a variant is its first byte on the wire, from 0.
/// New variants are added at the end.
///
/// Every request but [`Force`](Self::Force) is answered: with its own report where one is named,
/// otherwise with a [`DeviceReport::Ack`](crate::DeviceReport::Ack). All but that one may be sent
/// again when the answer does not come.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum Request {
    /// Asks for a connection. Changes nothing: the connection begins with the first frame that carries its number.
    /// Answer: [`DeviceReport::Hello`](crate::DeviceReport::Hello).
    Hello {
        /// Comes back in the answer; another number for each hello, but the same when one is sent again.
        #[serde(with = "postcard::fixint::le")]
        nonce: u32,
    },
    /// Answer: [`DeviceReport::Capabilities`](crate::DeviceReport::Capabilities).
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
        /// The time for which it is in force.
        scope: Scope,
    },
    /// Answer: [`DeviceReport::Configuration`](crate::DeviceReport::Configuration).
    GetConfiguration,
    /// Answer: [`DeviceReport::Coefficients`](crate::DeviceReport::Coefficients).
    GetCoefficients {
        /// Place of the first coefficient that is asked for, a multiple of 16.
        #[serde(with = "postcard::fixint::le")]
        offset: u16,
    },
    /// Arms the device, from idle, or from a fault whose force has fallen to zero: zero force, but ready. Clears
    /// the fault.
    Arm {
        /// Number of faults since power-up that the host knows of, from [`Status`](crate::Status): an arm
        /// that was on its way when a fault latched cannot clear it.
        #[serde(with = "postcard::fixint::le")]
        faults: u16,
    },
    /// Disarms the device, to idle; the force falls to zero within the stop time. A fault stays.
    Disarm,
    /// Begins a run, from armed to running.
    Start(Start),
    /// Ends a run: the force falls to zero within the stop time, then the device is armed.
    Stop,
    /// The force on the device from the next tick on, in [`LoopMode::Host`](crate::LoopMode::Host). Not
    /// answered.
    Force {
        /// The tick whose sample it answers.
        #[serde(with = "postcard::fixint::le")]
        tick: u32,
        /// N, an element an axis; one that is not finite latches a fault, another number of them is no force.
        force_n: Vec<f32, AXES_MAX>,
    },
    /// The host is there. Any other frame says so too. Answer: [`DeviceReport::Alive`](crate::DeviceReport::Alive).
    KeepAlive {
        /// Comes back in the answer, to measure the round trip.
        #[serde(with = "postcard::fixint::le")]
        token: u32,
    },
    /// Answer: [`DeviceReport::Statistics`](crate::DeviceReport::Statistics).
    GetStatistics,
    /// A sample from before and after the last fault. Answer: [`DeviceReport::Flight`](crate::DeviceReport::Flight).
    ReadFlight {
        /// Number of the sample from 0, the oldest.
        #[serde(with = "postcard::fixint::le")]
        index: u16,
    },
    /// Selects the samples that are sent outside of runs, and their form.
    Stream {
        /// Send every n-th tick; 0 sends none.
        #[serde(with = "postcard::fixint::le")]
        every: u16,
        /// Samples in a frame: 1 sends [`DeviceReport::Sample`](crate::DeviceReport::Sample), 2 to [`BATCH_MAX`](crate::BATCH_MAX)
        /// [`DeviceReport::Batch`](crate::DeviceReport::Batch).
        batch: u8,
    },
    /// Answer: [`DeviceReport::Keys`](crate::DeviceReport::Keys).
    GetKeys,
    /// Stages a workspace of its own for each of several axes, for a run.
    #[cfg(feature = "controllers")]
    Workspace(WorkspaceBox),
    /// Asks what a controller costs on a device that runs them. Answer: [`DeviceReport::ControllerCost`](crate::DeviceReport::ControllerCost).
    #[cfg(feature = "controllers")]
    GetControllerCost,
    /// Stages a controller in place of the law of the configuration, for a run; the coefficients are its own.
    #[cfg(feature = "controllers")]
    Controller(ControllerLaw),
    /// Stages the surface that the law of the configuration lies behind, on a device of several axes, for a run.
    #[cfg(feature = "several-axes")]
    Surface(SurfaceShape),
}

/// Time for which a configuration stays in force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Scope {
    /// Until another connection begins, or something else is staged; then what was set to last is in force again. No
    /// limit may be looser than there, see [`Limits::tightened`](crate::Limits::tightened).
    #[default]
    Run,
    /// Until it is replaced or the device is reset. Limits may be loosened, up to those of the board.
    Lasting,
}

impl Request {
    /// Names of the requests, indexed by number.
    pub const NAMES: [&'static str; REQUESTS] = [
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
        "get-keys",
        #[cfg(feature = "controllers")]
        "workspace",
        #[cfg(feature = "controllers")]
        "get-controller-cost",
        #[cfg(feature = "controllers")]
        "controller",
        #[cfg(feature = "several-axes")]
        "surface",
    ];

    /// The first byte of this request on the wire.
    #[must_use]
    pub const fn number(&self) -> u8 {
        match self {
            Self::Hello { .. } => 0,
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
            Self::GetKeys => 16,
            #[cfg(feature = "controllers")]
            Self::Workspace(_) => 17,
            #[cfg(feature = "controllers")]
            Self::GetControllerCost => 18,
            #[cfg(feature = "controllers")]
            Self::Controller(_) => 19,
            #[cfg(feature = "several-axes")]
            Self::Surface(_) => 20,
        }
    }

    /// The name of this request, as errors quote it.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        Self::NAMES[self.number() as usize]
    }
}

/// A run that begins at tick 0 with its history at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Start {
    /// A number that the host chooses. Requesting the run that is already under way changes
    /// nothing, so the request can be repeated.
    #[serde(with = "postcard::fixint::le")]
    pub run: u32,
    /// Number of ticks after which the device stops on its own; 0 means it does not.
    #[serde(with = "postcard::fixint::le")]
    pub ticks: u32,
    /// Send every n-th tick, n at least 1.
    #[serde(with = "postcard::fixint::le")]
    pub every: u16,
    /// Number of samples in a frame, as in [`Request::Stream`].
    pub batch: u8,
}

impl Start {
    /// Run 1, which lasts until stopped and sends each tick in its own frame.
    pub const ENDLESS: Self = Self {
        run: 1,
        ticks: 0,
        every: 1,
        batch: 1,
    };
}
