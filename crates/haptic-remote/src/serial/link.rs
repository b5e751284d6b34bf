//! A device that has answered, on an open port: what it is, what both ends have counted, and the two threads that speak.

use super::{
    clock::{DeviceClock, Ping, Pings},
    error::{BoardTrouble, TroubleCause},
    line::{Line, lock},
    served::Served,
    stopping::is_set,
    tcp::tcp_address,
};
use crate::{
    Conversation, HostCounters, Incoming, LinkError, Patience, newtons::ForceFactors,
    plausible::Plausible,
};
use haptic_link::{
    AXES_MAX, Capabilities, DeviceReport, Event, FRAME_MAX, FaultReport, Hello, Request, Sample,
    Status,
};
use haptic_loop::{
    Fault,
    realtime::{self, Durations, Moment, raise_thread},
};
use std::{
    boxed::Box,
    collections::VecDeque,
    io::{Error, ErrorKind},
    string::String,
    sync::{
        Arc, Mutex, MutexGuard, OnceLock,
        atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering},
        mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError},
    },
    thread::JoinHandle,
    time::Duration,
    vec::Vec,
};

/// Counters of this end of a link, and how long answers took.
#[derive(Clone, Debug)]
pub struct LinkReport {
    /// Counters of frames, from the conversation.
    pub host: HostCounters,
    /// Samples that found the queue full.
    pub samples_dropped: u64,
    /// Forces that found the queue full.
    pub forces_dropped: u64,
    /// Forces that were not sent because a newer sample had come already.
    pub forces_skipped: u64,
    /// Time from sending a keep-alive to hearing the answer, µs; empty if none was heard.
    pub round_trip_us: Durations,
}

/// A device that has answered, on an open port.
///
/// ```no_run
/// use haptic_link::{EventKind, Start};
/// use haptic_remote::serial::{ConnectOptions, DeviceMessage, SerialLink};
/// use std::time::Duration;
///
/// let mut link = SerialLink::connect("/dev/ttyACM0", ConnectOptions::default())?;
/// println!("{}", link.capabilities().board());
/// link.arm(Duration::from_millis(100))?;
/// link.start(Start { ticks: 1000, ..Start::ENDLESS })?;
/// while let Some(heard) = link.hear(Duration::from_secs(1)) {
///     match heard {
///         DeviceMessage::Sample(sample) => println!("{:?}", sample.axes),
///         DeviceMessage::Event(event) if event.kind == EventKind::Finished => break,
///         DeviceMessage::Fault(_) | DeviceMessage::Over(_) => break,
///         DeviceMessage::Event(_) => {}
///     }
/// }
/// link.disarm()?;
/// # Ok::<(), haptic_remote::serial::SerialError>(())
/// ```
#[derive(Debug)]
pub struct SerialLink {
    pub(super) shared: Arc<Shared>,
    /// Set by whoever stops what is done with it.
    pub(super) stop: Option<Arc<AtomicBool>>,
    pub(super) commands: Option<SyncSender<Command>>,
    pub(super) answers: Receiver<Result<DeviceReport, LinkError>>,
    pub(super) heard: Receiver<DeviceMessage>,
    pub(super) threads: Vec<JoinHandle<()>>,
    pub(super) hello: Hello,
    pub(super) capabilities: Capabilities,
    /// It knows the messages of controllers.
    pub(super) has_controllers: bool,
    /// It knows the message of surfaces.
    pub(super) has_surfaces: bool,
    /// The motion of the device is known.
    pub(super) knows_robot: bool,
    pub(super) latency_ms: Option<u32>,
    pub(super) path: String,
    /// Heard before its turn, to see whether a newer sample waits.
    pub(super) ahead: Option<DeviceMessage>,
    /// A run that was started and whose end was not heard yet, as of the alive of this number.
    pub(super) running: Option<u64>,
    /// The sample that a host loop read last.
    pub(super) newest: Sample,
    /// Looks at each sample of a run.
    pub(super) plausible: Plausible,
    /// The one that cannot be, which ended the run.
    pub(super) impossible: Option<Sample>,
    /// The bits of the last forces of a host loop, as many as a device lets pass for one in time.
    pub(super) newest_answers: VecDeque<[u32; AXES_MAX]>,
    /// The device had one of them when it made the newest sample.
    pub(super) follows: bool,
    /// Tick of the last sample heard.
    pub(super) heard_tick: u32,
    /// Tick of the first sample of this run that a fault has shaped before its own frame was heard.
    pub(super) fault_tick: Option<u32>,
    pub(super) forces_skipped: u64,
    /// The other end, if this process serves it. Last, so that it is dropped when nothing speaks to it any more.
    pub(super) served: Option<Served>,
}

