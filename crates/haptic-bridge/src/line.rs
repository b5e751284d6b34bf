//! The line to the host, on a thread of its own: bytes to requests, reports to bytes.

use crate::ticking::Heard;
use haptic_link::{Direction, FRAME_MAX, Header, Receiver, Report, Request, Statistics, encode};
use rtrb::{Consumer, Producer, RingBuffer};
use std::io::{ErrorKind, Read, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Requests on their way at most. What finds no room is lost, and missed by its number.
const REQUESTS_WAITING: usize = 64;
/// Reports on their way at most: a second at 1 kHz without batches.
const REPORTS_WAITING: usize = 1024;
/// Bytes read, or put together for a write, at once.
const AT_ONCE: usize = 4096;
/// Pause while nobody has said anything for long.
const NOBODY: Duration = Duration::from_millis(5);
/// Rounds without a byte that are long.
const QUIET_ROUNDS: u32 = 4000;

/// The host's end of a bridge: bytes in, bytes out, without a line.
#[derive(Debug)]
pub struct LineSide {
    receiver: Receiver<Request>,
    requests: Producer<Heard>,
    reports: Consumer<Report>,
    sequence: u16,
    sent: u32,
    /// Frames that the line has not taken yet.
    waiting: Vec<u8>,
}

impl LineSide {
    /// With the ends of the thread that ticks.
    pub(crate) fn new() -> (Self, (Consumer<Heard>, Producer<Report>)) {
        let (requests, hearing) = RingBuffer::new(REQUESTS_WAITING);
        let (speaking, reports) = RingBuffer::new(REPORTS_WAITING);
        let this = Self {
            receiver: Receiver::new(Direction::FromHost),
            requests,
            reports,
            sequence: 0,
            sent: 0,
            waiting: Vec::with_capacity(AT_ONCE + FRAME_MAX),
        };
        (this, (hearing, speaking))
    }

    /// Takes bytes of the host.
    pub fn take(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if let Some(heard) = self.receiver.push(byte) {
                // A host that says more than is acted on loses it, as on a line that is too slow.
                let _ = self.requests.push(heard);
            }
        }
    }

    /// Writes the next frame for the host into `frame` and returns its length; 0 if there is none.
    pub fn next(&mut self, frame: &mut [u8; FRAME_MAX]) -> usize {
        let Ok(mut report) = self.reports.pop() else {
            return 0;
        };
        if let Report::Statistics(statistics) = &mut report {
            self.count(statistics);
        }
        // Every report fits into a frame.
        let length = encode(&report, Header::from_device(self.sequence), frame).unwrap_or(0);
        self.sequence = self.sequence.wrapping_add(1);
        self.sent = self.sent.wrapping_add(1);
        length
    }

    /// The counters of the line, which the thread that ticks does not know.
    const fn count(&self, statistics: &mut Statistics) {
        let line = self.receiver.counters();
        statistics.sent = self.sent;
        statistics.received = line.received;
        statistics.corrupt = line.corrupt;
        statistics.oversize = line.oversize;
        statistics.foreign = line.foreign;
    }

    /// Takes what is there and gives what the line takes, without waiting. Whether anything moved.
    fn exchange(&mut self, line: &mut (impl Read + Write)) -> bool {
        let mut bytes = [0; AT_ONCE];
        // A line without a host has no bytes.
        let count = line.read(&mut bytes).unwrap_or(0);
        self.take(&bytes[..count]);
        let mut frame = [0; FRAME_MAX];
        while self.waiting.len() < AT_ONCE {
            let length = self.next(&mut frame);
            if length == 0 {
                break;
            }
            self.waiting.extend_from_slice(&frame[..length]);
        }
        if self.waiting.is_empty() {
            return count > 0;
        }
        match line.write(&self.waiting) {
            Ok(written) => {
                self.waiting.drain(..written);
                true
            }
            Err(error) if is_passing(error.kind()) => count > 0,
            Err(_) => {
                // Nobody is there.
                self.waiting.clear();
                count > 0
            }
        }
    }

    /// Serves a line that does not wait until the end.
    pub(crate) fn serve(
        mut self,
        mut line: impl Read + Write,
        pause: Duration,
        ended: &AtomicBool,
    ) {
        let mut quiet = 0_u32;
        while !ended.load(Ordering::Relaxed) {
            quiet = if self.exchange(&mut line) {
                0
            } else {
                quiet.saturating_add(1)
            };
            let is_quiet = quiet > QUIET_ROUNDS;
            std::thread::sleep(if is_quiet { NOBODY } else { pause });
        }
    }
}

const fn is_passing(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}
