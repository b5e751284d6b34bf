//! Ways for bytes: serial ports, and a pipe within this process.

use haptic_loop::realtime::Moment;
use serialport::SerialPort;
use std::{
    boxed::Box,
    collections::VecDeque,
    io::{self, ErrorKind, Read, Write},
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    time::Duration,
};

/// A two-way connection for bytes: a serial port, a Unix socket, or a [`Pipe`](super::Pipe) of this
/// process.
///
/// A read returns what has arrived, or fails with [`TimedOut`](io::ErrorKind::TimedOut) after a
/// while; `Ok(0)` is the line's end.
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

    /// The clock by which its waits count; a line in virtual time has its own.
    fn now(&self) -> Moment {
        Moment::now()
    }
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

    fn now(&self) -> Moment {
        self.as_ref().now()
    }
}

/// Most bytes on their way: more mean that the other end does not read.
const ON_THE_WAY_MOST: usize = 1 << 18;
/// Time that a read waits unless another is set, as that of a serial port.
const PATIENCE: Duration = Duration::from_millis(20);

/// One end of a line within this process.
#[derive(Clone, Debug)]
pub struct Pipe {
    incoming: Arc<Queue>,
    outgoing: Arc<Queue>,
    /// End that its handles share: with the last of them the end is gone.
    _end: Arc<End>,
    patience: Duration,
}

#[derive(Debug, Default)]
struct Queue {
    state: Mutex<Queued>,
    arrived: Condvar,
}

#[derive(Debug, Default)]
struct Queued {
    bytes: VecDeque<u8>,
    closed: bool,
}

#[derive(Debug)]
struct End([Arc<Queue>; 2]);

impl Drop for End {
    fn drop(&mut self) {
        for queue in &self.0 {
            lock(&queue.state).closed = true;
            queue.arrived.notify_all();
        }
    }
}

impl Pipe {
    /// Both ends of a new line.
    #[must_use]
    pub fn pair() -> (Self, Self) {
        let queues = [(); 2].map(|()| Arc::new(Queue::default()));
        let end = |incoming: usize| Self {
            incoming: Arc::clone(&queues[incoming]),
            outgoing: Arc::clone(&queues[1 - incoming]),
            _end: Arc::new(End(queues.clone())),
            patience: PATIENCE,
        };
        (end(0), end(1))
    }
}

impl Read for Pipe {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let queued = lock(&self.incoming.state);
        let nothing = |queued: &mut Queued| queued.bytes.is_empty() && !queued.closed;
        let waited = (self.incoming.arrived).wait_timeout_while(queued, self.patience, nothing);
        let (mut queued, _) = waited.unwrap_or_else(PoisonError::into_inner);
        if queued.bytes.is_empty() && !queued.closed {
            return Err(ErrorKind::TimedOut.into());
        }
        queued.bytes.read(into)
    }
}

impl Write for Pipe {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut queued = lock(&self.outgoing.state);
        if queued.closed {
            return Err(ErrorKind::BrokenPipe.into());
        }
        let count = bytes.len().min(ON_THE_WAY_MOST - queued.bytes.len());
        if count < bytes.len() {
            return Err(ErrorKind::WouldBlock.into());
        }
        queued.bytes.extend(bytes);
        drop(queued);
        self.outgoing.arrived.notify_one();
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Line for Pipe {
    fn share(&self) -> io::Result<Box<dyn Line>> {
        Ok(Box::new(self.clone()))
    }

    fn set_baud_rate(&mut self, _: u32) {}

    fn set_patience(&mut self, patience: Duration) -> io::Result<()> {
        self.patience = patience;
        Ok(())
    }
}

/// Whoever panicked with it has been seen; what is inside are counters.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
