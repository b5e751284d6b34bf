//! A socket as a line: TCP, or a Unix socket at which another process emulates a device, such as QEMU.

use super::line::Line;
use core::fmt;
use socket2::{SockRef, TcpKeepalive};
use std::{
    boxed::Box,
    io::{self, ErrorKind, Read, Write},
    net::TcpStream,
    sync::Arc,
    time::Duration,
};

/// Silence after which the system asks whether the other end is still there, and the time between its questions.
const KEEP_ALIVE: [Duration; 2] = [Duration::from_secs(3), Duration::from_secs(1)];

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
    if error.kind() == ErrorKind::WouldBlock {
        ErrorKind::TimedOut.into()
    } else {
        error
    }
}

/// Sets the time that reads wait, on both handles of a socket.
pub(super) fn set_patience(stream: &impl Stream, patience: Duration) -> io::Result<()> {
    let options = stream.options();
    options.set_nonblocking(patience.is_zero())?;
    if patience.is_zero() {
        return Ok(());
    }
    options.set_read_timeout(Some(patience))
}

/// Small frames go at once, and an end that has vanished is noticed in seconds even where nothing is said.
pub(super) fn prompt(stream: TcpStream) -> io::Result<TcpStream> {
    let [time, interval] = KEEP_ALIVE;
    let keep_alive = TcpKeepalive::new().with_time(time).with_interval(interval);
    SockRef::from(&stream).set_tcp_keepalive(&keep_alive)?;
    stream.set_nodelay(true)?;
    Ok(stream)
}

/// A line whose other end is somewhere else: what a host has.
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