impl SerialLink {
    /// T of the configuration in force, s.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        f64::from(self.period_us()) * 1e-6
    }

    pub(super) fn period_us(&self) -> u32 {
        self.shared.period_us.load(Ordering::Relaxed)
    }

    pub(super) fn ticks_every(&self, period_us: u32) {
        self.shared.period_us.store(period_us, Ordering::Relaxed);
    }

    /// Has this end speak of true newtons from now on, where the device names its own: forces, laws, limits, samples and abilities. Only the
    /// first factors count.
    pub fn calibrate(&mut self, factors: ForceFactors) {
        if self.shared.factors.set(factors).is_ok() {
            let can = factors.able(self.capabilities);
            self.plausible = Plausible::of(can.force_max_n, can.sensed_force_max_n, can.simulated);
            self.capabilities = can;
        }
    }

    /// The motion of a device that moves is known, and judged: it may be [armed](Self::arm).
    pub const fn knows_robot(&mut self) {
        self.knows_robot = true;
    }

    /// Raises the threads that read and write to a real-time priority, so that keep-alives are sent on a busy machine.
    ///
    /// # Errors
    /// The system does not allow the priority. If this is refused, the thread keeps its
    /// priority.
    pub fn raise(&self, priority: u8) -> Result<(), realtime::SystemRefusal> {
        self.threads
            .iter()
            .chain(self.served.iter().filter_map(Served::thread))
            .try_for_each(|thread| raise_thread(thread, priority))
    }

    /// Its clock by that of this machine, as it becomes known; for any thread.
    #[must_use]
    pub fn clock(&self) -> Arc<dyn Fn() -> Option<DeviceClock> + Send + Sync> {
        let shared = Arc::clone(&self.shared);
        Arc::new(move || lock(&shared.pings).clock(shared.began))
    }

    /// True for a device that this process [serves](Served): its board has no watchdog that hears this link.
    #[must_use]
    pub const fn is_served(&self) -> bool {
        self.served.is_some()
    }

    /// Words of a served device about its last fault: a code says less than the board that failed knows.
    #[must_use]
    pub fn trouble(&self) -> Option<BoardTrouble> {
        self.served.as_ref().and_then(Served::trouble)
    }

    /// Words of a served device whose board fell silent. Its own line, to the thread that serves it, still works.
    #[must_use]
    pub fn lost_board(&self) -> Option<String> {
        if self.status().fault != Fault::BoardFailed.code() {
            return None;
        }
        let lost = (self.trouble()).filter(|trouble| trouble.cause == TroubleCause::Gone)?;
        Some(lost.words)
    }

    /// Answer of the device to the first greeting.
    #[must_use]
    pub const fn hello(&self) -> &Hello {
        &self.hello
    }

    /// Name and abilities of the device.
    #[must_use]
    pub const fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    /// State and fault, as of the last keep-alive, event or fault.
    #[must_use]
    pub fn status(&self) -> Status {
        *lock(&self.shared.status)
    }

    /// The sample that a host loop read last; one without axes before the first.
    #[must_use]
    pub const fn newest(&self) -> &Sample {
        &self.newest
    }

    /// The sample that cannot be, with its flaw, if there was one.
    #[must_use]
    pub const fn impossible(&self) -> Option<&Sample> {
        self.impossible.as_ref()
    }

    /// True if the device had received one of the last ten forces of a host loop
    /// ([`max_age_ticks`](haptic_link::Limits::max_age_ticks)) when it made the newest sample;
    /// otherwise it kept using an older one.
    #[must_use]
    pub const fn follows(&self) -> bool {
        self.follows
    }

    /// Tick of the first sample of this run that a fault affected although the frame reporting the
    /// fault, due before the sample, was lost. `None` in any other run.
    #[must_use]
    pub const fn fault_tick(&self) -> Option<u32> {
        self.fault_tick
    }

    /// The device, as on the command line.
    #[must_use]
    pub fn name(&self) -> String {
        if self.served.is_some() || tcp_address(&self.path).is_some() {
            self.path.clone()
        } else {
            std::format!("serial:{}", self.path)
        }
    }

    /// The port, or the name of a device that this process serves.
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Time for which the USB adapter delays bytes, ms; `None` if unknown.
    #[must_use]
    pub const fn latency_ms(&self) -> Option<u32> {
        self.latency_ms
    }

    /// Keep-alives that were answered so far.
    #[must_use]
    pub fn alives(&self) -> u64 {
        self.shared.alives.load(Ordering::Acquire)
    }

    /// Patience with this device from now on: only the reader's listening time counts, so that a caller that was held up does not take it for silent.
    #[must_use]
    pub fn patience(&self, most: Duration) -> Patience {
        Patience::since(most, self.shared.listened())
    }

    /// True if this patience is over though all that had come by then was heard. Another thread listens: its time is read before the
    /// queue is. A queue that never empties has brought what was in it after as many looks.
    pub fn is_silent(&mut self, patience: &mut Patience) -> bool {
        if !self.is_over(patience) {
            return false;
        }
        if self.ahead.is_none() {
            self.ahead = self.heard.try_recv().ok();
        }
        self.ahead.is_none() || patience.looks_when_over() > HEARD_MOST
    }

    /// No answer of the device is waited for any more, and nothing feeds its watchdog; orders still go out.
    pub fn give_up(&self) {
        self.shared.deaf.store(true, Ordering::Relaxed);
        self.shared.conversation().set_keep_alive(None);
    }

    /// True once somebody stops what is done with this device.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        is_set(self.stop.as_ref())
    }

    /// True if this patience is over, or the reader has ended.
    pub(super) fn is_over(&self, patience: &mut Patience) -> bool {
        patience.listened_for(self.shared.listened());
        patience.is_over() || self.shared.over.load(Ordering::Relaxed)
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
            let mute = self.shared.mute.load(Ordering::Relaxed);
            let most = if mute { STOPPED } else { Duration::MAX };
            self.shared.conversation().set_keep_alive(None);
            let _ = self.ask_for(Request::Disarm, most);
        }
        self.commands = None;
        // The writer, which first sends what it was given, ends before the reader.
        while let Some(thread) = self.threads.pop() {
            // A panic in there has been printed; there is nothing left to save.
            let _ = thread.join();
            self.shared.over.store(true, Ordering::Relaxed);
        }
    }
}

