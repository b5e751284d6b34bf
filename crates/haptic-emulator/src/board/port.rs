//! The port of a device, whatever it is made of.

#[cfg(unix)]
use super::Terminal;
use super::error::EmulatorError;
use haptic_remote::serial::{Line, TcpListening};
use std::{net::SocketAddr, path::Path};

/// Kinds of ports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortKind {
    /// A pseudo-terminal, with a symbolic link to it if it is to have a name. Not on Windows.
    Terminal,
    /// A TCP address `HOST:PORT`; port 0 takes a free one.
    Address,
    /// A TCP address, too, of a device of another maker, whose protocol knows no greeting.
    ForeignAddress,
}

/// A port that a host can open. Its name goes with it.
#[derive(Debug)]
pub enum BoardPort {
    /// Pseudo-terminal, see [`PortKind::Terminal`].
    #[cfg(unix)]
    Terminal(Terminal),
    /// TCP address, see [`PortKind::Address`].
    Address(TcpListening),
}

impl BoardPort {
    /// The address of a port without a name.
    const ADDRESS: &'static str = "127.0.0.1:4250";

    /// Makes a port with this name.
    ///
    /// # Errors
    /// If it cannot be made, or not on this system.
    pub fn open(kind: PortKind, name: Option<&Path>) -> Result<Self, EmulatorError> {
        match kind {
            #[cfg(unix)]
            PortKind::Terminal => Terminal::open(name).map(Self::Terminal),
            #[cfg(not(unix))]
            PortKind::Terminal => Err(EmulatorError::Terminal(
                "this system has no pseudo-terminals: listen at an address".to_owned(),
            )),
            PortKind::Address | PortKind::ForeignAddress => {
                let name = name.map_or(Self::ADDRESS.into(), Path::to_string_lossy);
                Ok(Self::Address(if kind == PortKind::Address {
                    TcpListening::open(&name)?
                } else {
                    TcpListening::for_any_protocol(&name)?
                }))
            }
        }
    }

    /// Path by which a host [opens](haptic_remote::serial::open) it.
    #[must_use]
    pub fn path(&self) -> String {
        match self {
            #[cfg(unix)]
            Self::Terminal(terminal) => terminal.path().display().to_string(),
            Self::Address(listening) => listening.path(),
        }
    }

    /// The address, if other machines may reach it.
    #[must_use]
    pub fn public_address(&self) -> Option<SocketAddr> {
        match self {
            #[cfg(unix)]
            Self::Terminal(_) => None,
            Self::Address(listening) => {
                Some(listening.address()).filter(|address| !address.ip().is_loopback())
            }
        }
    }

    /// The end of the device, which serves one host after the other.
    ///
    /// # Errors
    /// A port that cannot be shared.
    pub fn line(&self) -> Result<Box<dyn Line>, EmulatorError> {
        match self {
            #[cfg(unix)]
            Self::Terminal(terminal) => terminal.line(),
            Self::Address(listening) => Ok(listening.line()),
        }
    }
}
