//! Messages of a device to its host.

use crate::answer::Ack;
use crate::coefficients::CoefficientBlock;
use crate::configuration::Configuration;
use crate::identity::{Capabilities, Hello};
use crate::keys::{Keys, REPORTS};
use crate::sample::{Batch, Flight, Sample};
use crate::statistics::Statistics;
use crate::status::{Alive, Event, FaultReport};
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// From device to host. The number of a variant is its first byte on the wire, from 0. New ones come at the end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum Report {
    /// Answers [`Request::Hello`](crate::Request::Hello).
    Hello(Hello),
    /// The device and its abilities.
    Capabilities(Capabilities),
    /// Answers every request without a report of its own, but not forces.
    Ack(Ack),
    /// The configuration in force.
    Configuration {
        /// All but the coefficients.
        configuration: Configuration,
        /// Over both, see [`DigestBuilder`](crate::DigestBuilder).
        #[serde(with = "postcard::fixint::le")]
        digest: u32,
    },
    /// Sixteen coefficients of the configuration in force.
    Coefficients(CoefficientBlock),
    /// One tick.
    Sample(Sample),
    /// Several ticks.
    Batch(Batch),
    /// Something happened.
    Event(Event),
    /// A fault latched.
    Fault(FaultReport),
    /// All counters.
    Statistics(Statistics),
    /// Answers [`Request::KeepAlive`](crate::Request::KeepAlive).
    Alive(Alive),
    /// A sample of the flight recorder.
    Flight(Flight),
    /// The keys of all messages that the device knows.
    Keys(Keys),
}

impl Report {
    /// Names of the reports, by number.
    pub const NAMES: [&'static str; REPORTS] = [
        "hello",
        "capabilities",
        "ack",
        "configuration",
        "coefficients",
        "sample",
        "batch",
        "event",
        "fault",
        "statistics",
        "alive",
        "flight",
        "keys",
    ];
}
