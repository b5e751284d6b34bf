//! A Unix socket as a line: a device that another process emulates, QEMU's or our own.

use super::error::SerialError;
use super::line::Line;
use std::boxed::Box;
use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::fs::FileTypeExt as _;
use std::os::unix::net::UnixStream;
use std::string::ToString as _;
use std::time::Duration;

#[derive(Debug)]
pub(super) struct Socket(UnixStream);

impl Socket {
    /// Opens the socket at this path; `None` if something else is there.
    pub(super) fn open(
        path: &str,
        baud: u32,
        patience: Duration,
    ) -> Option<Result<Self, SerialError>> {
        if !is_socket(path) {
            return None;
        }
        let opened = UnixStream::connect(path).and_then(|stream| {
            stream.set_write_timeout(Some(patience))?;
            let mut socket = Self(stream);
            socket.set_patience(patience)?;
            Ok(socket)
        });
        let path = path.to_string();
        Some(opened.map_err(|error| {
            if error.kind() == ErrorKind::PermissionDenied {
                return SerialError::Forbidden { path };
            }
            let reason = if error.kind() == ErrorKind::ConnectionRefused {
                "nobody listens at this socket: start its emulator anew".to_string()
            } else {
                error.to_string()
            };
            SerialError::Open { path, baud, reason }
        }))
    }
}

pub(super) fn is_socket(path: &str) -> bool {
    std::fs::metadata(path).is_ok_and(|file| file.file_type().is_socket())
}

/// A time that has passed is the same on every line.
#[must_use]
pub fn timed_out(error: io::Error) -> io::Error {
    if error.kind() == ErrorKind::WouldBlock {
        ErrorKind::TimedOut.into()
    } else {
        error
    }
}

/// Sets the time that reads of a socket wait.
///
/// # Errors
/// In the words of the system.
pub fn set_patience(stream: &UnixStream, patience: Duration) -> io::Result<()> {
    stream.set_nonblocking(patience.is_zero())?;
    if patience.is_zero() {
        return Ok(());
    }
    stream.set_read_timeout(Some(patience))
}

impl Read for Socket {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        self.0.read(into).map_err(timed_out)
    }
}

impl Write for Socket {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes).map_err(timed_out)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Line for Socket {
    fn share(&self) -> io::Result<Box<dyn Line>> {
        Ok(Box::new(Self(self.0.try_clone()?)))
    }

    fn set_baud_rate(&mut self, _: u32) {}

    fn set_patience(&mut self, patience: Duration) -> io::Result<()> {
        set_patience(&self.0, patience)
    }
}
