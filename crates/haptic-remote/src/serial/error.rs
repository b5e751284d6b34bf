//! Errors of a serial device, and what a served board says of its last fault.

use crate::LinkError;
use core::fmt;
use std::string::{String, ToString as _};
use thiserror::Error;

/// Why a serial device cannot be used, or not any more.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SerialError {
    /// The system has no port of this name.
    #[error("there is no port {path}, {}", in_its_place(others))]
    NotFound {
        /// Path of the port, as it was given.
        path: String,
        /// Ports that the system has, with commas between.
        others: String,
    },
    /// Somebody else has it open.
    #[error(
        "port {path} is in use by another program: close that one first; on Linux ModemManager holds a new port for some seconds"
    )]
    InUse {
        /// Path of the port, as it was given.
        path: String,
    },
    /// The operating system does not let us.
    #[error("this user may not open port {path}: join the group that owns it, often dialout")]
    Forbidden {
        /// Path of the port, as it was given.
        path: String,
    },
    /// Something else than a serial port.
    #[error("{path} is not a serial port: give the port of the device, such as /dev/ttyACM0")]
    NoPort {
        /// Path of the port, as it was given.
        path: String,
    },
    /// Nobody answers at a socket, which lets one program in at a time.
    #[error(
        "nothing answers at the socket {path}, which serves one program at a time: close the other one"
    )]
    SilentSocket {
        /// Path of the port, as it was given.
        path: String,
    },
    /// Something that is not a host and a port.
    #[error(
        "\"{address}\" is not HOST:PORT with a port up to 65535: give both, as in 127.0.0.1:4250, or [::1]:4250 for IPv6"
    )]
    Address {
        /// The address as it was given.
        address: String,
    },
    /// No address of a host lets a connection be made.
    #[error("nothing can be reached at {path}: {why}; start the device, or correct the address")]
    Unreachable {
        /// Path of the line, as it was given.
        path: String,
        /// The reason for each address that was tried.
        why: String,
    },
    /// Something answers in words: a device that serves another host, or no device, such as a web server.
    #[error("{path} answers \"{answer}\"{}", remedy(answer))]
    Words {
        /// Path of the line, as it was given.
        path: String,
        /// The first line of its answer.
        answer: String,
    },
    /// The address cannot be listened at.
    #[error("cannot listen at {address}: {reason}; give another address, or port 0 for a free one")]
    Listen {
        /// The address as it was given.
        address: String,
        /// Reason in the words of the system.
        reason: String,
    },
    /// It cannot be opened for another reason, or not at this speed.
    #[error(
        "port {path} cannot be opened at {baud} baud ({reason}): use another speed, or plug the device in again"
    )]
    Open {
        /// Path of the port, as it was given.
        path: String,
        /// Speed at which it was to be opened, bits per second.
        baud: u32,
        /// Reason in the words of the system.
        reason: String,
    },
    /// The port works, but the conversation with the device failed.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// A thread could not be started.
    #[error("a thread could not be started: {reason}")]
    Thread {
        /// Reason in the words of the system.
        reason: String,
    },
}

impl SerialError {
    /// True if another attempt is useless. A wrong version, for example, does not go away by waiting.
    pub(super) const fn is_hopeless(&self) -> bool {
        matches!(
            self,
            Self::Link(
                LinkError::OtherMessages { .. } | LinkError::OtherVersion { .. } | LinkError::Echo
            )
        )
    }

    /// True if the device refused this field because it does not support it.
    #[must_use]
    pub fn is_about(&self, field: haptic_link::Field) -> bool {
        let unsupported = haptic_link::Refusal::Unsupported(field);
        matches!(self, Self::Link(LinkError::Refused { refusal, .. }) if *refusal == unsupported)
    }

    /// True if the device refused a request that was good, because of where it stands or of a fault whose cause is still there.
    #[must_use]
    pub const fn is_of_its_state(&self) -> bool {
        use haptic_link::{Refusal, State};
        matches!(
            self,
            Self::Link(LinkError::Refused {
                refusal: Refusal::ForceNotSmall { .. }
                    | Refusal::FaultPersists(_)
                    | Refusal::UnknownFault
                    | Refusal::State(State::Fault),
                ..
            })
        )
    }

    /// True if the device is there and well, but refused the request.
    #[must_use]
    pub const fn is_refusal(&self) -> bool {
        matches!(self, Self::Link(LinkError::Refused { .. }))
    }
}

/// The remedy for an answer in words; a device that only waits says so itself.
fn remedy(answer: &str) -> &'static str {
    if answer.starts_with(WAITING) {
        ""
    } else {
        ": close the other program, or correct the address"
    }
}

/// Beginning of the words of a device whose program is not ready. No frame begins so.
pub(super) const WAITING: &str = "waiting: ";

/// The ports that are there instead.
fn in_its_place(others: &str) -> String {
    if others.is_empty() {
        "nor any other: plug the device in, and look at its cable and supply".to_string()
    } else {
        std::format!("there are {others}: plug the device in, or name the port that it is at")
    }
}

/// Words of a board about its last fault, with the remedy, and where its cause lies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BoardTrouble {
    /// A sentence for a person, with the remedy.
    pub words: String,
    /// Says where to look for the cause.
    pub cause: TroubleCause,
}

impl BoardTrouble {
    /// The cause lies in the board itself.
    #[must_use]
    pub const fn of_board(words: String) -> Self {
        Self {
            words,
            cause: TroubleCause::Board,
        }
    }
}

impl fmt::Display for BoardTrouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words)
    }
}

/// Side on which a board's fault has its cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TroubleCause {
    /// Cause in the board: a fault of its own, or an answer that cannot be.
    Board,
    /// Nothing comes from it any more: unplugged, switched off, or its emulator has ended. The link is lost.
    Gone,
    /// This machine let it wait for too long.
    HostLate,
}
