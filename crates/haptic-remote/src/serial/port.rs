//! Serial ports of this machine, and what may be in their place: TCP addresses and Unix sockets.

use super::error::SerialError;
use super::line::Line;
use super::listening::BUSY;
#[cfg(unix)]
use super::socket::Socket;
use super::tcp;
use crate::LinkError;
use haptic_link::LineCounters;
use serialport::{ClearBuffer, SerialPortType};
use std::boxed::Box;
use std::format;
use std::io::ErrorKind;
#[cfg(unix)]
use std::os::unix::{fs::FileTypeExt as _, net::UnixStream};
use std::path::Path;
use std::string::{String, ToString};
use std::time::Duration;
use std::vec::Vec;

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
    /// Time for which the adapter holds bytes back, ms; `None` if it is not known.
    pub latency_ms: Option<u32>,
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
        let (description, usb) = match &port.port_type {
            SerialPortType::UsbPort(usb) => {
                let names = [usb.manufacturer.as_deref(), usb.product.as_deref()];
                let names: Vec<&str> = names.into_iter().flatten().collect();
                let names = if names.is_empty() {
                    "USB".to_string()
                } else {
                    names.join(" ")
                };
                (names, Some((usb.vid, usb.pid)))
            }
            SerialPortType::PciPort => ("PCI".to_string(), None),
            SerialPortType::BluetoothPort => ("Bluetooth".to_string(), None),
            SerialPortType::Unknown => ("built in".to_string(), None),
        };
        PortInfo {
            latency_ms: latency_ms(&port.port_name),
            path: port.port_name,
            description,
            usb,
        }
    });
    infos.collect()
}

/// Opens a port exclusively, 8N1, and discards old input; connects to a TCP address if the path is `tcp:HOST:PORT`, and to a
/// Unix socket if the path is one.
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
    let port = serialport::new(path, baud).dtr_on_open(true);
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
    opened.map_err(|error| match error.kind() {
        ErrorKind::PermissionDenied => SerialError::Forbidden { path },
        ErrorKind::ConnectionRefused => {
            let reason = "nobody listens at this socket: start its emulator anew".to_string();
            SerialError::Open { path, baud, reason }
        }
        _ => {
            let reason = error.to_string();
            SerialError::Open { path, baud, reason }
        }
    })
}

fn is_socket(path: &str) -> bool {
    #[cfg(unix)]
    return std::fs::metadata(path).is_ok_and(|file| file.file_type().is_socket());
    #[cfg(not(unix))]
    return false;
}

/// A greeting at this path that no device answered. At an address or a socket a line of text says who did. A socket that says
/// nothing lets one program in at a time, and most likely another one has it open.
pub(super) fn unanswered(path: &str, said: &[u8], error: SerialError) -> SerialError {
    let SerialError::Link(failed @ (LinkError::NoAnswer { .. } | LinkError::Gone)) = &error else {
        return error;
    };
    let is_tcp = tcp::tcp_address(path).is_some();
    if !is_tcp && !is_socket(path) {
        return error;
    }
    let text = said.split(|byte| b"\r\n".contains(byte)).next();
    let text = text.and_then(|text| std::str::from_utf8(text).ok());
    let text = text.filter(|text| text.len() >= TEXT_LEAST && !text.contains(char::is_control));
    let path = path.to_string();
    match (text, failed) {
        (Some(text), _) => {
            let answer = text.to_string();
            match text.starts_with(BUSY) {
                true => SerialError::Busy { path, answer },
                false => SerialError::Stranger { path, answer },
            }
        }
        (None, LinkError::NoAnswer { line, .. }) if !is_tcp && *line == LineCounters::default() => {
            SerialError::SilentSocket { path }
        }
        _ => error,
    }
}

/// Bytes of text in a row that no frame begins with.
const TEXT_LEAST: usize = 4;

/// Time for which a USB serial adapter holds bytes back, ms, at every tick. Asks for 1 ms where that is allowed.
pub(super) fn shorten_latency(path: &str) -> Option<u32> {
    let before = latency_ms(path)?;
    if before > 1 {
        // Needs a privilege on most systems; the caller warns when it did not help.
        let _ = std::fs::write(latency_file(path), "1");
    }
    latency_ms(path)
}

fn latency_ms(path: &str) -> Option<u32> {
    let text = std::fs::read_to_string(latency_file(path)).ok()?;
    text.trim().parse().ok()
}

/// File in which Linux keeps the latency timer of FTDI adapters.
fn latency_file(path: &str) -> String {
    let name = path.rsplit('/').next().unwrap_or(path);
    format!("/sys/bus/usb-serial/devices/{name}/latency_timer")
}
