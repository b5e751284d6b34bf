//! The host's half of the conversation: numbers, answers, retries, keep-alives, counters.

use core::fmt;
use haptic_link::{
    Alive, Direction, FaultReport, Header, Keys, LineCounters, Outcome, Receiver, Refusal, Report,
    Request, SequenceTracker, Status, encode,
};

/// Tries of a request before the device counts as gone.
const TRIES: u8 = 10;

/// What the host hears.
#[derive(Clone, Debug, PartialEq)]
pub enum Incoming {
    /// The answer to the outstanding request.
    Answer(Report),
    /// The outstanding request was refused.
    Refused {
        /// Its name.
        request: &'static str,
        /// Why.
        refusal: Refusal,
    },
    /// Something that was not asked for: samples, events, faults.
    Told(Report),
    /// An answer to a keep-alive.
    Alive {
        /// From sending to hearing, µs.
        round_trip_us: u64,
        /// State and fault.
        status: Status,
        /// What the passivity guard has observed, J; 0 without one.
        observed_energy_j: f32,
    },
    /// The device does not know this connection any more: it was reset, or somebody else has connected.
    Rebooted,
}

/// Why the conversation cannot go on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum LinkError {
    /// No answer, after several tries.
    NoAnswer {
        /// Name of the request.
        request: &'static str,
        /// What came instead.
        line: LineCounters,
    },
    /// The device refused.
    Refused {
        /// Name of the request.
        request: &'static str,
        /// Why.
        refusal: Refusal,
    },
    /// The device speaks another version of the protocol.
    OtherVersion {
        /// Its version.
        version: u8,
    },
    /// The port sends back what it is sent.
    Echo,
    /// The device was built with another definition of a message.
    OtherMessages {
        /// Its firmware version.
        firmware: [u8; 3],
        /// Name of the first such message.
        message: &'static str,
    },
    /// A fault latched on the device.
    Faulted(FaultReport),
    /// The device does not know this connection any more.
    Rebooted,
    /// No sample in the middle of a run for so long.
    NoSamples {
        /// Waited, ms.
        waited_ms: u64,
    },
    /// The line is gone.
    Gone,
}

impl fmt::Display for LinkError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAnswer { request, line } => {
                write!(f, "no answer to \"{request}\": ")?;
                explain_silence(f, line)
            }
            Self::Refused { request, refusal } => {
                write!(f, "the device refused \"{request}\": ")?;
                explain_refusal(f, refusal)
            }
            Self::OtherVersion { version } => write!(
                f,
                "the device speaks protocol version {version}, this program {}: flash the firmware of this \
                 program, or take the program of that firmware",
                haptic_link::PROTOCOL_VERSION
            ),
            Self::Echo => {
                f.write_str("the port sends back what it is sent, so it is no device but an echo")
            }
            Self::OtherMessages {
                firmware: [major, minor, patch],
                message,
            } => write!(
                f,
                "the device has firmware {major}.{minor}.{patch}, whose message \"{message}\" is not that of this \
                 program: flash the firmware of this version, or take the program of that one"
            ),
            Self::Faulted(report) => match haptic_loop::Fault::from_code(report.status.fault) {
                Some(fault) => write!(f, "the device latched a fault at tick {}: {fault}", report.tick),
                None => write!(
                    f,
                    "the device latched fault {}, which this program does not know, at tick {}",
                    report.status.fault, report.tick
                ),
            },
            Self::Rebooted => f.write_str(
                "the device does not know this connection any more: it was reset, or another program has \
                 connected; connect again",
            ),
            Self::NoSamples { waited_ms } => write!(
                f,
                "no sample came for {waited_ms} ms in the middle of a run: the line or the device is stuck"
            ),
            Self::Gone => f.write_str("the line is gone: the device was unplugged or switched off"),
        }
    }
}

impl core::error::Error for LinkError {}

