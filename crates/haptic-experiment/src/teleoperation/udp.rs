//! One side of a teleoperation in this process, the other in another one, and real datagrams between them.
//!
//! Both devices are simulated and paced by the clock. A port is served by one socket; nothing blocks the tick.

use super::body::Body;
use super::specification::TeleoperationExperiment;
use crate::device::Warn;
use crate::failure::Failure;
use crate::realtime::RealtimeOptions;
use crate::schedule::{Pace, Schedule};
use fracdiff::Operator;
use haptic_link::{Architecture, FRAME_MAX, HandSide};
use haptic_loop::SafeForce;
use haptic_loop::realtime::Periodic;
use haptic_teleoperation::{Heard, Introduction, Peer, Port};
use serde::Serialize;
use std::io::ErrorKind;
use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime};

/// Which end this process is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Waits for the other; it is the slave.
    Listen(SocketAddr),
    /// Looks for the other; it is the master.
    Connect(SocketAddr),
}

impl End {
    /// The side that it is.
    #[must_use]
    pub const fn side(self) -> HandSide {
        match self {
            Self::Listen(_) => HandSide::Slave,
            Self::Connect(_) => HandSide::Master,
        }
    }
}

/// Why a side ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FarEnd {
    /// Its time was over.
    Done,
    /// The other side said goodbye.
    OtherLeft,
    /// The other side was silent for too long.
    Silent,
    /// Somebody asked for it.
    Interrupted,
    /// The safety chain latched a fault.
    Fault,
}

/// The report of a side.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FarReport {
    /// master or slave.
    pub side: String,
    /// Name of the architecture.
    pub architecture: String,
    /// Address of the other side.
    pub peer: String,
    /// Why it ended.
    pub ended: FarEnd,
    /// Ticks of its device.
    pub ticks: u64,
    /// Time of its device at the end, s.
    pub duration_s: f64,
    /// Ticks that the clock had to skip.
    pub skipped: u64,
    /// Messages sent.
    pub sent: u64,
    /// Messages that were acted on.
    pub acted_on: u64,
    /// Numbers that were passed over: lost, or late.
    pub missing: u32,
    /// Messages after a later one: refused.
    pub stale: u32,
    /// Messages that came twice: refused.
    pub duplicate: u32,
    /// Datagrams that were damaged or no messages.
    pub corrupt: u32,
    /// Datagrams from elsewhere or of another connection.
    pub foreign: u64,
    /// Largest force, N.
    pub peak_force_n: f64,
    /// Force at the end, N: 0.
    pub final_force_n: f64,
    /// Energy that the line gave to this device, J; below 0 it took some.
    pub given_j: f64,
    /// Device time from the last message to a force of zero, s; null unless the other side fell silent.
    pub silent_to_zero_s: Option<f64>,
    /// Most of that: silence, stop time and two samples, s.
    pub silent_to_zero_most_s: f64,
}

/// From one greeting to the next.
const GREET: Duration = Duration::from_millis(50);
/// Farewells in a row: one may be lost.
const FAREWELLS: usize = 3;

/// The socket and who may speak on it.
struct Line {
    socket: UdpSocket,
    peer: Option<SocketAddr>,
    state: Peer,
    buffer: [u8; FRAME_MAX],
    strangers: u64,
}

