//! Names of what an Inverse Service and its devices can do wrong, and what helps.

use super::in_time::PATIENCE;
use haptic_remote::serial::TroubleCause;
use std::io::Error;
use thiserror::Error;

/// An Inverse3 that cannot be opened.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Inverse3OpenError {
    /// Nothing takes the connection, or it ends at once.
    #[error(
        "no Inverse Service at {address}: {error}; start it, or Haply Hub, or name the machine as inverse3:HOST:PORT"
    )]
    NoService {
        /// Host and port that were tried.
        address: String,
        /// Reason in the words of the system.
        error: Error,
    },
    /// Whoever is there has not said in time what a service says.
    #[error(
        "{address} did not finish its greeting within {} s: restart the Inverse Service, or name another machine or port as inverse3:HOST:PORT",
        PATIENCE.as_secs()
    )]
    Slow {
        /// Host and port that were tried.
        address: String,
    },
    /// Another program is at that port.
    #[error(
        "{address} is not an Inverse Service: it says `{reply}`; name its port as inverse3:HOST:PORT, by default 10001"
    )]
    NotService {
        /// Host and port that were tried.
        address: String,
        /// Its answer, if that is short.
        reply: String,
    },
    /// A service that speaks another protocol.
    #[error(
        "the Inverse Service is version {found}, and this program needs 3.5 or a later 3: install one, with Haply Hub"
    )]
    Version {
        /// The version that the service states.
        found: String,
    },
    /// Nothing of this family is plugged in.
    #[error("the Inverse Service knows no Inverse3: plug it in and switch it on")]
    NoDevice,
    /// More than one device, and no number; or another number.
    #[error("{reason}: the Inverse Service knows {known}; give one of them as id=ID")]
    Which {
        /// Says which number was asked for, if any.
        reason: String,
        /// All numbers that there are, with commas between.
        known: String,
    },
    /// A device that is not ready to make a force.
    #[error("Inverse3 {id} {why}")]
    NotReady {
        /// Number of the device at its service.
        id: String,
        /// Says what it lacks, and the remedy.
        why: &'static str,
    },
    /// Settings that were asked for and not taken.
    #[error(
        "the Inverse Service has {setting} = {value} after it was told another: end other programs that set it, such as Haply Hub's demos"
    )]
    NotTaken {
        /// The setting that was read back.
        setting: &'static str,
        /// The value that it has; `null` if it is not reported.
        value: String,
    },
    /// A line was chosen for an experiment with all axes.
    #[error(
        "axis chooses a line for an experiment with one axis, and this one uses all three: omit it"
    )]
    Line,
    /// Its first answers show a trouble.
    #[error(transparent)]
    Trouble(#[from] Inverse3Trouble),
}

/// Why an Inverse3 cannot be used any more.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Inverse3Trouble {
    /// The service has ended the connection.
    #[error(
        "the Inverse Service has closed the connection: it was stopped, or another program reset it"
    )]
    Gone,
    /// No answer for this many ticks in a row.
    #[error(
        "the Inverse Service did not answer for {ticks} ticks in a row: its machine is too busy; give a larger `lost`, up to 1000, or a longer sample time"
    )]
    Silent {
        /// Ticks in a row without an answer.
        ticks: u32,
    },
    /// Text that no service of this version sends.
    #[error(
        "an answer of the Inverse Service is not JSON with a list `inverse3` of at most {DEVICES_MOST} devices"
    )]
    Unreadable,
    /// The answer does not list the device any more.
    #[error("the Inverse Service does not list it any more: check its cable and power")]
    Vanished,
    /// The answer has no position, or not three numbers.
    #[error("the Inverse Service tells no position of it: calibrate it anew")]
    NoPosition,
    /// The position moved faster than a hand does.
    #[error(
        "its position moved {step_mm:.1} mm in {time_ms:.1} ms, faster than a hand: another program changed its mount, basis or preset, or it was calibrated anew"
    )]
    Jump {
        /// Distance from the last position that was believed, mm.
        step_mm: f64,
        /// Time that it had for it, ms.
        time_ms: f64,
    },
}

impl Inverse3Trouble {
    /// Says whether the user should check the device or its service.
    #[must_use]
    pub const fn cause(self) -> TroubleCause {
        match self {
            Self::Gone | Self::Silent { .. } | Self::Vanished => TroubleCause::Gone,
            Self::Unreadable | Self::NoPosition | Self::Jump { .. } => TroubleCause::Board,
        }
    }
}

/// Devices of this family at one service; more are refused.
pub(super) const DEVICES_MOST: usize = 8;
