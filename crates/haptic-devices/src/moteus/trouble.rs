//! Names of what a servo and its adapter can do wrong, and what helps.

use crate::name::NameError;
use core::fmt;
use haptic_remote::serial::{SerialError, TroubleCause};
use moteus_protocol::Mode;
use thiserror::Error;

/// A servo that cannot be opened.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MoteusOpenError {
    /// The port cannot be opened.
    #[error(transparent)]
    Port(#[from] SerialError),
    /// A setting outside its range.
    #[error(transparent)]
    Settings(#[from] NameError),
    /// The servo or its adapter.
    #[error(transparent)]
    Trouble(#[from] MoteusTrouble),
    /// Reads of the port cannot be made not to wait.
    #[error("{path}: the port cannot be read without waiting: {error}")]
    Patience {
        /// Path of the port, as it was given.
        path: String,
        /// Reason in the words of the system.
        error: std::io::Error,
    },
}

/// Why a servo cannot be used any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MoteusTrouble {
    /// The port takes or gives no bytes any more.
    #[error("the adapter is gone: check its plug and power supply")]
    Gone,
    /// No answer for this many ticks in a row.
    #[error("servo {id} did not answer {ticks} times in a row: {instead}")]
    Silent {
        /// Number of the servo on its bus.
        id: u8,
        /// Frames in a row to which no answer came.
        ticks: u32,
        /// Anything else that came meanwhile.
        instead: Instead,
    },
    /// The servo has a fault of its own.
    #[error(
        "servo {id} is in fault {code}, {}: fix that, then start again, which clears it", meaning(*.code)
    )]
    Fault {
        /// Number of the servo on its bus.
        id: u8,
        /// Its code, as in the maker's list.
        code: i8,
    },
    /// The servo heard nothing for its watchdog time, and has let go.
    #[error(
        "servo {id} heard nothing for its watchdog time: this machine was too busy; give a longer `watchdog`"
    )]
    WatchdogLetGo {
        /// Number of the servo on its bus.
        id: u8,
    },
    /// The servo is in a mode that nobody here has asked for.
    #[error("servo {id} {}", unasked(*.mode))]
    OtherMode {
        /// Number of the servo on its bus.
        id: u8,
        /// Number of the mode, as in the maker's list.
        mode: u8,
    },
    /// The servo does not know its position.
    #[error("servo {id} does not know its position: check its encoder with the maker's `tview`")]
    NotFinite {
        /// Number of the servo on its bus.
        id: u8,
    },
    /// A frame of another servo, or to another program.
    #[error(
        "servo {from} talks to {to} on the bus of servo {id}: name the right servo with `id`, and end other programs on this bus"
    )]
    OtherSpeaker {
        /// Number of the servo that was asked.
        id: u8,
        /// Number of the servo that has sent the frame.
        from: u8,
        /// Number of whom it is for; 0 is this program.
        to: u8,
    },
}

impl MoteusTrouble {
    /// Says whether the user should check the servo, its line or this machine.
    #[must_use]
    pub const fn cause(self) -> TroubleCause {
        match self {
            Self::Gone | Self::Silent { .. } => TroubleCause::Gone,
            Self::WatchdogLetGo { .. } => TroubleCause::HostLate,
            Self::Fault { .. }
            | Self::OtherMode { .. }
            | Self::NotFinite { .. }
            | Self::OtherSpeaker { .. } => TroubleCause::Board,
        }
    }
}

/// Messages that arrived instead of an answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Instead {
    /// Frames that the adapter acknowledged.
    pub taken: u32,
    /// Lines in which it reported an error.
    pub refused: u32,
    /// Lines that an adapter does not send, or that were damaged; answers that cannot be.
    pub garbage: u32,
}

impl fmt::Display for Instead {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self { refused, .. } if refused > 0 => {
                f.write_str("the adapter refuses the frames; is the CAN bus connected and terminated?")
            }
            Self { taken, .. } if taken > 0 => f.write_str(
                "the adapter works, so look at the servo: its power, its CAN cable, its number (`id`)",
            ),
            Self { garbage, .. } if garbage > 0 => write!(
                f,
                "{garbage} lines that are none of an fdcanusb came: is this the right port, for this program alone?"
            ),
            _ => f.write_str("nothing came; is this the right port, and is the adapter plugged in?"),
        }
    }
}

const fn meaning(code: i8) -> &'static str {
    match code {
        32 => "calibration: it sensed no magnet",
        33 => "motor driver: most often a supply that is too weak",
        34 => "over voltage: the supply cannot take back the energy of braking",
        35 => "encoder: it senses no magnet",
        36 => "motor not configured: calibrate it with moteus_tool first",
        37 => "cycle overrun, an error of its firmware",
        38 => "over temperature: let it cool",
        39 => "outside its own limits of position",
        40 => "under voltage",
        41 => "its configuration was changed while it ran",
        42 => "no encoder for commutation",
        43 => "no encoder of its output",
        44 => "its gate driver cannot be switched on",
        _ => "see the maker's list of fault codes",
    }
}

fn unasked(mode: u8) -> String {
    let name = match Mode::try_from(mode) {
        Ok(Mode::Stopped) => {
            return "has stopped: it was switched off and on, or another program stopped it"
                .to_owned();
        }
        Ok(Mode::Position) => "position",
        Ok(Mode::Timeout) => "timeout",
        Ok(Mode::ZeroVelocity) => "zero velocity",
        Ok(Mode::Brake) => "brake",
        Ok(Mode::Current) => "current",
        Ok(Mode::StayWithin) => "stay within",
        Ok(_) => "one of the rarer ones",
        Err(_) => "unknown",
    };
    format!(
        "is in mode {mode}, {name}, which this program did not ask for: another program commands it; end that"
    )
}
