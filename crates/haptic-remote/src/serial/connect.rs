//! Connecting: the port is opened, the device greeted and brought to rest, two threads are started.

use super::{
    error::{SerialError, WAITING},
    line::Line,
    link::{Ends, HEARD_MOST, LISTENS, RETURNS, STOPPED, SerialLink, Shared, is_nothing, write},
    port,
    run::IN_TIME,
    served::Served,
    stopping::{is_set, sleep, spawn, unless_stopped},
};
use crate::{
    Conversation, Incoming, LinkError, Patience, abilities, check_keys, plausible::Plausible,
};
use haptic_link::{Capabilities, DeviceReport, FRAME_MAX, Hello, Request, Sample, State, Status};
use haptic_loop::realtime::Moment;
use std::{
    boxed::Box,
    collections::{VecDeque, hash_map::RandomState},
    hash::{BuildHasher as _, Hasher as _},
    string::ToString,
    sync::{
        Arc, Mutex, OnceLock,
        atomic::{AtomicBool, AtomicU32, AtomicU64},
        mpsc::sync_channel,
    },
    time::Duration,
    vec::Vec,
};

/// Requests and forces that wait for the port at most.
const COMMANDS_MOST: usize = 256;
/// An unanswered request is sent again after this time.
const RETRY: Duration = Duration::from_millis(150);

/// Options of a connection. By default [`BAUDS`], one attempt.
#[derive(Clone, Copy, Debug, Default)]
pub struct ConnectOptions<'a> {
    /// Bits per second; `None` tries each of [`BAUDS`].
    pub baud: Option<u32>,
    /// Time for further attempts at a port that is not there or does not answer.
    pub patience: Duration,
    /// Setting this flag ends the attempts, and later each wait for an answer.
    pub stop: Option<&'a Arc<AtomicBool>>,
}

impl SerialLink {
    /// Opens the port, greets the device, brings it to rest and reads its capabilities. Tries again
    /// with growing pauses, 50 ms to 1 s, until the patience is over or `stop` is set.
    ///
    /// # Errors
    /// A port that is not there, is in use or may not be opened; no answer, garbage, an echo, another protocol
    /// version.
    pub fn connect(path: &str, options: ConnectOptions<'_>) -> Result<Self, SerialError> {
        let mut patience = Patience::new(options.patience);
        let mut pause = Duration::from_millis(50);
        loop {
            let began = Moment::now();
            let error = match Self::connect_once(path, options.baud, options.stop) {
                Ok(link) => return Ok(link),
                Err(error) => error,
            };
            patience.waited(GREETING, began.elapsed());
            let over = pause > patience.left();
            if over || error.is_hopeless() || !sleep(pause, options.stop) {
                return Err(error);
            }
            patience.waited(pause, pause);
            pause = (2 * pause).min(Duration::from_secs(1));
        }
    }

    fn connect_once(
        path: &str,
        baud: Option<u32>,
        stop: Option<&Arc<AtomicBool>>,
    ) -> Result<Self, SerialError> {
        let latency_ms = port::shorten_latency(path);
        let bauds = baud.as_ref().map_or(&BAUDS[..], std::slice::from_ref);
        let (opened, speed) = (path.to_string(), bauds[0]);
        let port = unless_stopped(stop, move || port::open(&opened, speed))??;
        let mut link = Self::over(port, bauds, path, stop)?;
        link.latency_ms = latency_ms;
        Ok(link)
    }

    /// Connects to a device that this process serves itself. It is kept while the link lives, and
    /// released with it.
    ///
    /// # Errors
    /// As [`connect`](Self::connect).
    pub fn to_served(served: Served, name: &str) -> Result<Self, SerialError> {
        let mut link = Self::to_line(Box::new(served.line()), name, None)?;
        link.served = Some(served);
        Ok(link)
    }

    /// Lets `stop` end each wait for an answer, from now on.
    #[must_use]
    pub fn stopped_by(mut self, stop: Option<&Arc<AtomicBool>>) -> Self {
        self.stop = stop.cloned();
        self
    }

    /// Connects to whoever is at the other end of a line that is open already, once, unless `stop` is set meanwhile.
    ///
    /// # Errors
    /// As [`connect`](Self::connect).
    pub fn to_line(
        line: Box<dyn Line>,
        name: &str,
        stop: Option<&Arc<AtomicBool>>,
    ) -> Result<Self, SerialError> {
        Self::over(line, &BAUDS[..1], name, stop)
    }

