//! The port of a device, whatever it is made of.

use super::error::EmulatorError;
#[cfg(unix)]
use super::{Socket, Terminal};
use haptic_remote::serial::{Line, TcpListening};
use std::net::SocketAddr;
use std::path::Path;

/// Where a device is to be found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place<'a> {
    /// A pseudo-terminal, with a symbolic link to it if one is asked for. Not on Windows.
    Terminal(Option<&'a Path>),
    /// A Unix socket. Not on Windows.
    Socket(&'a Path),
    /// The address `HOST:PORT`, port 0 for a free one.
    Address(&'a str),
}

/// A port that a host can open; with it goes its name.
#[derive(Debug)]
pub enum Port {
    /// A pseudo-terminal.
    #[cfg(unix)]
    Terminal(Terminal),
    /// A Unix socket.
    #[cfg(unix)]
    Socket(Socket),
    /// A TCP address.
    Address(TcpListening),
}

impl Port {
    /// Makes the port.
    ///
    /// # Errors
    /// If it cannot be made, or not on this system.
    pub fn open(place: Place<'_>) -> Result<Self, EmulatorError> {
        match place {
            #[cfg(unix)]
            Place::Terminal(link) => Terminal::open(link).map(Self::Terminal),
            #[cfg(unix)]
            Place::Socket(path) => Socket::open(path).map(Self::Socket),
            #[cfg(not(unix))]
            Place::Terminal(_) | Place::Socket(_) => Err(EmulatorError::Terminal(
                "this system has neither pseudo-terminals nor Unix sockets: listen at an address"
                    .to_owned(),
            )),
            Place::Address(address) => Ok(Self::Address(TcpListening::open(address)?)),
        }
    }

    /// Path that a host [opens](haptic_remote::serial::open).
    #[must_use]
    pub fn path(&self) -> String {
        match self {
            #[cfg(unix)]
            Self::Terminal(terminal) => terminal.path().display().to_string(),
            #[cfg(unix)]
            Self::Socket(socket) => socket.path().display().to_string(),
            Self::Address(listening) => listening.path(),
        }
    }

    /// The address, where other machines may reach it.
    #[must_use]
    pub fn public_address(&self) -> Option<SocketAddr> {
        match self {
            #[cfg(unix)]
            Self::Terminal(_) | Self::Socket(_) => None,
            Self::Address(listening) => {
                Some(listening.address()).filter(|address| !address.ip().is_loopback())
            }
        }
    }

    /// Our end, for the device.
    ///
    /// # Errors
    /// It cannot be shared.
    pub fn line(&self) -> Result<Box<dyn Line>, EmulatorError> {
        match self {
            #[cfg(unix)]
            Self::Terminal(terminal) => terminal.line(),
            #[cfg(unix)]
            Self::Socket(socket) => socket.line(),
            Self::Address(listening) => Ok(listening.line()),
        }
    }
}