impl TeleoperationExperiment {
    /// Runs a side for `duration_s` of its device, once the other is there; waits `patience` for it. `opened` hears the address of this side.
    ///
    /// # Errors
    /// A parameter outside its range; an address that cannot be had; nobody at the other end, or somebody who does not fit.
    pub fn run_side(
        &self,
        end: End,
        patience: Duration,
        opened: &dyn Fn(SocketAddr),
        (stop, warn): (&AtomicBool, Warn<'_>),
    ) -> Result<FarReport, Failure> {
        self.check_duration()?;
        self.check_waves()?;
        let side = end.side();
        if side == HandSide::Slave {
            self.require_stable()?;
        }
        let (port, body) = (self.port(side)?, self.body(side)?);
        let schedule = Schedule {
            samples: self.samples(),
            sample_time_s: self.sample_time().0,
            pace: match self.pace {
                Pace::Virtual => Pace::Realtime(RealtimeOptions::NORMAL),
                pace @ Pace::Realtime(_) => pace,
            },
        };
        let Some(clock) = schedule.clock().map_err(Failure::input)? else {
            return Err(Failure::bad_input("two processes need a clock"));
        };
        let mut line = Line::open(end, self.introduction(side))?;
        opened(
            line.socket
                .local_addr()
                .map_err(|error| unusable(end, &error))?,
        );
        if !line.meet(end, patience, stop)? {
            return Err(Failure::Run(anyhow::anyhow!(
                "interrupted before the other side was there; no force was made"
            )));
        }
        let mut side = Side {
            port,
            body,
            line,
            sent: 0,
            acted_on: 0,
            heard_tick: 0,
            peak_force_n: 0.0,
            left: false,
        };
        let mut periodic = Periodic::new(clock).map_err(Failure::input)?;
        let (ended, ticks, skipped, silent_to_zero) = side.all(
            &mut periodic,
            (schedule.samples, self.sample_time().0),
            stop,
        )?;
        let (_, thread) = periodic.finish();
        drop(thread);
        side.line.farewell();
        let report = self.told(&side, (ended, ticks, skipped, silent_to_zero));
        if report.skipped > 0 {
            warn(&format!(
                "this machine was late: {} of {} ticks were skipped",
                report.skipped, report.ticks
            ));
        }
        Ok(report)
    }

    fn introduction(&self, side: HandSide) -> Introduction {
        Introduction {
            side,
            architecture: self.architecture,
            sample_time_s: self.sample_time().0,
            wave_impedance_n_s_per_m: match self.architecture {
                Architecture::Wave => self.wave_impedance_n_s_per_m,
                _ => 0.0,
            },
        }
    }

    fn told(
        &self,
        side: &Side,
        (ended, ticks, skipped, silent_to_zero_s): (FarEnd, u64, u64, Option<f64>),
    ) -> FarReport {
        let t = self.sample_time().0;
        let (counts, line) = (side.port.counts(), side.line.state.counters());
        let stop_time_s = self.safety.stop_time_s;
        let stop_time_s = stop_time_s.unwrap_or(haptic_loop::Limits::default().stop_time.0);
        FarReport {
            side: side.line.state.side().to_string(),
            architecture: self.architecture.name().to_owned(),
            peer: side
                .line
                .peer
                .map_or_else(String::new, |peer| peer.to_string()),
            ended,
            ticks,
            duration_s: ticks as f64 * t,
            skipped,
            sent: side.sent,
            acted_on: side.acted_on,
            missing: counts.missing,
            stale: counts.stale,
            duplicate: counts.duplicate,
            corrupt: line.corrupt.saturating_add(line.oversize),
            foreign: side.line.strangers + u64::from(side.line.state.other_connections()),
            peak_force_n: side.peak_force_n,
            final_force_n: side.port.force_n(),
            given_j: side.port.given_j(),
            silent_to_zero_s,
            silent_to_zero_most_s: self.silence_s + stop_time_s + 2.0 * t,
        }
    }
}

/// A side at work.
struct Side {
    port: Port<Operator<f64>>,
    body: Body,
    line: Line,
    sent: u64,
    acted_on: u64,
    /// The tick of the newest message.
    heard_tick: u64,
    peak_force_n: f64,
    left: bool,
}

impl Side {
    /// All ticks, until the force is zero again: why it ended, ticks, skipped ones, and the time from the last message to zero.
    fn all<W: haptic_loop::realtime::Waiter>(
        &mut self,
        periodic: &mut Periodic<W>,
        (samples, sample_time_s): (u64, f64),
        stop: &AtomicBool,
    ) -> Result<(FarEnd, u64, u64, Option<f64>), Failure> {
        let (mut tick, mut skipped, mut ended) = (0_u64, 0_u64, None);
        let mut force = SafeForce::zero();
        loop {
            let late = periodic.wait().skipped;
            skipped += late;
            // The device moves on meanwhile, under the last force, which a real one would hold too.
            for _ in 0..late {
                self.body.advance(tick as f64 * sample_time_s, force);
                tick += 1;
            }
            self.listen(tick)?;
            force = self.tick(tick)?;
            self.body.advance(tick as f64 * sample_time_s, force);
            tick += 1;
            if ended.is_none() {
                ended = self.ended(tick >= samples, stop);
                if ended.is_some() {
                    self.port.stop();
                }
            }
            if let Some(ended) = ended.filter(|_| self.port.safety().is_at_rest()) {
                let silent = (tick - self.heard_tick) as f64 * sample_time_s;
                let silent = (ended == FarEnd::Silent).then_some(silent);
                return Ok((ended, tick, skipped, silent));
            }
        }
    }

    /// Takes in what has come.
    fn listen(&mut self, tick: u64) -> Result<(), Failure> {
        while let Some(heard) = self.line.next()? {
            match heard {
                Heard::Sample(sample) => {
                    if self.port.receive(&sample) {
                        self.acted_on += 1;
                        self.heard_tick = tick;
                    }
                }
                Heard::Hello => self.line.greet(),
                Heard::Bye => self.left = true,
                Heard::Met | Heard::Nothing => {}
            }
        }
        Ok(())
    }

    fn tick(&mut self, tick: u64) -> Result<SafeForce<f64, 1>, Failure> {
        let begun = self.port.begin(self.body.reading(tick));
        let force = begun.force();
        let message = begun.finish().message;
        self.peak_force_n = self.peak_force_n.max(force.newtons()[0].abs());
        let Line { state, buffer, .. } = &mut self.line;
        let length = (state.sample(message, buffer)).map_err(|error| Failure::Run(error.into()))?;
        self.line.send(length);
        self.sent += 1;
        Ok(force)
    }

