//! A device on a serial port: two threads that speak, and a [`Device`] whose force comes from here.
//!
//! ```text
//! reader thread:  port ─▶ Conversation ─▶ answers, samples and notices (bounded; what finds no room counts)
//! writer thread:  requests, forces ─▶ Conversation ─▶ port; retries; keep-alives
//! ```
//! The thread that ticks never waits for the port: it takes samples from a queue and puts forces into one.
//! Dropping a [`SerialLink`] disarms the device, then closes the port.

mod error;
mod greeting;
mod port;
mod threads;

pub use error::SerialError;
pub use greeting::{BAUDS, GREETING};
pub use port::{PortInfo, ports};

use crate::{Conversation, HostCounters, LinkError, check_keys};
use fracdiff::Real;
use haptic_link::{
    Capabilities, CoefficientBlock, Configuration, DigestBuilder, Event, EventKind, FaultReport,
    Field, Hello, Refusal, Report, Request, Sample, Scope, Start, State, Statistics, Status,
    block_count,
};
use haptic_loop::realtime::{self, raise_thread};
use haptic_loop::{Device, Reading, SafeForce};
use hdrhistogram::Histogram;
use nalgebra::SVector;
use std::boxed::Box;
use std::string::{String, ToString};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::mpsc::{
    Receiver, RecvTimeoutError, SyncSender, TryRecvError, TrySendError, sync_channel,
};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use std::vec::Vec;
use threads::{Reader, Writer};

/// Samples and notices that wait for whoever runs the experiment at most: a minute at 1 kHz.
const HEARD_MOST: usize = 1 << 16;
/// Requests and forces that wait for the port at most.
const COMMANDS_MOST: usize = 256;
/// An unanswered request is sent again after this time.
const RETRY: Duration = Duration::from_millis(150);
/// A run that gives no sample for so long is stuck.
const SAMPLE_TIMEOUT: Duration = Duration::from_millis(2000);

/// What a device says unasked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Heard {
    /// A tick.
    Sample(Sample),
    /// Something happened.
    Event(Event),
    /// A fault latched.
    Fault(FaultReport),
    /// The session is over.
    Over(LinkError),
}

/// What a link has counted.
#[derive(Clone, Debug)]
pub struct LinkReport {
    /// Of the host's end.
    pub host: HostCounters,
    /// Samples that found the queue full.
    pub samples_dropped: u64,
    /// Forces that found the queue full.
    pub forces_dropped: u64,
    /// Forces that were not sent because a newer sample had come already.
    pub forces_skipped: u64,
    /// From sending a keep-alive to hearing the answer, µs.
    pub round_trip_us: Histogram<u64>,
}

/// How to connect. By default [`BAUDS`], one attempt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ConnectOptions {
    /// Bits per second; `None` tries each of [`BAUDS`].
    pub baud: Option<u32>,
    /// How long to go on trying a port that is not there or does not answer.
    pub patience: Duration,
}

/// A device that has answered, on an open port.
#[derive(Debug)]
pub struct SerialLink {
    shared: Arc<Shared>,
    commands: Option<SyncSender<Command>>,
    answers: Receiver<Result<Report, LinkError>>,
    heard: Receiver<Heard>,
    threads: Vec<JoinHandle<()>>,
    hello: Hello,
    capabilities: Capabilities,
    latency_ms: Option<u32>,
    path: String,
    baud: u32,
    /// Heard before its turn, to see whether a newer sample waits.
    ahead: Option<Heard>,
    /// A run that was started and whose end was not heard yet, as of the alive of this number.
    running: Option<u64>,
    newest_tick: u32,
    newest_limiters: u8,
    /// Tick of the last sample heard.
    heard_tick: u32,
    forces_skipped: u64,
}

#[derive(Debug)]
enum Command {
    Ask(Request),
    Tell(Request),
}

#[derive(Debug)]
struct Shared {
    conversation: Mutex<Conversation>,
    began: Instant,
    over: AtomicBool,
    samples_dropped: AtomicU64,
    forces_dropped: AtomicU64,
    round_trip_us: Mutex<Histogram<u64>>,
    status: Mutex<Status>,
    /// Answers to keep-alives so far: each brings the status of its moment.
    alives: AtomicU64,
    /// What the guard observed, bits of an `f32`.
    energy_bits: AtomicU32,
    period_us: AtomicU32,
}

impl Shared {
    fn now_us(&self) -> u64 {
        self.began.elapsed().as_micros() as u64
    }

    fn conversation(&self) -> MutexGuard<'_, Conversation> {
        lock(&self.conversation)
    }
}

