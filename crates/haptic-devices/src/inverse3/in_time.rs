//! A stream whose other end has limited time, however slowly it sends.

use std::{
    fmt,
    io::{ErrorKind, Read, Result, Write},
    time::Duration,
};

/// Time for all messages before the first tick, HTTP and WebSocket together. A service on this machine needs milliseconds.
pub(super) const PATIENCE: Duration = Duration::from_secs(2);

/// Reads of a tick: many more than its messages need.
const READS_MOST: u32 = 64;

/// A stream that fails once its time is over, even if a byte still comes now and then: a limit on each read would not limit a
/// sentence.
pub struct InTime<S> {
    stream: S,
    /// Says that the time is over; `None` once it does not matter any more.
    is_late: Option<Box<dyn Fn() -> bool + Send>>,
    /// Reads that are left in this tick: a message without end would hold it up.
    reads: u32,
}

impl<S> InTime<S> {
    /// A stream whose reads may wait for a while, and are asked again until `is_late` says so.
    pub fn new(stream: S, is_late: impl Fn() -> bool + Send + 'static) -> Self {
        Self {
            stream,
            is_late: Some(Box::new(is_late)),
            reads: 0,
        }
    }

    /// Makes it the stream alone from now on, with whatever its reads say.
    pub(super) fn no_longer_limited(&mut self) {
        self.is_late = None;
    }

    /// Begins a tick, in which all of its reads are left.
    pub(super) const fn tick(&mut self) {
        self.reads = READS_MOST;
    }

    pub(super) const fn stream(&self) -> &S {
        &self.stream
    }

    fn in_time(&self) -> Result<()> {
        match &self.is_late {
            Some(is_late) if is_late() => Err(ErrorKind::TimedOut.into()),
            Some(_) | None => Ok(()),
        }
    }
}

impl<S: Read> Read for InTime<S> {
    fn read(&mut self, into: &mut [u8]) -> Result<usize> {
        if self.is_late.is_none() {
            let left = self.reads.checked_sub(1);
            self.reads = left.ok_or(ErrorKind::WouldBlock)?;
        }
        loop {
            self.in_time()?;
            match self.stream.read(into) {
                // By the system, a read that waited for nothing is the one or the other.
                Err(error)
                    if self.is_late.is_some()
                        && matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                read => return read,
            }
        }
    }
}

impl<S: Write> Write for InTime<S> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.in_time()?;
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> Result<()> {
        self.stream.flush()
    }
}

impl<S: fmt::Debug> fmt::Debug for InTime<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.stream.fmt(f)
    }
}
