//! A way for bytes, there and back.

use serialport::SerialPort;
use std::boxed::Box;
use std::io::{self, Read, Write};
use std::time::Duration;

/// A way for bytes, there and back: a serial port, a Unix socket, or a [`Pipe`](super::Pipe) of this process.
///
/// A read gives what is there; without anything it waits for a while and fails with
/// [`TimedOut`](io::ErrorKind::TimedOut). `Ok(0)` is the end of the line.
pub trait Line: Read + Write + Send {
    /// A second handle on the same end.
    ///
    /// # Errors
    /// In the words of the system.
    fn share(&self) -> io::Result<Box<dyn Line>>;

    /// Sets the speed, bits per second, on a line that has one.
    fn set_baud_rate(&mut self, baud: u32);

    /// Sets the time that a read waits; zero takes what is there.
    ///
    /// # Errors
    /// In the words of the system.
    fn set_patience(&mut self, patience: Duration) -> io::Result<()>;
}

impl Line for Box<dyn SerialPort> {
    fn share(&self) -> io::Result<Box<dyn Line>> {
        Ok(Box::new(self.try_clone()?))
    }

    fn set_baud_rate(&mut self, baud: u32) {
        // A port without speeds, as a pseudo-terminal may be, has the only one.
        let _ = self.as_mut().set_baud_rate(baud);
    }

    fn set_patience(&mut self, patience: Duration) -> io::Result<()> {
        Ok(self.set_timeout(patience)?)
    }
}

impl Line for Box<dyn Line> {
    fn share(&self) -> io::Result<Box<dyn Line>> {
        self.as_ref().share()
    }

    fn set_baud_rate(&mut self, baud: u32) {
        self.as_mut().set_baud_rate(baud);
    }

    fn set_patience(&mut self, patience: Duration) -> io::Result<()> {
        self.as_mut().set_patience(patience)
    }
}