/// Message that a device sends unasked.
#[derive(Clone, Debug, PartialEq)]
pub enum DeviceMessage {
    /// A tick of the device, in its order.
    Sample(Sample),
    /// The state of the device has changed.
    Event(Event),
    /// A fault has latched, or its frame was lost and it shows in a keep-alive.
    Fault(FaultReport),
    /// The session is over, and nothing follows.
    Over(LinkError),
}

#[derive(Debug)]
pub(super) enum Command {
    Ask(Request),
    Tell(Request),
}

#[derive(Debug)]
pub(super) struct Shared {
    pub conversation: Mutex<Conversation>,
    pub began: Moment,
    pub over: AtomicBool,
    /// Time for which the reader has listened, µs.
    pub listened_us: AtomicU64,
    /// It did not answer after a silence: it still gets orders, but no answer is waited for.
    pub deaf: AtomicBool,
    /// The last request had no answer in all its tries.
    pub mute: AtomicBool,
    /// Factors of a device that was calibrated.
    pub factors: OnceLock<ForceFactors>,
    pub samples_dropped: AtomicU64,
    pub forces_dropped: AtomicU64,
    pub round_trip_us: Mutex<Durations>,
    pub pings: Mutex<Pings>,
    pub status: Mutex<Status>,
    /// Answers to keep-alives so far: each brings the status of its moment.
    pub alives: AtomicU64,
    /// Faults of the device when it was armed last; more than there can be before.
    pub armed_after: AtomicU32,
    /// Armed since, and not started: a fault now has ended what was about to run.
    pub armed_anew: AtomicBool,
    pub period_us: AtomicU32,
}

