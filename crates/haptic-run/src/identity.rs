//! Identity of a connected device: its limits, its calibration and its campaigns belong to it, not to a port.
//!
//! | known by | is |
//! |---|---|
//! | number | the serial number in its greeting, else that of its USB port, if no other port has the same |
//! | link | the name that leads to a simulated device, or to a program behind a pseudo-terminal or a socket |
//! | nothing | it may be any device of its name |
//!
//! The number of a pseudo-terminal is no name: the kernel gives it away again. A simulated device that is reached by it alone is another
//! one each time.

use haptic_link::SerialNumber;
use haptic_remote::serial::{PortInfo, is_socket, port_of, tcp_address};
use std::{fmt, path::absolute};

/// Identity of a connected device; it displays as a text that is the same whenever the device is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceIdentity {
    pub(super) board: String,
    pub(super) known: Known,
}

/// The part of an identity that tells devices of a name apart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Known {
    /// Serial number.
    Number(String),
    /// Name of the link that leads there.
    Link(String),
    /// A real device without a number: it may be any of its name.
    ByName,
    /// A simulated device without a name: nobody meets it again.
    Not,
}

/// The facts about a device that is connected.
#[derive(Clone, Copy, Debug)]
pub(super) struct Told<'a> {
    pub board: &'a str,
    /// Serial number in its greeting, which may state none.
    pub number: SerialNumber,
    pub simulated: bool,
    /// The path by which it was opened.
    pub path: &'a str,
    /// Others share its port, whose number is not its own.
    pub shares_port: bool,
}

impl DeviceIdentity {
    pub(super) fn of(told: Told<'_>, ports: &[PortInfo]) -> Self {
        let known = told
            .number
            .text()
            .map(|number| Known::Number(number.to_owned()));
        Self {
            board: told.board.to_owned(),
            known: known.unwrap_or_else(|| told.known_by_port(ports)),
        }
    }

    /// The serial number of the device or its USB port.
    #[must_use]
    pub fn serial_number(&self) -> Option<&str> {
        match &self.known {
            Known::Number(number) => Some(number),
            Known::Link(_) | Known::ByName | Known::Not => None,
        }
    }
}

impl fmt::Display for DeviceIdentity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let board = &self.board;
        match &self.known {
            Known::Number(number) => write!(f, "{board} {number}"),
            Known::Link(link) => write!(f, "{board} at {link}"),
            Known::ByName => write!(f, "{board} without a serial number"),
            Known::Not => write!(f, "{board} without a name"),
        }
    }
}

impl Told<'_> {
    fn known_by_port(self, ports: &[PortInfo]) -> Known {
        if tcp_address(self.path).is_some() {
            return if self.simulated {
                Known::Link(self.path.to_owned())
            } else {
                Known::ByName
            };
        }
        let port = port_of(self.path).unwrap_or_else(|_| self.path.to_owned());
        let at = |info: &&PortInfo| info.path.eq_ignore_ascii_case(&port);
        let number = ports.iter().find(at).filter(|_| !self.shares_port);
        let number = number.and_then(|info| info.serial_number.as_deref());
        let has_it = |info: &&PortInfo| info.serial_number.as_deref() == number;
        if let Some(number) = number
            && SerialNumber::named(number).is_some()
            && ports.iter().filter(has_it).count() == 1
        {
            return Known::Number(number.to_owned());
        }
        let link = absolute(self.path).ok();
        let link = link.and_then(|link| link.to_str().map(ToOwned::to_owned));
        let link = link.filter(|link| *link != port || is_socket(link));
        match (is_of_a_program(&port), link) {
            (true, Some(link)) => Known::Link(link),
            (true, None) if self.simulated => Known::Not,
            (false, _) if self.simulated => Known::Link(port),
            _ => Known::ByName,
        }
    }
}

/// True of a pseudo-terminal on Linux or macOS, and of a socket.
fn is_of_a_program(port: &str) -> bool {
    let mac = port.strip_prefix("/dev/ttys");
    let mac = mac.is_some_and(|number| number.bytes().all(|byte| byte.is_ascii_digit()));
    mac || port.starts_with("/dev/pts/") || is_socket(port)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(crate) fn port(path: &str, serial_number: &str) -> PortInfo {
        PortInfo {
            path: path.to_owned(),
            description: String::new(),
            usb: None,
            serial_number: Some(serial_number.to_owned()),
            latency_ms: None,
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_known_by_its_number_else_by_that_of_its_port_else_by_a_name_that_stays() {
        let folder = tempfile::tempdir().expect("a folder");
        let (socket, link) = (folder.path().join("socket"), folder.path().join("device"));
        let _listener = std::os::unix::net::UnixListener::bind(&socket).expect("a socket");
        std::os::unix::fs::symlink(&socket, &link).expect("a link");
        let link = link.to_str().expect("text");
        let at_link = format!("board at {link}");
        let ports = [
            port("/dev/ttyUSB0", "A50285BI"),
            port("/dev/ttyUSB1", "0001"),
            port("/dev/ttyUSB2", "B60396"),
            port("/dev/ttyUSB3", "B60396"),
        ];
        let nameless = "board without a serial number";
        for (number, simulated, path, shares_port, text) in [
            (Some("E66124"), false, "/dev/ttyUSB0", false, "board E66124"),
            (Some("E66124"), true, "/dev/pts/7", false, "board E66124"),
            (None, false, "/dev/ttyUSB0", false, "board A50285BI"),
            (None, false, "/dev/ttyUSB0", true, nameless),
            // From the factory, and at two ports.
            (None, false, "/dev/ttyUSB1", false, nameless),
            (None, false, "/dev/ttyUSB2", false, nameless),
            (None, false, "/dev/ttyACM0", false, nameless),
            (None, true, "/dev/ttyACM0", false, "board at /dev/ttyACM0"),
            (None, false, "tcp:board.local:4250", false, nameless),
            (
                None,
                true,
                "tcp:[::1]:4250",
                false,
                "board at tcp:[::1]:4250",
            ),
            (None, false, "/dev/pts/7", false, nameless),
            (None, true, "/dev/pts/7", false, "board without a name"),
            (None, true, link, false, &*at_link),
            (None, false, link, false, &*at_link),
        ] {
            let number = number.map_or(SerialNumber::NONE, |number| {
                SerialNumber::named(number).expect("a number")
            });
            let told = Told {
                board: "board",
                number,
                simulated,
                path,
                shares_port,
            };
            let identity = DeviceIdentity::of(told, &ports);
            assert_eq!(identity.to_string(), text, "{told:?}");
        }
    }
}
