//! A socket as a line: TCP, or a Unix socket at which another process emulates a device, QEMU or our own.

use super::line::Line;
use core::fmt;
use socket2::SockRef;
use std::boxed::Box;
use std::io::{self, ErrorKind, Read, Write};
use std::sync::Arc;
use std::time::Duration;

/// A connected socket of the standard library, whose writes raise no signal in a program that does not ignore SIGPIPE.
pub(super) trait Stream: fmt::Debug + Send + Sync + 'static {
    fn receive(&self, into: &mut [u8]) -> io::Result<usize>;
    fn send(&self, bytes: &[u8]) -> io::Result<usize>;
    fn options(&self) -> SockRef<'_>;
}

impl<S: fmt::Debug + Send + Sync + 'static> Stream for S
where
    for<'a> &'a S: Read + Write,
    for<'a> SockRef<'a>: From<&'a S>,
{
    fn receive(&self, into: &mut [u8]) -> io::Result<usize> {
        let mut stream = self;
        stream.read(into).map_err(timed_out)
    }

    fn send(&self, bytes: &[u8]) -> io::Result<usize> {
        let mut stream = self;
        stream.write(bytes).map_err(timed_out)
    }

    fn options(&self) -> SockRef<'_> {
        self.into()
    }
}

/// A time that has passed is the same on every line and every system.
fn timed_out(error: io::Error) -> io::Error {
    match error.kind() == ErrorKind::WouldBlock {
        true => ErrorKind::TimedOut.into(),
        false => error,
    }
}

/// Sets the time that reads wait.
pub(super) fn set_patience(stream: &impl Stream, patience: Duration) -> io::Result<()> {
    let options = stream.options();
    options.set_nonblocking(patience.is_zero())?;
    if patience.is_zero() {
        return Ok(());
    }
    options.set_read_timeout(Some(patience))
}

/// The end of a host.
#[derive(Debug)]
pub(super) struct Socket<S>(Arc<S>);

impl<S: Stream> Socket<S> {
    pub(super) fn new(stream: S, patience: Duration) -> io::Result<Self> {
        stream.options().set_write_timeout(Some(patience))?;
        set_patience(&stream, patience)?;
        Ok(Self(Arc::new(stream)))
    }
}

impl<S: Stream> Read for Socket<S> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        self.0.receive(into)
    }
}

impl<S: Stream> Write for Socket<S> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.send(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl<S: Stream> Line for Socket<S> {
    fn share(&self) -> io::Result<Box<dyn Line>> {
        Ok(Box::new(Self(Arc::clone(&self.0))))
    }

    fn set_baud_rate(&mut self, _: u32) {}

    fn set_patience(&mut self, patience: Duration) -> io::Result<()> {
        set_patience(self.0.as_ref(), patience)
    }
}
