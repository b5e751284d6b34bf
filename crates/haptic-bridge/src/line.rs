//! The line to the host, on a thread of its own: bytes to requests, reports to bytes.

use crate::{status::Handle, ticking::Heard};
use haptic_link::{
    DeviceReport, Direction, FRAME_MAX, Header, Reason, Receiver, Request, Statistics, Trouble,
    encode,
};
use haptic_loop::realtime::Moment;
use rtrb::{Consumer, Producer, RingBuffer};
use std::{
    io::{ErrorKind, Read, Write},
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};

/// Requests on their way at most. What finds no room is lost, and missed by its number.
const REQUESTS_WAITING: usize = 64;
/// Reports on their way at most: a second at 1 kHz without batches.
const REPORTS_WAITING: usize = 1024;
/// Bytes read, or put together for a write, at once.
const AT_ONCE: usize = 4096;
/// Pause after a long silence of all.
const NOBODY: Duration = Duration::from_millis(5);
/// Rounds without a byte that are long.
const QUIET_ROUNDS: u32 = 4000;

/// Time from one look at the program to the next, µs.
const LOOK_US: u64 = 250_000;
/// Fewest calls in that time from which their unit can be judged.
const CALLS_LEAST: u32 = 20;
/// A clock that runs slower by this factor is in ms or in s; no machine is that slow.
const UNIT: u64 = 100;

/// The host's end of a bridge: bytes in, bytes out, without a line.
#[derive(Debug)]
pub struct LineSide {
    receiver: Receiver<Request>,
    requests: Producer<Heard>,
    reports: Consumer<DeviceReport>,
    sequence: u16,
    sent: u32,
    /// Frames that the line has not taken yet.
    waiting: Vec<u8>,
    handle: Handle,
    /// T as it was declared, µs; 0 if it is measured.
    period_us: u64,
    looked: Looked,
}

/// The program's calls as they were when this thread last looked.
#[derive(Debug, Default)]
struct Looked {
    at_us: u64,
    calls: u32,
    told_us: u64,
    /// It had made none since the look before.
    was_silent: bool,
    /// The time that was given had hardly gone on.
    was_wrong: bool,
}

impl LineSide {
    /// Side of the line, with the ends of the thread that ticks.
    pub(crate) fn new(
        handle: Handle,
        period_us: u64,
    ) -> (Self, (Consumer<Heard>, Producer<DeviceReport>)) {
        let (requests, hearing) = RingBuffer::new(REQUESTS_WAITING);
        let (speaking, reports) = RingBuffer::new(REPORTS_WAITING);
        let this = Self {
            receiver: Receiver::new(Direction::FromHost),
            requests,
            reports,
            sequence: 0,
            sent: 0,
            waiting: Vec::with_capacity(AT_ONCE + FRAME_MAX),
            handle,
            period_us,
            looked: Looked {
                was_silent: true,
                ..Looked::default()
            },
        };
        (this, (hearing, speaking))
    }

    /// Takes bytes of the host.
    pub fn take(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if let Some(heard) = self.receiver.push(byte) {
                if matches!(heard.1, Request::Hello { .. }) {
                    self.excuse();
                }
                // A host that says more than is acted on loses it, as on a line that is too slow.
                let _ = self.requests.push(heard);
            }
        }
    }

    /// Writes the next frame for the host into `frame` and returns its length; 0 if no frame waits.
    pub fn next(&mut self, frame: &mut [u8; FRAME_MAX]) -> usize {
        let Ok(mut report) = self.reports.pop() else {
            return 0;
        };
        if let DeviceReport::Statistics(statistics) = &mut report {
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

    /// Tells a host that greets a device why that cannot answer. A zero ends the text, as no frame begins so.
    fn excuse(&mut self) {
        let why = if self.looked.was_silent && self.looked.calls == self.handle.calls().0 {
            "the program does not call hb_tick: start its haptic thread".to_owned()
        } else if self.period_us == 0
            && let Some(reason) = self.handle.wrong_unit()
        {
            reason.to_string()
        } else {
            return;
        };
        let text = format!("waiting: {why}\n\0");
        self.waiting.extend_from_slice(text.as_bytes());
    }

    /// Looks at the calls of the program, at this time of a clock of the machine, µs: they may have ceased, or give the time in
    /// another unit.
    pub fn watch(&mut self, now_us: u64) {
        let passed_us = now_us.saturating_sub(self.looked.at_us);
        if passed_us < LOOK_US {
            return;
        }
        let (calls, told_us) = self.handle.calls();
        let made = calls.wrapping_sub(self.looked.calls);
        let handed_us = told_us.saturating_sub(self.looked.told_us);
        // The first call gives any time. A program that calls more often than it has to lives in a time of its own.
        let is_wrong = made >= CALLS_LEAST
            && self.looked.calls > 0
            && passed_us >= u64::from(made) * self.period_us / 2
            && handed_us < passed_us / UNIT;
        // Twice in a row, as a busy machine may hold a program up.
        let is_known = is_wrong && self.looked.was_wrong;
        self.handle.judge_unit(is_known.then(|| Reason {
            trouble: Trouble::Unit,
            measured_us: u32::try_from(passed_us).unwrap_or(u32::MAX),
            told_us: handed_us as u32,
        }));
        self.looked = Looked {
            at_us: now_us,
            calls,
            told_us,
            was_wrong: is_wrong,
            was_silent: made == 0,
        };
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
        let began = Moment::now();
        while !ended.load(Ordering::Relaxed) {
            self.watch(began.elapsed().as_micros() as u64);
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
