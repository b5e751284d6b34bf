//! Names of what a servo and its adapter can do wrong, and what helps.

use core::fmt;
use haptic_remote::serial::TroubleCause;
use moteus_protocol::Mode;

/// Why a servo cannot be used any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Trouble {
    /// The port is gone.
    Gone,
    /// No answer for so many ticks in a row.
    Silent {
        /// Number of the servo.
        id: u8,
        /// Ticks.
        ticks: u32,
        /// Anything else that came meanwhile.
        instead: Instead,
    },
    /// The servo has a fault of its own.
    Fault {
        /// Number of the servo.
        id: u8,
        /// Its code, as in the maker's list.
        code: i8,
    },
    /// The servo heard nothing for its watchdog time, and has let go.
    WatchdogLetGo {
        /// Number of the servo.
        id: u8,
    },
    /// The servo is in a mode that nobody here has asked for.
    OtherMode {
        /// Number of the servo.
        id: u8,
        /// Number of the mode, as in the maker's list.
        mode: u8,
    },
    /// The servo does not know its position.
    NotFinite {
        /// Number of the servo.
        id: u8,
    },
    /// A frame of another servo, or to another program.
    OtherSpeaker {
        /// Number of the servo that was asked.
        id: u8,
        /// Number of the sender.
        from: u8,
        /// Number of whom it is for; 0 is this program.
        to: u8,
    },
}

impl Trouble {
    /// Where its cause lies.
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

/// What came in place of an answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Instead {
    /// Frames that the adapter took.
    pub taken: u32,
    /// Lines in which it complained.
    pub refused: u32,
    /// Lines that are none of an adapter, or were damaged; answers that cannot be.
    pub garbage: u32,
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Gone => f.write_str("the adapter is gone: look at its plug and its supply"),
            Self::Silent { id, ticks, instead } => {
                write!(f, "servo {id} did not answer {ticks} times in a row: ")?;
                instead.fmt(f)
            }
            Self::Fault { id, code } => write!(
                f,
                "servo {id} is in fault {code}, {}: mend that, then begin again, which clears it",
                meaning(code)
            ),
            Self::WatchdogLetGo { id } => write!(
                f,
                "servo {id} heard nothing for its watchdog time and has let go: this machine was too busy; give the \
                 loop a core and priority, or a longer `watchdog`"
            ),
            Self::OtherMode { id, mode: 0 } => write!(
                f,
                "servo {id} has stopped: it was switched off and on, or another program has stopped it; look at its supply, \
                 end the other program"
            ),
            Self::OtherMode { id, mode } => write!(
                f,
                "servo {id} is in mode {mode}, {}, which nobody here has asked for: another program commands it; end that",
                Mode::try_from(mode).map_or("unknown", mode_name)
            ),
            Self::NotFinite { id } => write!(
                f,
                "servo {id} does not know its position: look at its encoder with the maker's `tview`"
            ),
            Self::OtherSpeaker { id, from, to } => write!(
                f,
                "servo {from} talks to {to} on the bus of servo {id}: name the right servo with `id`, and end other \
                 programs on this bus"
            ),
        }
    }
}

impl core::error::Error for Trouble {}

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
                "{garbage} lines that are none of an fdcanusb came; is this the right port, and does no other program \
                 use it?"
            ),
            _ => f.write_str("nothing came; is this the right port, and is the adapter plugged in?"),
        }
    }
}

/// Words for a fault, from the maker's list of codes.
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

const fn mode_name(mode: Mode) -> &'static str {
    match mode {
        Mode::Stopped => "stopped",
        Mode::Position => "position",
        Mode::Timeout => "timeout",
        Mode::ZeroVelocity => "zero velocity",
        Mode::Brake => "brake",
        Mode::Current => "current",
        Mode::StayWithin => "stay within",
        _ => "one of the rarer ones",
    }
}