    /// Greets whoever is at the other end of a line.
    fn over(
        line: Box<dyn Line>,
        bauds: &[u32],
        path: &str,
        stop: Option<&Arc<AtomicBool>>,
    ) -> Result<Self, SerialError> {
        let mut port = line;
        let mut conversation = Conversation::new(RETRY.as_micros() as u64).by_listening();
        let mut received = Vec::new();
        let greeted = greet(port.as_mut(), &mut conversation, bauds, &mut received, stop);
        let (hello, baud) = greeted.map_err(|error| port::unanswered(path, &received, error))?;
        let reading = port.share().map_err(|error| SerialError::Open {
            path: path.to_string(),
            baud,
            reason: error.to_string(),
        })?;
        let shared = Arc::new(shared(conversation, hello.status)?);
        let (commands, to_send) = sync_channel(COMMANDS_MOST);
        let (answered, answers) = sync_channel(8);
        let (hear, heard) = sync_channel(HEARD_MOST);
        let reader = Ends {
            shared: Arc::clone(&shared),
            answers: answered,
            heard: hear,
        };
        let writer = reader.clone();
        let threads = [
            spawn("link-reader", move || reader.listen(reading))?,
            spawn("link-writer", move || writer.speak(port, &to_send))?,
        ];
        let mut link = Self {
            shared,
            stop: stop.cloned(),
            commands: Some(commands),
            answers,
            heard,
            threads: threads.into(),
            hello,
            // It has not said yet what it can do.
            capabilities: abilities("", 0),
            has_controllers: false,
            has_surfaces: false,
            knows_robot: false,
            latency_ms: None,
            path: path.to_string(),
            ahead: None,
            running: None,
            newest: Sample::default(),
            plausible: Plausible::of(f32::MAX, 0.0, true),
            impossible: None,
            newest_answers: VecDeque::with_capacity(IN_TIME),
            follows: true,
            heard_tick: 0,
            fault_tick: None,
            forces_skipped: 0,
            served: None,
        };
        link.introduce()?;
        Ok(link)
    }

    fn introduce(&mut self) -> Result<(), SerialError> {
        let DeviceReport::Keys(keys) = self.ask(Request::GetKeys)? else {
            return Err(LinkError::Gone.into());
        };
        check_keys(&keys, 1, self.hello.firmware)?;
        self.has_controllers = keys.has_controllers();
        self.has_surfaces = keys.has_surfaces();
        // Somebody may have left it running.
        if !matches!(self.hello.status.state, State::Idle | State::Fault) {
            self.ask(Request::Disarm)?;
            self.wait_for_rest();
        }
        if let DeviceReport::Capabilities(capabilities) = self.ask(Request::GetCapabilities)? {
            self.capabilities = capabilities;
        }
        check_numbers(&self.capabilities)?;
        let can = &self.capabilities;
        self.plausible = Plausible::of(can.force_max_n, can.sensed_force_max_n, can.simulated);
        check_keys(&keys, self.capabilities.axes, self.hello.firmware)?;
        let (configuration, _) = self.configuration()?;
        self.ticks_every(configuration.tick_period_us);
        // Old samples and notices do not belong to this session.
        self.heard.try_iter().take(HEARD_MOST).for_each(drop);
        Ok(())
    }

    /// Waits for the force to fall to zero after the device was ordered to let go; returns whether
    /// it did.
    pub fn wait_for_rest(&self) -> bool {
        /// Longer than a force takes to fall.
        const PATIENCE: Duration = Duration::from_secs(2);
        let mut patience = self.patience(PATIENCE);
        let resting = || matches!(self.status().state, State::Idle | State::Fault);
        // The last status is from before the request.
        loop {
            let silent = self.shared.conversation().listened().silent();
            let is_over = self.is_over(&mut patience) || self.is_stopped() && silent >= STOPPED;
            drop(self.measure_round_trip(Duration::from_millis(20)));
            if resting() || is_over {
                return resting();
            }
        }
    }
}

/// Refuses abilities that are no numbers: nothing could be judged by them.
fn check_numbers(capabilities: &Capabilities) -> Result<(), LinkError> {
    let Capabilities {
        force_max_n,
        force_rate_max_n_per_s,
        position_resolution_m,
        sensed_force_max_n,
        ..
    } = *capabilities;
    for (what, value, least) in [
        ("largest force, N,", force_max_n, f32::MIN_POSITIVE),
        (
            "largest force rate, N/s,",
            force_rate_max_n_per_s,
            f32::MIN_POSITIVE,
        ),
        // 0 if it is unknown.
        ("resolution of positions, m,", position_resolution_m, 0.0),
        // 0 without a force sensor.
        ("range of the force sensor, N,", sensed_force_max_n, 0.0),
    ] {
        if !(least..=f32::MAX).contains(&value) {
            return Err(LinkError::Capability { what, value });
        }
    }
    Ok(())
}

