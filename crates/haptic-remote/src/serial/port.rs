//! Serial ports of this machine, and what may be in their place: TCP addresses and Unix sockets.

#[cfg(unix)]
use super::socket::Socket;
use super::{error::SerialError, line::Line, tcp};
use crate::LinkError;
use haptic_link::LineCounters;
use serialport::{ClearBuffer, SerialPortType};
#[cfg(unix)]
use std::os::unix::{fs::FileTypeExt as _, net::UnixStream};
use std::{
    boxed::Box,
    format,
    io::ErrorKind,
    path::Path,
    string::{String, ToString},
    time::Duration,
    vec::Vec,
};

/// A read returns after this time at the latest, so that a closing link is noticed.
const READ_TIMEOUT: Duration = Duration::from_millis(20);

/// A serial port of this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortInfo {
    /// Path or name to open it by.
    pub path: String,
    /// Description of the adapter, for a person.
    pub description: String,
    /// USB vendor and product number.
    pub usb: Option<(u16, u16)>,
    /// Serial number of the USB device.
    pub serial_number: Option<String>,
    /// Time for which the adapter holds bytes back, ms; `None` if it is not known.
    pub latency_ms: Option<u32>,
}

/// USB numbers of the boards that this project's firmware is made for: the Pico's own, then each ST-Link that is a serial port too.
const BOARDS: [(u16, u16); 8] = [
    (0x1209, 0x0001),
    (0x0483, 0x374b),
    (0x0483, 0x374e),
    (0x0483, 0x374f),
    (0x0483, 0x3752),
    (0x0483, 0x3753),
    (0x0483, 0x3754),
    (0x0483, 0x3757),
];

impl PortInfo {
    /// True of a port whose USB number is that of such a board. Who opens another may reset an Arduino, or speak to a modem.
    #[must_use]
    pub fn is_of_a_board(&self) -> bool {
        self.usb.is_some_and(|number| BOARDS.contains(&number))
    }
}

/// All serial ports of this machine, by their names. Pseudo-terminals, as of an emulated device, are not among them.
#[must_use]
pub fn ports() -> Vec<PortInfo> {
    // Without libudev the crate looks there, and panics where a container has no such place.
    if cfg!(target_os = "linux") && !Path::new("/sys/class/tty").exists() {
        return Vec::new();
    }
    let mut found = serialport::available_ports().unwrap_or_default();
    found.sort_by(|one, next| one.port_name.cmp(&next.port_name));
    let infos = found.into_iter().map(|port| {
        let (mut usb, mut serial_number) = (None, None);
        let description = match port.port_type {
            SerialPortType::UsbPort(device) => {
                usb = Some((device.vid, device.pid));
                serial_number = device.serial_number;
                let names = [device.manufacturer.as_deref(), device.product.as_deref()];
                let names: Vec<&str> = names.into_iter().flatten().collect();
                if names.is_empty() {
                    "USB".to_string()
                } else {
                    names.join(" ")
                }
            }
            SerialPortType::PciPort => "PCI".to_string(),
            SerialPortType::BluetoothPort => "Bluetooth".to_string(),
            SerialPortType::Unknown => "built in".to_string(),
        };
        PortInfo {
            latency_ms: latency_ms(&port.port_name),
            path: port.port_name,
            description,
            usb,
            serial_number,
        }
    });
    infos.collect()
}

/// The port that a path leads to: that with the serial number of `usb:NUMBER`, or what is behind a link such as those of
/// `/dev/serial/by-id`.
///
/// # Errors
/// No USB port, or several, with this number.
pub fn port_of(path: &str) -> Result<String, SerialError> {
    if let Some(number) = path.strip_prefix(USB) {
        return with_number(number, &ports());
    }
    let real = std::fs::canonicalize(path).ok();
    let real = real.and_then(|real| real.to_str().map(ToString::to_string));
    // A name of Windows leads to nothing, and is the port itself.
    Ok(real.unwrap_or_else(|| path.to_string()))
}

/// Prefix of a serial number in a path.
const USB: &str = "usb:";

