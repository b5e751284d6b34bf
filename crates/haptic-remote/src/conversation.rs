//! The host's half of the conversation: numbers, answers, retries, keep-alives, counters.

use crate::{Patience, link_error::LinkError};
use core::time::Duration;
use haptic_link::{
    Alive, DeviceReport, Direction, EventKind, Header, LineCounters, OutOfOrder, Outcome, Receiver,
    Refusal, Request, SequenceTracker, Status, encode,
};

/// Tries of a request before the device counts as gone.
const TRIES: u8 = 10;

/// Between two looks at a request whose answer is due, µs.
const LOOK_US: u64 = 1000;

/// Longest listening without a good frame in which keep-alives go on: they feed the watchdog of a device of which nobody knows.
const KEPT_MOST: Duration = Duration::from_secs(2);

/// Keep-alives whose answers are known, the newest last: one that comes after the next was sent still gives its round trip.
const TOKENS: usize = 32;

/// Message that the host hears.
#[derive(Clone, Debug, PartialEq)]
pub enum Incoming {
    /// The answer to the outstanding request.
    Answer(DeviceReport),
    /// The outstanding request was refused.
    Refused {
        /// Name of the request that was refused.
        request: &'static str,
        /// Reason that the device gave for it.
        refusal: Refusal,
    },
    /// Report that nobody requested: samples, events, faults.
    Report(DeviceReport),
    /// Report like [`Report`](Self::Report), and the first of a run whose start was requested: the start was accepted, even if its answer is lost.
    Begun(DeviceReport),
    /// An answer to a keep-alive.
    Alive {
        /// When it was sent, µs.
        sent_us: u64,
        /// Time from sending to hearing, µs.
        round_trip_us: u64,
        /// The device's own time in it, µs.
        device_us: u64,
        /// It answers the newest keep-alive. An older one says that the device lives, but not how far it is.
        newest: bool,
        /// State and fault at that moment.
        status: Status,
        /// Energy that the passivity guard has observed, J; 0 without a guard.
        observed_energy_j: f32,
    },
    /// The device does not know this connection any more: it was reset, or somebody else has connected.
    Rebooted,
}

#[derive(Debug)]
struct Outstanding {
    request: Request,
    /// Numbers under which it was sent; the newest last.
    sequences: heapless::Vec<u32, { TRIES as usize }>,
    sent_us: u64,
    /// Counters when it was sent for the second time: frames already under way at the first sending prove nothing about the device.
    before: Option<LineCounters>,
}

/// Counters of the host's end of the line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HostCounters {
    /// Frames that this host has sent.
    pub sent: u32,
    /// Bytes and frames that have come, by kind.
    pub line: LineCounters,
    /// Frames that did not come once and in order.
    pub order: OutOfOrder,
    /// Requests that were sent again.
    pub retries: u32,
}