/// Whoever panicked with it has been seen; what is inside are counters.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl SerialLink {
    /// Opens the port, greets the device, brings it to rest and asks what it can do. Tries again with
    /// growing pauses, 50 ms to 1 s, until the patience is over.
    ///
    /// # Errors
    /// A port that is not there, is in use or may not be opened; no answer, garbage, an echo, another
    /// protocol version.
    pub fn connect(path: &str, options: ConnectOptions) -> Result<Self, SerialError> {
        let began = Instant::now();
        let mut pause = Duration::from_millis(50);
        loop {
            let error = match Self::connect_once(path, options.baud) {
                Ok(link) => return Ok(link),
                Err(error) => error,
            };
            // Another version does not go away by waiting.
            let hopeless = matches!(
                error,
                SerialError::Link(
                    LinkError::OtherMessages { .. }
                        | LinkError::OtherVersion { .. }
                        | LinkError::Echo
                )
            );
            if hopeless || began.elapsed() + pause > options.patience {
                return Err(error);
            }
            std::thread::sleep(pause);
            pause = (2 * pause).min(Duration::from_secs(1));
        }
    }

    fn connect_once(path: &str, baud: Option<u32>) -> Result<Self, SerialError> {
        let latency_ms = port::shorten_latency(path);
        let bauds = baud.as_ref().map_or(&BAUDS[..], std::slice::from_ref);
        let mut port = port::open(path, bauds[0])?;
        let mut conversation = Conversation::new(RETRY.as_micros() as u64);
        let (hello, baud) = greeting::greet(port.as_mut(), &mut conversation, bauds)?;
        let reading = port.try_clone().map_err(|error| SerialError::Open {
            path: path.to_string(),
            baud,
            reason: error.to_string(),
        })?;
        // 1 µs to 10 s, two digits: these bounds are good, so there is always a histogram.
        let histogram = Histogram::new_with_bounds(1, 10_000_000, 2);
        let shared = Arc::new(Shared {
            conversation: Mutex::new(conversation),
            began: Instant::now(),
            over: AtomicBool::new(false),
            samples_dropped: AtomicU64::new(0),
            forces_dropped: AtomicU64::new(0),
            round_trip_us: Mutex::new(histogram.map_err(|error| SerialError::Thread {
                reason: error.to_string(),
            })?),
            status: Mutex::new(hello.status),
            alives: AtomicU64::new(0),
            energy_bits: AtomicU32::new(0),
            period_us: AtomicU32::new(1000),
        });
        let (commands, to_send) = sync_channel(COMMANDS_MOST);
        let (answered, answers) = sync_channel(8);
        let (hear, heard) = sync_channel(HEARD_MOST);
        let spawn = |name: &str, run: Box<dyn FnOnce() + Send>| {
            let builder = std::thread::Builder::new().name(name.to_string());
            builder.spawn(run).map_err(|error| SerialError::Thread {
                reason: error.to_string(),
            })
        };
        let reader = Reader {
            shared: Arc::clone(&shared),
            answers: answered.clone(),
            heard: hear.clone(),
        };
        let writer = Writer {
            shared: Arc::clone(&shared),
            answers: answered,
            heard: hear,
        };
        let threads = [
            spawn("link-reader", Box::new(move || reader.run(reading)))?,
            spawn("link-writer", Box::new(move || writer.run(port, &to_send)))?,
        ];
        let mut link = Self {
            shared,
            commands: Some(commands),
            answers,
            heard,
            threads: threads.into(),
            hello,
            // Until the device has said so itself: nothing.
            capabilities: Capabilities {
                board: [0; 16],
                axes: 0,
                simulated: false,
                tick_period_min_us: 0,
                tick_period_max_us: 0,
                force_max_n: 0.0,
                force_rate_max_n_per_s: 0.0,
                position_resolution_m: 0.0,
                coefficients_max: 0,
                modes_max: 0,
                degree_max: 0,
                flight_samples: 0,
            },
            latency_ms,
            path: path.to_string(),
            baud,
            ahead: None,
            running: None,
            newest_tick: 0,
            newest_limiters: 0,
            heard_tick: 0,
            forces_skipped: 0,
        };
        link.introduce()?;
        Ok(link)
    }

    /// Keys, rest, capabilities.
    fn introduce(&mut self) -> Result<(), SerialError> {
        if let Report::Keys(keys) = self.ask(Request::GetKeys)? {
            check_keys(&keys, self.hello.firmware)?;
        }
        // Somebody may have left it running.
        if !matches!(self.hello.status.state, State::Idle | State::Fault) {
            self.ask(Request::Disarm)?;
            self.wait_for_rest();
        }
        if let Report::Capabilities(capabilities) = self.ask(Request::GetCapabilities)? {
            self.capabilities = capabilities;
        }
        let (configuration, _) = self.configuration()?;
        self.ticks_every(configuration.tick_period_us);
        // Old samples and notices are none of this session.
        while self.heard.try_recv().is_ok() {}
        Ok(())
    }

    /// Waits until the force of a device that was told to let go has fallen to zero, and says whether it has.
    pub fn wait_for_rest(&self) -> bool {
        /// Longer than a force takes to fall.
        const PATIENCE: Duration = Duration::from_secs(2);
        let began = Instant::now();
        let resting = || matches!(self.status().state, State::Idle | State::Fault);
        // The last status is from before the request.
        loop {
            drop(self.measure_round_trip(Duration::from_millis(20)));
            if resting() || began.elapsed() >= PATIENCE {
                return resting();
            }
        }
    }

    /// T, s.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        f64::from(self.shared.period_us.load(Ordering::Relaxed)) * 1e-6
    }

    fn ticks_every(&self, period_us: u32) {
        self.shared.period_us.store(period_us, Ordering::Relaxed);
    }

    /// Raises the threads that read and write to a real-time priority, so that keep-alives are sent on a busy machine.
    ///
    /// # Errors
    /// What the system does not allow; they go on as they were.
    pub fn raise(&self, priority: u8) -> Result<(), realtime::Refusal> {
        self.threads
            .iter()
            .try_for_each(|thread| raise_thread(thread, priority))
    }

    /// Asks, and waits for the answer.
    ///
    /// # Errors
    /// No answer, a refusal, a line that is gone.
    pub fn ask(&self, request: Request) -> Result<Report, SerialError> {
        let commands = self.commands.as_ref().ok_or(LinkError::Gone)?;
        // An answer that nobody waited for is none of this request.
        while self.answers.try_recv().is_ok() {}
        commands
            .send(Command::Ask(request))
            .map_err(|_| LinkError::Gone)?;
        let answer = self.answers.recv().map_err(|_| LinkError::Gone)?;
        answer.map_err(SerialError::Link)
    }

    /// Sets the whole configuration in one transaction, until it is replaced.
    ///
    /// # Errors
    /// The refusal of the first parameter that is not as the device needs it; nothing has changed then.
    pub fn set(&mut self, configuration: Configuration, values: &[f32]) -> Result<(), SerialError> {
        self.set_for(configuration, values, Scope::Lasting)
    }

    /// Sets the whole configuration in one transaction; for a run, what was set to last comes back with the next
    /// connection.
    ///
    /// # Errors
    /// As [`set`](Self::set); for a run, a limit that is looser than what is set.
    pub fn set_for(
        &mut self,
        configuration: Configuration,
        values: &[f32],
        scope: Scope,
    ) -> Result<(), SerialError> {
        let most = self.capabilities.coefficients_max;
        if values.len() > usize::from(most) {
            let refusal = Refusal::Range {
                field: Field::CoefficientCount,
                value: values.len() as f32,
                least: 1.0,
                most: f32::from(most),
            };
            let request = "configure";
            return Err(LinkError::Refused { request, refusal }.into());
        }
        self.ask(Request::Configure(configuration))?;
        for block in 0..block_count(values.len() as u16) {
            let offset = block * haptic_link::COEFFICIENTS_PER_BLOCK as u16;
            self.ask(Request::Coefficients(CoefficientBlock::of(values, offset)))?;
        }
        let digest = DigestBuilder::new(&configuration).coefficients(values);
        let digest = digest.finish();
        self.ask(Request::Commit { digest, scope })?;
        self.ticks_every(configuration.tick_period_us);
        Ok(())
    }

    /// The configuration in force, with its coefficients.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn configuration(&self) -> Result<(Configuration, Vec<f32>), SerialError> {
        let Report::Configuration { configuration, .. } = self.ask(Request::GetConfiguration)?
        else {
            return Err(LinkError::Gone.into());
        };
        let mut values = Vec::new();
        for block in 0..block_count(configuration.operator.count) {
            let offset = block * haptic_link::COEFFICIENTS_PER_BLOCK as u16;
            if let Report::Coefficients(block) = self.ask(Request::GetCoefficients { offset })? {
                values.extend(block.values);
            }
        }
        values.truncate(usize::from(configuration.operator.count));
        Ok((configuration, values))
    }

    /// The device's counters.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn statistics(&self) -> Result<Statistics, SerialError> {
        match self.ask(Request::GetStatistics)? {
            Report::Statistics(statistics) => Ok(statistics),
            _ => Err(LinkError::Gone.into()),
        }
    }

    /// Sends keep-alives for this time, and returns how long their answers took, µs.
    #[must_use]
    pub fn measure_round_trip(&self, duration: Duration) -> Histogram<u64> {
        self.shared.conversation().set_keep_alive(Some(5_000));
        std::thread::sleep(duration);
        self.shared.conversation().set_keep_alive(None);
        lock(&self.shared.round_trip_us).clone()
    }

    /// Arms, keeping the device company from now on: a keep-alive after each quarter of its watchdog time.
    /// Clears a fault that [`status`](Self::status) knows of.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn arm(&self, watchdog: Duration) -> Result<(), SerialError> {
        let quiet = (watchdog / 4).as_micros() as u64;
        self.shared.conversation().set_keep_alive(Some(quiet));
        let faults = self.status().faults;
        self.ask(Request::Arm { faults }).map(|_| ())
    }

    /// Starts a run.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn start(&mut self, start: Start) -> Result<(), SerialError> {
        self.ask(Request::Start(start))?;
        self.running = Some(self.alives());
        Ok(())
    }

    /// Disarms, and lets the device be quiet.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn disarm(&self) -> Result<(), SerialError> {
        let disarmed = self.ask(Request::Disarm);
        self.shared.conversation().set_keep_alive(None);
        disarmed.map(|_| ())
    }

    /// Asks for a stream of samples outside of runs, and keeps company so that the end of it is noticed.
    ///
    /// # Errors
    /// As [`ask`](Self::ask).
    pub fn stream(&self, every: u16, batch: u8) -> Result<(), SerialError> {
        let quiet = (every > 0).then_some(100_000);
        self.shared.conversation().set_keep_alive(quiet);
        self.ask(Request::Stream { every, batch }).map(|_| ())
    }

    /// The next thing the device says unasked; `None` after the time. The end of a run and a fault are told even if
    /// their own frame was lost: what the device answers to keep-alives says so too.
    pub fn hear(&mut self, patience: Duration) -> Option<Heard> {
        /// A pause in which a missing end is looked for.
        const PAUSE: Duration = Duration::from_millis(50);
        let began = Instant::now();
        loop {
            if let Some(heard) = self.ahead.take() {
                return Some(self.noted(heard));
            }
            let left = patience.saturating_sub(began.elapsed());
            match self.heard.recv_timeout(left.min(PAUSE)) {
                Ok(heard) => return Some(self.noted(heard)),
                Err(RecvTimeoutError::Disconnected) => return Some(Heard::Over(LinkError::Gone)),
                Err(RecvTimeoutError::Timeout) => {}
            }
            if let Some(heard) = self.missed() {
                return Some(heard);
            }
            if began.elapsed() >= patience {
                return None;
            }
        }
    }

    /// Whether something waits to be heard.
    pub fn try_hear(&mut self) -> Option<Heard> {
        if let Some(heard) = self.ahead.take() {
            return Some(self.noted(heard));
        }
        match self.heard.try_recv() {
            Ok(heard) => Some(self.noted(heard)),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Heard::Over(LinkError::Gone)),
        }
    }

    fn alives(&self) -> u64 {
        self.shared.alives.load(Ordering::Acquire)
    }

    /// Follows the run; a status from before what was heard says nothing about its end.
    fn noted(&mut self, heard: Heard) -> Heard {
        let over = match heard {
            Heard::Sample(sample) => {
                self.heard_tick = sample.tick;
                false
            }
            Heard::Event(event) => matches!(
                event.kind,
                EventKind::Finished | EventKind::Stopped | EventKind::Disarmed
            ),
            Heard::Fault(_) | Heard::Over(_) => true,
        };
        self.running = match self.running {
            Some(_) if !over => Some(self.alives()),
            _ => None,
        };
        heard
    }

    /// The end of a run whose frame was lost, from two answers to keep-alives since anything else was heard: the
    /// second was asked for after it.
    fn missed(&mut self) -> Option<Heard> {
        let newest = self.running?;
        if self.alives() < newest + 2 {
            return None;
        }
        // What came meanwhile goes first.
        if let Some(heard) = self.try_hear() {
            return Some(heard);
        }
        let (status, tick) = (self.status(), self.heard_tick);
        let kind = match status.state {
            State::Fault => {
                self.running = None;
                return Some(Heard::Fault(FaultReport {
                    status,
                    tick,
                    time_us: 0,
                }));
            }
            State::Armed => EventKind::Finished,
            State::Idle => EventKind::Disarmed,
            State::Running | State::Stopping => return None,
        };
        self.running = None;
        Some(Heard::Event(Event {
            kind,
            tick,
            time_us: 0,
        }))
    }

    /// Sends a force of a host loop, N. Never waits; without room it is dropped and counted.
    pub fn send_force(&self, tick: u32, force_n: f32) {
        let force = Command::Tell(Request::Force { tick, force_n });
        if let Some(queue) = &self.commands
            && let Err(TrySendError::Full(_)) = queue.try_send(force)
        {
            self.shared.forces_dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// What the device said at the first greeting.
    #[must_use]
    pub const fn hello(&self) -> &Hello {
        &self.hello
    }

    /// What the device is and can do.
    #[must_use]
    pub const fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    /// State and fault, as of the last keep-alive, event or fault.
    #[must_use]
    pub fn status(&self) -> Status {
        *lock(&self.shared.status)
    }

    /// What the device's passivity guard has observed as of the last keep-alive, J; 0 without one.
    #[must_use]
    pub fn observed_energy_j(&self) -> f32 {
        f32::from_bits(self.shared.energy_bits.load(Ordering::Relaxed))
    }

    /// The device's own limiters in the tick that was read last, bits as in a [`Sample`].
    #[must_use]
    pub const fn newest_limiters(&self) -> u8 {
        self.newest_limiters
    }

    /// The speed at which the device answered, bits per second.
    #[must_use]
    pub const fn baud(&self) -> u32 {
        self.baud
    }

    /// The port.
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }

    /// How long the USB adapter holds bytes back, ms, where it says so.
    #[must_use]
    pub const fn latency_ms(&self) -> Option<u32> {
        self.latency_ms
    }

    /// All counters of this end.
    #[must_use]
    pub fn report(&self) -> LinkReport {
        LinkReport {
            host: self.shared.conversation().counters(),
            samples_dropped: self.shared.samples_dropped.load(Ordering::Relaxed),
            forces_dropped: self.shared.forces_dropped.load(Ordering::Relaxed),
            forces_skipped: self.forces_skipped,
            round_trip_us: lock(&self.shared.round_trip_us).clone(),
        }
    }
}