fn with_number(number: &str, ports: &[PortInfo]) -> Result<String, SerialError> {
    let numbered = |port: &&PortInfo| port.serial_number.as_deref() == Some(number);
    let found: Vec<&PortInfo> = ports.iter().filter(numbered).collect();
    if let [port] = found[..] {
        return Ok(port.path.clone());
    }
    let others = ports.iter().map(|port| match &port.serial_number {
        Some(number) => format!("{} ({USB}{number})", port.path),
        None => port.path.clone(),
    });
    let others = others.collect::<Vec<_>>().join(", ");
    let only = if found.is_empty() { "" } else { " alone" };
    let path = format!("{USB}{number}{only}");
    Err(SerialError::NotFound { path, others })
}

/// Opens a port exclusively, 8N1, and discards old input; connects to a TCP address if the path is `tcp:HOST:PORT`, and to a
/// Unix socket if the path is one. The path of a port may be `usb:` and the serial number of its USB device.
///
/// # Errors
/// The port does not exist, is in use, or may not be opened; nothing listens at the address or socket.
pub fn open(path: &str, baud: u32) -> Result<Box<dyn Line>, SerialError> {
    if let Some(address) = tcp::tcp_address(path) {
        return Ok(Box::new(tcp::connect(path, address, READ_TIMEOUT)?));
    }
    #[cfg(unix)]
    if is_socket(path) {
        return Ok(Box::new(open_socket(path, baud)?));
    }
    // Some boards stay silent until DTR is set, which Linux does by itself and Windows does not.
    let port = serialport::new(port_of(path)?, baud).dtr_on_open(true);
    let opened = port.timeout(READ_TIMEOUT).open();
    let port = opened.map_err(|error| {
        use serialport::ErrorKind::{Io, NoDevice};
        let (kind, reason) = (error.kind(), error.to_string());
        let path = path.to_string();
        if reason.contains("exclusive lock") || reason.contains("busy") {
            SerialError::InUse { path }
        } else if reason.contains("Not a typewriter") || reason.contains("Inappropriate ioctl") {
            // Message of the system for a file that has no baud rate.
            SerialError::NoPort { path }
        } else if kind == Io(ErrorKind::PermissionDenied) {
            SerialError::Forbidden { path }
        } else if matches!(kind, NoDevice | Io(ErrorKind::NotFound)) && !Path::new(&path).exists() {
            let others: Vec<String> = ports().into_iter().map(|port| port.path).collect();
            SerialError::NotFound {
                path,
                others: others.join(", "),
            }
        } else {
            SerialError::Open { path, baud, reason }
        }
    })?;
    // Best effort: a line that cannot be cleared is cleaned by the first hello.
    let _ = port.clear(ClearBuffer::All);
    Ok(Box::new(port))
}

#[cfg(unix)]
fn open_socket(path: &str, baud: u32) -> Result<Socket<UnixStream>, SerialError> {
    let opened = UnixStream::connect(path).and_then(|stream| Socket::new(stream, READ_TIMEOUT));
    let path = path.to_string();
    opened.map_err(|error| {
        if error.kind() == ErrorKind::PermissionDenied {
            return SerialError::Forbidden { path };
        }
        let reason = if error.kind() == ErrorKind::ConnectionRefused {
            "nobody listens at this socket: start its emulator anew".to_string()
        } else {
            error.to_string()
        };
        SerialError::Open { path, baud, reason }
    })
}

/// True of a path at which a Unix socket is.
#[cfg(unix)]
#[must_use]
pub fn is_socket(path: &str) -> bool {
    std::fs::metadata(path).is_ok_and(|file| file.file_type().is_socket())
}

/// False where there are no Unix sockets.
#[cfg(not(unix))]
#[must_use]
pub const fn is_socket(_: &str) -> bool {
    false
}