/// What silence looks like.
fn explain_silence(f: &mut fmt::Formatter<'_>, line: &LineCounters) -> fmt::Result {
    match line {
        LineCounters {
            received: 0,
            corrupt,
            oversize,
            ..
        } if corrupt + oversize > 0 => write!(
            f,
            "{} pieces of garbage came instead; is this the right port, and the right baud rate?",
            corrupt + oversize
        ),
        LineCounters { received: 0, .. } => f.write_str(
            "nothing came; is this the right port, and is the device switched on and flashed?",
        ),
        _ => f.write_str("other frames came, so the line works, but the device does not answer"),
    }
}

fn explain_refusal(f: &mut fmt::Formatter<'_>, refusal: &Refusal) -> fmt::Result {
    match refusal {
        Refusal::State(state) => write!(f, "not while it is {state}"),
        Refusal::Range {
            field,
            value,
            least,
            most,
        } => {
            let open = *least > 0.0 && *least <= f32::MIN_POSITIVE;
            write!(f, "{field} {value} is not ")?;
            match (open, *most < f32::MAX) {
                (true, true) => write!(f, "in (0, {most}]"),
                (false, true) => write!(f, "in [{least}, {most}]"),
                (true, false) => f.write_str("above 0"),
                (false, false) if *least > -f32::MAX => write!(f, "a number of at least {least}"),
                (false, false) => f.write_str("a finite number"),
            }?;
            f.write_str(" on this device")
        }
        Refusal::Digest => f.write_str("the parameters were damaged on the way; try again"),
        Refusal::Incomplete => f.write_str("some of the parameters did not arrive; try again"),
        Refusal::Unsupported(field) => {
            write!(f, "{field} as asked for is not possible on this board")
        }
        Refusal::UnknownFault => {
            f.write_str("a fault has latched in the meantime; look at its cause, then arm again")
        }
        Refusal::ForceNotZero => f.write_str("the force has not fallen to zero yet; try again"),
        Refusal::ForceNotSmall {
            wanted_n,
            allowed_n,
        } => write!(
            f,
            "at this position the force would start at {wanted_n} N, above the {allowed_n} N allowed: \
             move the device out of the wall"
        ),
        Refusal::FaultPersists(code) => match haptic_loop::Fault::from_code(*code) {
            Some(fault) => write!(f, "{fault}; mend that first"),
            None => write!(f, "the cause of fault {code} is still there"),
        },
        Refusal::Connection => f.write_str(
            "it does not know this connection, or another one has armed it: it was reset, or another program has \
             connected; connect again",
        ),
        Refusal::Looser(field) => write!(
            f,
            "{field} is looser than what is set on the device, and a run may only tighten it: change what is set \
             on the device first"
        ),
    }
}

/// A request that waits for its answer.
#[derive(Clone, Debug, PartialEq)]
struct Outstanding {
    request: Request,
    /// Numbers under which it was sent; the newest last.
    sequences: heapless::Vec<u32, { TRIES as usize }>,
    sent_us: u64,
}

/// What the host has counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HostCounters {
    /// Frames sent.
    pub sent: u32,
    /// Frames received whole.
    pub received: u32,
    /// Frames damaged or of no known kind.
    pub corrupt: u32,
    /// Frames longer than the buffer.
    pub oversize: u32,
    /// Frames of another version, or echoes.
    pub foreign: u32,
    /// Frames that did not come.
    pub lost: u32,
    /// Frames that came twice.
    pub duplicate: u32,
    /// Frames that came after a later one.
    pub late: u32,
    /// Requests that were sent again.
    pub retries: u32,
}

/// The host's half: one outstanding request at a time, keep-alives in between.
///
/// Times are µs of any clock that does not go back.
#[derive(Debug)]
pub struct Conversation {
    receiver: Receiver<Report>,
    tracker: SequenceTracker,
    /// Of the next frame.
    sequence: u32,
    /// The number that the device gave; 0 before.
    connection: u32,
    sent: u32,
    retries: u32,
    outstanding: Option<Outstanding>,
    retry_us: u64,
    /// Time from one keep-alive to the next; `None` for none.
    keep_alive_us: Option<u64>,
    token: u32,
    token_us: u64,
}