impl Drop for SerialLink {
    fn drop(&mut self) {
        // Best effort: a device that does not hear it trips its own watchdog.
        if !self.shared.over.load(Ordering::Relaxed) {
            let _ = self.disarm();
        }
        self.shared.over.store(true, Ordering::Relaxed);
        self.commands = None;
        for thread in self.threads.drain(..) {
            // A panic in there has been printed; there is nothing left to save.
            let _ = thread.join();
        }
    }
}

/// A host loop: the position comes from the newest sample, the force goes out at once.
///
/// A reading's time is the tick's, n·T. [`read`](Device::read) waits for the next sample, up to 2 s; each
/// sample is read, in order, even when they come faster than they are read. A force is sent only if no newer sample has
/// come meanwhile: whoever has fallen behind computes what it has missed and answers the newest.
impl<F: Real> Device<F, 1> for SerialLink {
    type Error = SerialError;

    fn read(&mut self) -> Result<Reading<F, 1>, SerialError> {
        loop {
            match self.hear(SAMPLE_TIMEOUT) {
                Some(Heard::Sample(sample)) => {
                    self.newest_tick = sample.tick;
                    self.newest_limiters = sample.limiters;
                    return Ok(Reading {
                        tick: u64::from(sample.tick),
                        time_s: f64::from(sample.tick) * self.period_s(),
                        position_m: SVector::from([F::from_f64(f64::from(sample.position_m))]),
                    });
                }
                Some(Heard::Over(error)) => return Err(error.into()),
                Some(Heard::Fault(report)) => return Err(LinkError::Faulted(report).into()),
                Some(Heard::Event(_)) => {}
                None => {
                    let waited_ms = SAMPLE_TIMEOUT.as_millis() as u64;
                    return Err(LinkError::NoSamples { waited_ms }.into());
                }
            }
        }
    }

    fn write(&mut self, force: SafeForce<F, 1>) -> Result<(), SerialError> {
        if self.ahead.is_none() {
            self.ahead = self.try_hear();
        }
        if matches!(self.ahead, Some(Heard::Sample(_))) {
            self.forces_skipped += 1;
            return Ok(());
        }
        self.send_force(self.newest_tick, force.newtons()[0].to_f64() as f32);
        Ok(())
    }
}