/// A greeting at this path that no device answered. At an address or a socket a line of text says who did. A socket that says
/// nothing lets one program in at a time, and most likely another one has it open.
pub(super) fn unanswered(path: &str, received: &[u8], error: SerialError) -> SerialError {
    let is_tcp = tcp::tcp_address(path).is_some();
    let SerialError::Link(failed @ (LinkError::NoAnswer { .. } | LinkError::Gone)) = &error else {
        return error;
    };
    let path = path.to_string();
    let text = received.split(|byte| b"\r\n".contains(byte)).next();
    let text = text.and_then(|text| std::str::from_utf8(text).ok());
    let text = text.filter(|text| text.len() >= TEXT_LEAST && !text.contains(char::is_control));
    let nothing = LineCounters::default();
    if !is_tcp && !is_socket(&path) {
        error
    } else if let Some(text) = text {
        let answer = text.to_string();
        SerialError::Words { path, answer }
    } else if !is_tcp && matches!(failed, LinkError::NoAnswer { line, .. } if *line == nothing) {
        SerialError::SilentSocket { path }
    } else {
        error
    }
}

/// Bytes of text in a row that no frame begins with.
const TEXT_LEAST: usize = 4;

/// Time for which a USB serial adapter holds bytes back, ms, at every tick. Asks for 1 ms where that is allowed.
pub(super) fn shorten_latency(path: &str) -> Option<u32> {
    let before = latency_ms(path)?;
    if before > 1 {
        // Needs a privilege on most systems; the caller warns when it did not help.
        let _ = std::fs::write(latency_file(path)?, "1");
    }
    latency_ms(path)
}

fn latency_ms(path: &str) -> Option<u32> {
    let text = std::fs::read_to_string(latency_file(path)?).ok()?;
    text.trim().parse().ok()
}

/// File in which Linux keeps the latency timer of FTDI adapters. `None` for a path that leads to no port.
#[must_use]
pub fn latency_file(path: &str) -> Option<String> {
    let port = port_of(path).ok()?;
    let name = port.rsplit('/').next()?;
    Some(format!("/sys/bus/usb-serial/devices/{name}/latency_timer"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use testkit::Tested;

    fn port(path: &str, serial_number: Option<&str>) -> PortInfo {
        PortInfo {
            path: path.to_string(),
            description: "USB".to_string(),
            usb: Some((0x0403, 0x6001)),
            serial_number: serial_number.map(ToString::to_string),
            latency_ms: None,
        }
    }

    #[test]
    fn a_port_is_found_by_its_serial_number() {
        let ports = [
            port("/dev/ttyUSB0", Some("A1")),
            port("/dev/ttyUSB1", Some("B2")),
            port("/dev/ttyUSB2", Some("B2")),
            port("/dev/ttyS0", None),
        ];
        assert_eq!(with_number("A1", &ports), Ok("/dev/ttyUSB0".to_string()));
        let refusal = |number| with_number(number, &ports).expect_err("none").to_string();
        let others = "there are /dev/ttyUSB0 (usb:A1), /dev/ttyUSB1 (usb:B2), /dev/ttyUSB2 (usb:B2), /dev/ttyS0: plug";
        for (number, none) in [("a1", "usb:a1"), ("B2", "usb:B2 alone")] {
            let error = refusal(number);
            let start = format!("there is no port {none}, {others}");
            assert!(error.starts_with(&start), "{error}");
        }
        assert!(refusal("").starts_with("there is no port usb:,"));
    }

    #[cfg(unix)]
    #[test]
    fn the_latency_timer_is_looked_up_behind_links() -> Tested {
        let folder = std::env::temp_dir().join(format!("by-id-{}", std::process::id()));
        std::fs::create_dir_all(&folder)?;
        std::fs::write(folder.join("ttyUSB7"), "")?;
        for (to, link) in [("ttyUSB7", "usb-FTDI-if00"), ("usb-FTDI-if00", "haptics")] {
            std::os::unix::fs::symlink(to, folder.join(link))?;
            let path = folder.join(link);
            let file = latency_file(path.to_str().expect("text"));
            let expected = "/sys/bus/usb-serial/devices/ttyUSB7/latency_timer";
            assert_eq!(file.as_deref(), Some(expected), "{link}");
        }
        std::fs::remove_dir_all(&folder)?;
        Ok(())
    }
}