impl Conversation {
    /// A conversation that has not begun; a request is sent again after `retry_us`.
    #[must_use]
    pub const fn new(retry_us: u64) -> Self {
        Self {
            receiver: Receiver::new(Direction::FromDevice),
            tracker: SequenceTracker::NEW,
            sequence: 0,
            connection: 0,
            sent: 0,
            retries: 0,
            outstanding: None,
            retry_us,
            keep_alive_us: None,
            token: 0,
            token_us: 0,
        }
    }

    /// Sends a keep-alive at these intervals from now on, µs; `None` for none.
    pub const fn set_keep_alive(&mut self, interval_us: Option<u64>) {
        self.keep_alive_us = interval_us;
    }

    /// Frames a request that is not answered, or whose answer nobody waits for. Returns its length.
    pub fn tell(&mut self, request: &Request, line: &mut [u8]) -> usize {
        // Every request fits into a frame.
        let connection = match request {
            Request::Hello { .. } => 0,
            _ => self.connection,
        };
        let header = Header::from_host(self.sequence, connection);
        let length = encode(request, header, line).unwrap_or(0);
        self.sequence = self.sequence.wrapping_add(1);
        self.sent = self.sent.wrapping_add(1);
        length
    }

    /// Frames a request and waits for its answer; one that is outstanding is given up.
    pub fn ask(&mut self, request: Request, now_us: u64, line: &mut [u8]) -> usize {
        let mut sequences = heapless::Vec::new();
        // There is room for the first.
        let _ = sequences.push(self.sequence);
        let length = self.tell(&request, line);
        if matches!(request, Request::Hello { .. }) {
            // The device may have been switched on long ago.
            self.tracker.restart();
        }
        self.outstanding = Some(Outstanding {
            request,
            sequences,
            sent_us: now_us,
        });
        length
    }

    /// Whether an answer is still awaited.
    #[must_use]
    pub const fn is_waiting(&self) -> bool {
        self.outstanding.is_some()
    }

    /// Frames what is due by the time: a request whose answer did not come, a keep-alive. 0 if nothing is.
    ///
    /// # Errors
    /// [`LinkError::NoAnswer`] after the last try; an echo or another version once it has answered a hello.
    pub fn due(&mut self, now_us: u64, line: &mut [u8]) -> Result<usize, LinkError> {
        if let Some(mut outstanding) = self.outstanding.take() {
            let line_counters = self.receiver.counters();
            if line_counters.foreign > 0 && matches!(outstanding.request, Request::Hello { .. }) {
                return Err(match line_counters.foreign_version {
                    version @ 0x80.. => LinkError::OtherVersion {
                        version: version & 0x7f,
                    },
                    _ => LinkError::Echo,
                });
            }
            if now_us.saturating_sub(outstanding.sent_us) < self.retry_us {
                self.outstanding = Some(outstanding);
            } else if outstanding.sequences.push(self.sequence).is_err() {
                return Err(LinkError::NoAnswer {
                    request: outstanding.request.name(),
                    line: line_counters,
                });
            } else {
                self.retries = self.retries.wrapping_add(1);
                let length = self.tell(&outstanding.request, line);
                outstanding.sent_us = now_us;
                self.outstanding = Some(outstanding);
                return Ok(length);
            }
        }
        match self.keep_alive_us {
            Some(interval) if now_us.saturating_sub(self.token_us) >= interval => {
                self.token = self.token.wrapping_add(1);
                self.token_us = now_us;
                let token = self.token;
                Ok(self.tell(&Request::KeepAlive { token }, line))
            }
            _ => Ok(0),
        }
    }

    /// Gives up the outstanding request.
    pub fn no_answer(&mut self) -> LinkError {
        let request = self.outstanding.take();
        LinkError::NoAnswer {
            request: request.map_or("", |outstanding| outstanding.request.name()),
            line: self.receiver.counters(),
        }
    }

