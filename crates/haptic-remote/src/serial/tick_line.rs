//! A line that a tick can use: two rings without locks, and two threads that carry their bytes.
//!
//! ```text
//! line ─▶ reader thread ─▶ ring ─▶ take        give ─▶ ring ─▶ writer thread ─▶ line
//! ```
//! *Cost* of `take` and `give`: a copy of the bytes, no call of the system. What finds no room is lost, as on a line that is too slow,
//! and counted. The writer looks for frames every 250 µs, as waking it would be a call of the system in the tick.

use super::error::SerialError;
use super::line::Line;
use super::listening::NOBODY;
use haptic_loop::realtime::Moment;
use rtrb::{Consumer, Producer, RingBuffer};
use std::boxed::Box;
use std::io::ErrorKind;
use std::string::ToString as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;
use std::vec::Vec;

/// Bytes that wait in each ring at most: half a second of samples at 1 kHz.
const ROOM: usize = 1 << 16;
/// Time between two looks of the writer at its ring.
const POLL: Duration = Duration::from_micros(250);
/// Without a host for so long, the writer looks less often.
const LATELY: Duration = Duration::from_secs(1);

/// A line whose ends can be used in a tick. Dropping it ends both threads, within 20 ms.
#[derive(Debug)]
pub struct TickLine {
    arrived: Consumer<u8>,
    leaving: Producer<u8>,
    flooded: Arc<AtomicU64>,
    refused: u64,
    over: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl TickLine {
    /// Starts both threads on a line, such as that of a [`TcpListening`](super::TcpListening).
    ///
    /// # Errors
    /// A line that cannot be shared, no thread to be had.
    pub fn start(line: Box<dyn Line>) -> Result<Self, SerialError> {
        let failed = |error: std::io::Error| SerialError::Thread {
            reason: error.to_string(),
        };
        let reading = line.share().map_err(failed)?;
        let (arriving, arrived) = RingBuffer::new(ROOM);
        let (leaving, left) = RingBuffer::new(ROOM);
        let mut this = Self {
            arrived,
            leaving,
            flooded: Arc::default(),
            refused: 0,
            over: Arc::default(),
            threads: Vec::new(),
        };
        let thread = |name: &str| std::thread::Builder::new().name(name.to_string());
        let (over, flooded) = (Arc::clone(&this.over), Arc::clone(&this.flooded));
        let reader = thread("line-reader").spawn(move || read(reading, arriving, &flooded, &over));
        this.threads.push(reader.map_err(failed)?);
        let over = Arc::clone(&this.over);
        let writer = thread("line-writer").spawn(move || write(line, left, &over));
        this.threads.push(writer.map_err(failed)?);
        Ok(this)
    }

    /// Takes bytes of the host, as many as have come and fit. Never waits.
    pub fn take(&mut self, into: &mut [u8]) -> usize {
        self.arrived.pop_partial_slice(into).0.len()
    }

    /// Sends a frame, whole or not at all: false if there is no room. Never waits.
    pub fn give(&mut self, frame: &[u8]) -> bool {
        let fits = self.leaving.push_entire_slice(frame).is_ok();
        self.refused += u64::from(!fits);
        fits
    }

    /// Bytes of the host that found no room, as nobody took those before.
    #[must_use]
    pub fn flooded(&self) -> u64 {
        self.flooded.load(Ordering::Relaxed)
    }

    /// Frames that found no room, as the host did not read those before.
    #[must_use]
    pub const fn refused(&self) -> u64 {
        self.refused
    }
}

impl Drop for TickLine {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            // A panic in there has been printed.
            let _ = thread.join();
        }
    }
}

fn read(
    mut line: Box<dyn Line>,
    mut arriving: Producer<u8>,
    flooded: &AtomicU64,
    over: &AtomicBool,
) {
    let mut bytes = [0; 1024];
    while !over.load(Ordering::Relaxed) {
        match line.read(&mut bytes) {
            Ok(count @ 1..) => {
                let (_, rest) = arriving.push_partial_slice(&bytes[..count]);
                flooded.fetch_add(rest.len() as u64, Ordering::Relaxed);
            }
            Err(error) if error.kind() == ErrorKind::TimedOut => {}
            // Nobody is there, or not any more.
            Ok(0) | Err(_) => std::thread::sleep(NOBODY),
        }
    }
}

fn write(mut line: Box<dyn Line>, mut left: Consumer<u8>, over: &AtomicBool) {
    let mut bytes = [0; 4096];
    let mut written = Moment::now();
    while !over.load(Ordering::Relaxed) {
        let mut rest: &[u8] = left.pop_partial_slice(&mut bytes).0;
        if rest.is_empty() {
            let lately = written.elapsed() < LATELY;
            std::thread::sleep(if lately { POLL } else { NOBODY });
        }
        while !rest.is_empty() && !over.load(Ordering::Relaxed) {
            match line.write(rest) {
                Ok(count) => {
                    rest = &rest[count..];
                    written = Moment::now();
                }
                // It does not read: what comes after this fills the ring, and is counted there.
                Err(error)
                    if matches!(
                        error.kind(),
                        ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
                    ) =>
                {
                    std::thread::sleep(POLL);
                }
                // Nobody is there.
                Err(_) => break,
            }
        }
    }
}