impl Shared {
    pub(super) fn now_us(&self) -> u64 {
        self.began.elapsed().as_micros() as u64
    }

    /// The device's own newtons, unless it was calibrated.
    pub(super) fn newtons(&self) -> &ForceFactors {
        self.factors.get().unwrap_or(&ForceFactors::OWN)
    }

    pub(super) fn conversation(&self) -> MutexGuard<'_, Conversation> {
        lock(&self.conversation)
    }

    /// Time for which the reader has listened. No lock: the loop of a host asks at each tick.
    pub(super) fn listened(&self) -> Duration {
        Duration::from_micros(self.listened_us.load(Ordering::Acquire))
    }
}

#[derive(Clone)]
pub(super) struct Ends {
    pub shared: Arc<Shared>,
    pub answers: SyncSender<Result<DeviceReport, LinkError>>,
    pub heard: SyncSender<DeviceMessage>,
}

impl Ends {
    pub(super) fn listen(self, mut port: Box<dyn Line>) {
        // A line that keeps its own patience is heard all the same.
        let _ = port.set_patience(LISTENS);
        let (mut bytes, mut returned) = ([0; 1024], port.now());
        while !self.shared.over.load(Ordering::Relaxed) {
            let count = match port.read(&mut bytes) {
                Ok(0) => return self.end(LinkError::Gone),
                Ok(count) => count,
                Err(error) if is_nothing(&error) => 0,
                Err(_) => return self.end(LinkError::Gone),
            };
            let (now, now_us) = (port.now(), self.shared.now_us());
            let took = now.saturating_duration_since(core::mem::replace(&mut returned, now));
            for &byte in &bytes[..count] {
                let incoming = self.shared.conversation().receive(byte, now_us);
                if let Some(incoming) = incoming {
                    self.pass_on(incoming);
                }
            }
            let mut conversation = self.shared.conversation();
            conversation.waited(RETURNS, took);
            let listened_us = conversation.listened().listened().as_micros() as u64;
            drop(conversation);
            // Behind what came: whoever reads this count finds it in the queue.
            self.shared
                .listened_us
                .store(listened_us, Ordering::Release);
        }
    }

    fn pass_on(&self, incoming: Incoming) {
        match incoming {
            // Nobody waits when the queue is full.
            Incoming::Answer(report) => {
                let _ = self.answers.try_send(Ok(report));
            }
            Incoming::Refused { request, refusal } => {
                let refused = LinkError::Refused { request, refusal };
                let _ = self.answers.try_send(Err(refused));
            }
            Incoming::Alive {
                sent_us,
                round_trip_us,
                device_us,
                newest,
                status,
                ..
            } => {
                lock(&self.shared.round_trip_us).record(round_trip_us);
                lock(&self.shared.pings).add(Ping {
                    sent_us,
                    heard_us: sent_us + round_trip_us,
                    device_us,
                });
                if !newest {
                    return;
                }
                *lock(&self.shared.status) = status;
                self.shared.alives.fetch_add(1, Ordering::Release);
            }
            Incoming::Rebooted => self.end(LinkError::Rebooted),
            Incoming::Begun(report) => {
                self.pass_on(Incoming::Report(report.clone()));
                let _ = self.answers.try_send(Ok(report));
            }
            Incoming::Report(DeviceReport::Sample(sample)) => {
                self.hear(DeviceMessage::Sample(sample));
            }
            Incoming::Report(DeviceReport::Batch(batch)) => {
                for sample in batch.samples(self.shared.period_us.load(Ordering::Relaxed)) {
                    self.hear(DeviceMessage::Sample(sample));
                }
            }
            Incoming::Report(DeviceReport::Event(event)) => self.hear(DeviceMessage::Event(event)),
            Incoming::Report(DeviceReport::Fault(report)) => {
                *lock(&self.shared.status) = report.status;
                self.hear(DeviceMessage::Fault(report));
            }
            // Late answers to requests that were given up.
            Incoming::Report(_) => {}
        }
    }