    /// When [`due`](Self::due) has something to do next, µs.
    #[must_use]
    pub fn next_due_us(&self) -> Option<u64> {
        let retry = self.outstanding.as_ref().map(|o| o.sent_us + self.retry_us);
        let keep = self.keep_alive_us.map(|interval| self.token_us + interval);
        match (retry, keep) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        }
    }

    /// Takes a byte. Damaged, repeated and late frames are counted and not passed on.
    pub fn receive(&mut self, byte: u8, now_us: u64) -> Option<Incoming> {
        let (header, report) = self.receiver.push(byte)?;
        let answers = self.is_answer(&report);
        if let (true, Report::Hello(hello)) = (answers, &report) {
            self.tracker.restart();
            self.connection = hello.connection;
        }
        if !self.tracker.arrive(header.sequence as u16).is_new() {
            return None;
        }
        if answers && let Some(outstanding) = self.outstanding.take() {
            return Some(match report {
                Report::Ack(ack) => match ack.outcome {
                    Outcome::Done => Incoming::Answer(report),
                    Outcome::Refused(refusal) => Incoming::Refused {
                        request: outstanding.request.name(),
                        refusal,
                    },
                },
                _ => Incoming::Answer(report),
            });
        }
        match report {
            Report::Alive(alive) => self.alive(&alive, now_us),
            // The keep-alive of a stranger.
            Report::Ack(ack) if ack.outcome == Outcome::Refused(Refusal::Connection) => {
                let keep_alive = Request::KeepAlive { token: 0 }.number();
                (ack.request == keep_alive).then_some(Incoming::Rebooted)
            }
            // Answers to tries that were given up.
            Report::Ack(_) | Report::Hello(_) => None,
            report => Some(Incoming::Told(report)),
        }
    }

    fn alive(&self, alive: &Alive, now_us: u64) -> Option<Incoming> {
        // An old token says that the device lives, but not how far it is.
        (alive.token == self.token).then(|| Incoming::Alive {
            round_trip_us: now_us.saturating_sub(self.token_us),
            status: alive.status,
            observed_energy_j: alive.observed_energy_j,
        })
    }

    /// Whether a report answers the outstanding request.
    fn is_answer(&self, report: &Report) -> bool {
        let Some(outstanding) = &self.outstanding else {
            return false;
        };
        match (&outstanding.request, report) {
            (Request::Hello { nonce }, Report::Hello(hello)) => {
                hello.nonce == *nonce && hello.connection != 0
            }
            (Request::GetKeys, Report::Keys(_))
            | (Request::GetCapabilities, Report::Capabilities(_))
            | (Request::GetConfiguration, Report::Configuration { .. })
            | (Request::GetStatistics, Report::Statistics(_)) => true,
            (Request::GetCoefficients { offset }, Report::Coefficients(block)) => {
                block.offset == *offset
            }
            (Request::ReadFlight { index }, Report::Flight(flight)) => flight.index == *index,
            (request, Report::Ack(ack)) => {
                ack.request == request.number()
                    && outstanding
                        .sequences
                        .iter()
                        .any(|&sequence| sequence as u16 == ack.sequence)
            }
            _ => false,
        }
    }

    /// All counters.
    #[must_use]
    pub fn counters(&self) -> HostCounters {
        let line = self.receiver.counters();
        HostCounters {
            sent: self.sent,
            received: line.received,
            corrupt: line.corrupt,
            oversize: line.oversize,
            foreign: line.foreign,
            lost: self.tracker.lost(),
            duplicate: self.tracker.duplicate(),
            late: self.tracker.late(),
            retries: self.retries,
        }
    }
}

/// Checks that the device has every message of this program, in the same form.
///
/// # Errors
/// [`LinkError::OtherMessages`].
pub fn check_keys(keys: &Keys, firmware: [u8; 3]) -> Result<(), LinkError> {
    match keys.first_unlike() {
        None => Ok(()),
        Some(message) => Err(LinkError::OtherMessages { firmware, message }),
    }
}