    fn ended(&self, over: bool, stop: &AtomicBool) -> Option<FarEnd> {
        if self.port.safety().fault().is_some() {
            Some(FarEnd::Fault)
        } else if stop.load(Ordering::Relaxed) {
            Some(FarEnd::Interrupted)
        } else if self.left {
            Some(FarEnd::OtherLeft)
        } else if self.port.is_silent() {
            Some(FarEnd::Silent)
        } else {
            over.then_some(FarEnd::Done)
        }
    }
}

/// An address that cannot be used.
fn unusable(end: End, error: &std::io::Error) -> Failure {
    let (address, advice) = match end {
        End::Listen(address) => (address, "`listen`"),
        End::Connect(address) => (address, "`connect`"),
    };
    Failure::Device(anyhow::anyhow!(
        "cannot use {address}: {error}: give another address with {advice}, as 127.0.0.1:4810"
    ))
}

impl Line {
    fn open(end: End, own: Introduction) -> Result<Self, Failure> {
        let socket = match end {
            End::Listen(address) => UdpSocket::bind(address),
            // Any port of the same family.
            End::Connect(SocketAddr::V4(_)) => UdpSocket::bind("0.0.0.0:0"),
            End::Connect(SocketAddr::V6(_)) => UdpSocket::bind("[::]:0"),
        };
        let opened = socket.and_then(|socket| {
            socket.set_nonblocking(true)?;
            Ok(socket)
        });
        let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        // Another one each time, as good as chance; that of a process beside it too.
        let nonce =
            since.map_or(0, |time| time.subsec_nanos()) ^ std::process::id().rotate_left(16);
        Ok(Self {
            socket: opened.map_err(|error| unusable(end, &error))?,
            peer: match end {
                End::Connect(address) => Some(address),
                End::Listen(_) => None,
            },
            state: Peer::new(own, nonce),
            buffer: [0; FRAME_MAX],
            strangers: 0,
        })
    }

    /// Greets until the other side has heard; `false` if somebody asked to stop.
    fn meet(&mut self, end: End, patience: Duration, stop: &AtomicBool) -> Result<bool, Failure> {
        let began = Instant::now();
        let mut greeted: Option<Instant> = None;
        while !self.state.is_connected() {
            if stop.load(Ordering::Relaxed) {
                return Ok(false);
            }
            if began.elapsed() > patience {
                return Err(self.nobody(end, patience));
            }
            if greeted.is_none_or(|last| last.elapsed() >= GREET) {
                self.greet();
                greeted = Some(Instant::now());
            }
            while let Some(heard) = self.next()? {
                if heard == Heard::Hello {
                    self.greet();
                }
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        // The other may not know yet.
        self.greet();
        Ok(true)
    }

    fn nobody(&self, end: End, patience: Duration) -> Failure {
        let counters = self.state.counters();
        let strange = counters.corrupt + counters.oversize;
        let seconds = patience.as_secs_f64();
        let text = match (end, strange) {
            (End::Listen(address), 0) => format!(
                "nobody connected to {address} in {seconds} s: start the other side with `connect`"
            ),
            (End::Connect(address), 0) => format!(
                "nobody answers at {address} after {seconds} s: start the other side with `listen` there"
            ),
            (End::Listen(address) | End::Connect(address), _) => format!(
                "the wrong peer at {address}: {strange} datagrams in {seconds} s were no message of a teleoperation: give the address of \
                 the other side"
            ),
        };
        Failure::Device(anyhow::anyhow!("{text}"))
    }

    /// What the next datagram said; `None` if there is none.
    fn next(&mut self) -> Result<Option<Heard>, Failure> {
        // One more than a frame has: longer ones are cut there, and refused.
        let mut datagram = [0; FRAME_MAX + 1];
        let (length, from) = match self.socket.recv_from(&mut datagram) {
            Ok(received) => received,
            Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(None),
            // Of a datagram sent before: nobody is there (yet, or any more). Silence says so in time.
            Err(_) => return Ok(Some(Heard::Nothing)),
        };
        if self.peer.is_some_and(|peer| peer != from) {
            self.strangers += 1;
            return Ok(Some(Heard::Nothing));
        }
        let heard = match self.state.take(&datagram[..length]) {
            Ok(heard) => heard,
            Err(error) => {
                // The other side is to see it too.
                self.peer = Some(from);
                (0..FAREWELLS).for_each(|_| self.greet());
                return Err(Failure::Device(anyhow::anyhow!(
                    "{error} ({from}); no force was made"
                )));
            }
        };
        if matches!(heard, Heard::Hello | Heard::Met) {
            self.peer = Some(from);
        }
        Ok(Some(heard))
    }

    fn greet(&mut self) {
        if let Ok(length) = self.state.hello(&mut self.buffer) {
            self.send(length);
        }
    }

    /// What cannot be sent is lost, as on the way.
    fn send(&self, length: usize) {
        if let Some(peer) = self.peer {
            let _ = self.socket.send_to(&self.buffer[..length], peer);
        }
    }

    fn farewell(&mut self) {
        for _ in 0..FAREWELLS {
            if let Ok(length) = self.state.bye(&mut self.buffer) {
                self.send(length);
            }
        }
    }
}