    fn hear(&self, heard: DeviceMessage) {
        let heard = match heard {
            DeviceMessage::Sample(sample) => {
                DeviceMessage::Sample(self.shared.newtons().read(sample))
            }
            DeviceMessage::Event(_) | DeviceMessage::Fault(_) | DeviceMessage::Over(_) => heard,
        };
        if let Err(TrySendError::Full(_)) = self.heard.try_send(heard) {
            self.shared.samples_dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Tells everybody that the session is over; the first reason counts.
    fn end(&self, error: LinkError) {
        if !self.shared.over.swap(true, Ordering::Relaxed) {
            let _ = self.heard.try_send(DeviceMessage::Over(error));
            let _ = self.answers.try_send(Err(error));
        }
    }

    pub(super) fn speak(self, mut port: Box<dyn Line>, commands: &Receiver<Command>) {
        const IDLE: Duration = Duration::from_millis(50);
        let mut line = [0; FRAME_MAX];
        let mut broken = false;
        while !broken {
            let now_us = self.shared.now_us();
            let due = self.shared.conversation().next_due_us(now_us);
            let wait = due.map_or(IDLE, |due| {
                Duration::from_micros(due.saturating_sub(now_us))
            });
            let command = commands.recv_timeout(wait.min(IDLE));
            let now_us = self.shared.now_us();
            let length = match command {
                Ok(Command::Ask(request)) => {
                    self.shared.conversation().ask(request, now_us, &mut line)
                }
                Ok(Command::Tell(request)) => self.shared.conversation().tell(&request, &mut line),
                Err(RecvTimeoutError::Timeout) => 0,
                Err(RecvTimeoutError::Disconnected) => return,
            };
            broken = length > 0 && !write(port.as_mut(), &line[..length]);
            if broken || self.shared.over.load(Ordering::Relaxed) {
                break;
            }
            let due = self.shared.conversation().due(now_us, &mut line);
            match due {
                Ok(0) => {}
                Ok(length) => broken = !write(port.as_mut(), &line[..length]),
                Err(error) => {
                    let _ = self.answers.try_send(Err(error));
                }
            }
        }
        self.end(LinkError::Gone);
        // The last request may have been taken but not sent.
        let _ = self.answers.try_send(Err(LinkError::Gone));
        // Later requests must be answered too: the reader has ended.
        while let Ok(command) = commands.recv() {
            if let Command::Ask(_) = command {
                let _ = self.answers.try_send(Err(LinkError::Gone));
            }
        }
    }
}

/// Samples and notices that wait for whoever runs the experiment at most: a minute at 1 kHz.
pub(super) const HEARD_MOST: usize = 1 << 16;

/// One that is to let go is given up after this time without a sign.
pub(super) const STOPPED: Duration = Duration::from_millis(200);

/// Longest wait of a read of the device.
pub(super) const LISTENS: Duration = Duration::from_millis(20);

/// A thread that is run in time is back by then: the timers of sockets go in steps of up to 10 ms.
pub(super) const RETURNS: Duration = Duration::from_millis(30);

/// A line that takes nothing for this long is gone.
const TAKES_NOTHING: Duration = Duration::from_secs(1);

/// A read in which nothing came.
pub(super) fn is_nothing(error: &Error) -> bool {
    matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted)
}

/// Writes it all, and says whether the line took it: a slow line is waited for, one that takes nothing for a second
/// is gone.
pub(super) fn write(port: &mut dyn Line, mut bytes: &[u8]) -> bool {
    let mut patience = Patience::new(TAKES_NOTHING);
    while !bytes.is_empty() {
        let began = Moment::now();
        match port.write(bytes) {
            Ok(0) => return false,
            Ok(count) => {
                bytes = &bytes[count..];
                patience.heard();
            }
            Err(error) => {
                patience.waited(RETURNS, began.elapsed());
                let busy = is_nothing(&error) || error.kind() == ErrorKind::WouldBlock;
                if !busy || patience.is_over() {
                    return false;
                }
            }
        }
    }
    true
}