fn shared(conversation: Conversation, status: Status) -> Result<Shared, SerialError> {
    let listened_us = conversation.listened().listened().as_micros() as u64;
    Ok(Shared {
        conversation: Mutex::new(conversation),
        began: Moment::now(),
        over: AtomicBool::new(false),
        listened_us: AtomicU64::new(listened_us),
        deaf: AtomicBool::new(false),
        mute: AtomicBool::new(false),
        factors: OnceLock::new(),
        samples_dropped: AtomicU64::new(0),
        forces_dropped: AtomicU64::new(0),
        round_trip_us: Mutex::default(),
        pings: Mutex::default(),
        status: Mutex::new(status),
        alives: AtomicU64::new(0),
        armed_after: AtomicU32::new(u32::MAX),
        armed_anew: AtomicBool::new(false),
        period_us: AtomicU32::new(1000),
    })
}

/// Speeds that boards have, bits per second; the first is for a device without a board.
pub const BAUDS: [u32; 2] = [460_800, 921_600];

/// Time to greet a port: three turns at each speed. After it without an answer, no device is there.
pub const GREETING: Duration = Duration::from_millis(2100);

/// Bytes of a stranger's answer that are kept.
const SAID_MOST: usize = 120;

/// Time to try one speed before the next.
const TURN: Duration = Duration::from_millis(350);

/// Greets until somebody answers, or `stop` is set; the first answer, and the speed at which it came. Somebody else may have `said`
/// something.
fn greet(
    port: &mut dyn Line,
    conversation: &mut Conversation,
    bauds: &[u32],
    received: &mut Vec<u8>,
    stop: Option<&Arc<AtomicBool>>,
) -> Result<(Hello, u32), SerialError> {
    // A line that keeps its own patience is heard all the same.
    let _ = port.set_patience(LISTENS);
    let nonce = RandomState::new().build_hasher().finish() as u32;
    for &baud in bauds.iter().cycle() {
        if conversation.listened().listened() >= GREETING || is_set(stop) {
            break;
        }
        // A port without speeds, as a pseudo-terminal may be, has the only one.
        port.set_baud_rate(baud);
        if let Some(hello) = take_turn(port, conversation, nonce, received, stop)? {
            return Ok((hello, baud));
        }
    }
    // By what came in any of the turns: in the last a busy machine may have had no time to listen.
    Err(conversation.no_answer().into())
}

/// One turn at the speed that is set: the answer, if there was one.
fn take_turn(
    port: &mut dyn Line,
    conversation: &mut Conversation,
    nonce: u32,
    received: &mut Vec<u8>,
    stop: Option<&Arc<AtomicBool>>,
) -> Result<Option<Hello>, LinkError> {
    let began = Moment::now();
    let now_us = |began: Moment| began.elapsed().as_micros() as u64;
    let mut line = [0; FRAME_MAX];
    // A zero ends what somebody else has begun, or what was sent at another speed.
    let length = conversation.ask(Request::Hello { nonce }, now_us(began), &mut line[1..]);
    send(port, &line[..=length])?;
    let (mut bytes, mut returned) = ([0; 1024], port.now());
    let mut patience = Patience::new(TURN);
    while !patience.is_over() && !is_set(stop) {
        let count = match port.read(&mut bytes) {
            Ok(0) => return Err(LinkError::Gone),
            Ok(count) => count,
            Err(error) if is_nothing(&error) => 0,
            Err(_) => return Err(LinkError::Gone),
        };
        let now = port.now();
        let took = now.saturating_duration_since(core::mem::replace(&mut returned, now));
        let room = SAID_MOST - received.len();
        received.extend_from_slice(&bytes[..count.min(room)]);
        for &byte in &bytes[..count] {
            if let Some(Incoming::Answer(DeviceReport::Hello(hello))) =
                conversation.receive(byte, now_us(began))
            {
                return Ok(Some(hello));
            }
        }
        patience.waited(RETURNS, took);
        conversation.waited(RETURNS, took);
        let length = conversation.due(now_us(began), &mut line)?;
        send(port, &line[..length])?;
    }
    // It is there, and cannot answer: nothing changes by asking on.
    if received.starts_with(WAITING.as_bytes()) {
        return Err(LinkError::Gone);
    }
    Ok(None)
}

fn send(port: &mut dyn Line, bytes: &[u8]) -> Result<(), LinkError> {
    if write(port, bytes) {
        Ok(())
    } else {
        Err(LinkError::Gone)
    }
}