/// The host's half: one outstanding request at a time, keep-alives in between. Times are µs of any monotonic clock.
#[derive(Debug)]
pub struct Conversation {
    receiver: Receiver<DeviceReport>,
    tracker: SequenceTracker,
    sequence: u32,
    /// The number that the device gave; 0 before.
    connection: u32,
    sent: u32,
    retries: u32,
    outstanding: Option<Outstanding>,
    retry_us: u64,
    /// Somebody waits for an end: tries follow each other sooner.
    hurries: bool,
    /// Listening time that limits the tries, as a thread reports it; `None` where they go by the clock. Without end: only counted.
    listening: Option<Patience>,
    /// Time from one keep-alive to the next; `None` for none.
    keep_alive_us: Option<u64>,
    /// Time listened when that was set.
    kept_since: Duration,
    token: u32,
    /// Tick of the last sample; `None` before the first.
    newest_tick: Option<u32>,
    /// When the last ones were sent; those of number n at n modulo their count.
    tokens_us: [u64; TOKENS],
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
            hurries: false,
            listening: None,
            keep_alive_us: None,
            kept_since: Duration::ZERO,
            token: 0,
            newest_tick: None,
            tokens_us: [0; TOKENS],
        }
    }

    /// Tries count the time that [`waited`](Self::waited) reports, not the clock: an answer that was not yet read is not missing.
    #[must_use]
    pub const fn by_listening(mut self) -> Self {
        self.listening = Some(Patience::new(Duration::MAX));
        self
    }

    /// A wait for the device has ended, and what came meanwhile was [received](Self::receive).
    pub fn waited(&mut self, asked: Duration, took: Duration) {
        if let Some(listening) = &mut self.listening {
            listening.waited(asked, took);
        }
    }

    /// Listening time that [`waited`](Self::waited) reported, and how much of it has passed without a good frame.
    #[must_use]
    pub fn listened(&self) -> Patience {
        self.listening.unwrap_or(Patience::new(Duration::MAX))
    }

    /// Sends each request again as soon as a stop, from now on.
    pub const fn hurry(&mut self) {
        self.hurries = true;
    }

    /// Time after which a request is sent again, µs. Nothing is as urgent as a stop.
    const fn retry_us(&self, request: &Request) -> u64 {
        if self.hurries || matches!(request, Request::Stop) {
            self.retry_us / 3
        } else {
            self.retry_us
        }
    }

    /// The time by which tries are counted, µs.
    fn try_us(&self, now_us: u64) -> u64 {
        let listened = |patience: Patience| patience.listened().as_micros() as u64;
        self.listening.map_or(now_us, listened)
    }

    /// Sends a keep-alive at these intervals from now on, µs, until nothing good has come for 2 s of listening; `None` for none.
    pub fn set_keep_alive(&mut self, interval_us: Option<u64>) {
        self.keep_alive_us = interval_us;
        self.kept_since = self.listened().listened();
    }

    /// The interval of keep-alives, as long as the device gives signs, µs.
    fn keeps_us(&self) -> Option<u64> {
        let listened = self.listened();
        let kept = listened.listened().saturating_sub(self.kept_since);
        let silent = listened.silent().min(kept);
        self.keep_alive_us.filter(|_| silent < KEPT_MOST)
    }

    /// Encodes a request that has no answer, or whose answer is ignored. Returns its length.
    pub fn tell(&mut self, request: &Request, line: &mut [u8]) -> usize {
        // Every request fits into a frame.
        let greets = matches!(request, Request::Hello { .. });
        let connection = if greets { 0 } else { self.connection };
        let header = Header::from_host(self.sequence, connection);
        let length = encode(request, header, line).unwrap_or(0);
        self.sequence = self.sequence.wrapping_add(1);
        self.sent = self.sent.wrapping_add(1);
        length
    }

    /// Encodes a request and waits for its answer instead of the outstanding one. Repeating the
    /// same request, for instance at another baud rate, keeps the answers since its second try.
    pub fn ask(&mut self, request: Request, now_us: u64, line: &mut [u8]) -> usize {
        let again = self.outstanding.take().filter(|o| o.request == request);
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
            sent_us: self.try_us(now_us),
            before: again.map(|o| o.before.unwrap_or_else(|| self.receiver.counters())),
        });
        length
    }

    /// True if an answer is still awaited.
    #[must_use]
    pub const fn is_waiting(&self) -> bool {
        self.outstanding.is_some()
    }

    /// Frames what is due by the time: a request whose answer did not come, a keep-alive. 0 if nothing is.
    ///
    /// # Errors
    /// [`LinkError::NoAnswer`] after the last try; an echo or another version once it has answered a hello.
    pub fn due(&mut self, now_us: u64, line: &mut [u8]) -> Result<usize, LinkError> {
        let try_us = self.try_us(now_us);
        if let Some(mut outstanding) = self.outstanding.take() {
            if let Some(stranger) = self.stranger(&outstanding.request) {
                return Err(stranger);
            }
            if try_us.saturating_sub(outstanding.sent_us) < self.retry_us(&outstanding.request) {
                self.outstanding = Some(outstanding);
            } else if outstanding.sequences.push(self.sequence).is_err() {
                return Err(self.unanswered(&outstanding));
            } else {
                let before = self.receiver.counters();
                outstanding.before.get_or_insert(before);
                self.retries = self.retries.wrapping_add(1);
                let length = self.tell(&outstanding.request, line);
                outstanding.sent_us = try_us;
                self.outstanding = Some(outstanding);
                return Ok(length);
            }
        }
        match self.keeps_us() {
            Some(interval) if now_us.saturating_sub(self.sent_us(self.token)) >= interval => {
                self.token = self.token.wrapping_add(1);
                self.tokens_us[self.token as usize % TOKENS] = now_us;
                let token = self.token;
                Ok(self.tell(&Request::KeepAlive { token }, line))
            }
            _ => Ok(0),
        }
    }

    /// Gives up the outstanding request.
    pub fn no_answer(&mut self) -> LinkError {
        match self.outstanding.take() {
            Some(outstanding) => {
                let stranger = self.stranger(&outstanding.request);
                stranger.unwrap_or_else(|| self.unanswered(&outstanding))
            }
            None => LinkError::NoAnswer {
                request: "",
                line: self.receiver.counters(),
            },
        }
    }

    /// An echo or another version of the protocol, which answered a hello.
    fn stranger(&self, request: &Request) -> Option<LinkError> {
        let line = self.receiver.counters();
        (line.foreign > 0 && matches!(request, Request::Hello { .. })).then_some(
            match line.foreign_version {
                version @ 0x80.. => LinkError::OtherVersion {
                    version: version & 0x7f,
                },
                _ => LinkError::Echo,
            },
        )
    }

    fn unanswered(&self, outstanding: &Outstanding) -> LinkError {
        let line = self.receiver.counters();
        let mut line = line.since(&outstanding.before.unwrap_or(line));
        // Of another program's text no frame ever ends; that of a device does not where its power is cut.
        let greeted = matches!(outstanding.request, Request::Hello { .. });
        line.corrupt += u32::from(greeted && self.receiver.has_begun());
        LinkError::NoAnswer {
            request: outstanding.request.name(),
            line,
        }
    }

    /// When [`due`](Self::due) has something to do next, µs: not before, if tries go by listening.
    #[must_use]
    pub fn next_due_us(&self, now_us: u64) -> Option<u64> {
        let try_us = self.try_us(now_us);
        let retry = self.outstanding.as_ref();
        let retry =
            retry.map(
                |o| match (o.sent_us + self.retry_us(&o.request)).saturating_sub(try_us) {
                    0 => now_us,
                    // Whoever listens counts in steps: no need to look for the rest of one at once.
                    left => now_us + left.max(LOOK_US),
                },
            );
        let keep = self
            .keeps_us()
            .map(|interval| self.sent_us(self.token) + interval);
        match (retry, keep) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        }
    }

    /// Takes a byte. Damaged, repeated and late frames are counted and not passed on.
    pub fn receive(&mut self, byte: u8, now_us: u64) -> Option<Incoming> {
        let (header, report) = self.receiver.push(byte)?;
        let answers = self.is_answer(&report);
        if let (true, DeviceReport::Hello(hello)) = (answers, &report) {
            self.tracker.restart();
            self.connection = hello.connection;
            self.newest_tick = None;
        }
        if !self.tracker.is_new(header.sequence as u16) {
            return None;
        }
        self.listening.iter_mut().for_each(Patience::heard);
        if answers && let Some(outstanding) = self.outstanding.take() {
            if let DeviceReport::Ack(ack) = &report
                && let Outcome::Refused(refusal) = ack.outcome
            {
                let request = outstanding.request.name();
                return Some(Incoming::Refused { request, refusal });
            }
            return Some(Incoming::Answer(report));
        }
        if self.is_of_new_run(&report) && self.awaits_start() {
            self.outstanding = None;
            return Some(Incoming::Begun(report));
        }
        if let DeviceReport::Alive(alive) = &report {
            return self.alive(alive, now_us);
        }
        if let DeviceReport::Ack(ack) = &report {
            // The keep-alive of a stranger; any other answers a try that was given up.
            let keep_alive = Request::KeepAlive { token: 0 }.number();
            let dropped = ack.outcome == Outcome::Refused(Refusal::Connection);
            return (dropped && ack.request == keep_alive).then_some(Incoming::Rebooted);
        }
        (!matches!(report, DeviceReport::Hello(_))).then_some(Incoming::Report(report))
    }

    const fn sent_us(&self, token: u32) -> u64 {
        self.tokens_us[token as usize % TOKENS]
    }

    fn alive(&self, alive: &Alive, now_us: u64) -> Option<Incoming> {
        let age = self.token.wrapping_sub(alive.token);
        ((age as usize) < TOKENS).then(|| Incoming::Alive {
            sent_us: self.sent_us(alive.token),
            round_trip_us: now_us.saturating_sub(self.sent_us(alive.token)),
            device_us: alive.time_us,
            newest: age == 0,
            status: alive.status,
            observed_energy_j: alive.observed_energy_j,
        })
    }

    fn awaits_start(&self) -> bool {
        let request = self.outstanding.as_ref().map(|o| &o.request);
        matches!(request, Some(Request::Start(_)))
    }

    /// True if a run has begun since the last report: the device says so, or its ticks count anew.
    fn is_of_new_run(&mut self, report: &DeviceReport) -> bool {
        let tick = if let DeviceReport::Sample(sample) = report {
            sample.tick
        } else if let DeviceReport::Batch(batch) = report {
            batch.tick
        } else {
            return matches!(report, DeviceReport::Event(event) if event.kind == EventKind::Started);
        };
        let before = self.newest_tick.replace(tick);
        before.is_none_or(|before| tick < before)
    }

    fn is_answer(&self, report: &DeviceReport) -> bool {
        let Some(outstanding) = &self.outstanding else {
            return false;
        };
        match (&outstanding.request, report) {
            (Request::Hello { nonce }, DeviceReport::Hello(hello)) => {
                hello.nonce == *nonce && hello.connection != 0
            }
            (Request::GetKeys, DeviceReport::Keys(_))
            | (Request::GetCapabilities, DeviceReport::Capabilities(_))
            | (Request::GetConfiguration, DeviceReport::Configuration { .. })
            | (Request::GetStatistics, DeviceReport::Statistics(_)) => true,
            #[cfg(feature = "controllers")]
            (Request::GetControllerCost, DeviceReport::ControllerCost(_)) => true,
            (Request::GetCoefficients { offset }, DeviceReport::Coefficients(block)) => {
                block.offset == *offset
            }
            (Request::ReadFlight { index }, DeviceReport::Flight(flight)) => flight.index == *index,
            (Request::KeepAlive { token }, DeviceReport::Alive(alive)) => alive.token == *token,
            (request, DeviceReport::Ack(ack)) => {
                ack.request == request.number()
                    && outstanding
                        .sequences
                        .iter()
                        .any(|&sequence| sequence as u16 == ack.sequence)
            }
            _ => false,
        }
    }

    /// Counters of this end since the conversation began.
    #[must_use]
    pub fn counters(&self) -> HostCounters {
        HostCounters {
            sent: self.sent,
            line: self.receiver.counters(),
            order: self.tracker.out_of_order(),
            retries: self.retries,
        }
    }
}
