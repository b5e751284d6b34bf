//! A device without hardware: its side of the link behind a pseudo-terminal or a TCP address.
//!
//! ```text
//! serial port of a host ─▶ reader thread ─▶ faulty line ─▶ DeviceSession, TickSide ─▶ faulty line ─▶ writer thread
//! ```
//! The same state machine as in the firmware, ticked by the clock, or by a faster or slower one. When this
//! machine is too busy to tick in time the device's clock waits, as if everything on it had been slower:
//! an emulated device never reports faults that it would not have. Two boards whose masses meet share that clock and one thread.

mod error;
mod facing;
mod moving;
mod port;
mod pressing;
mod scripted;
#[cfg(unix)]
mod terminal;
#[cfg(test)]
mod tests;

pub use error::EmulatorError;
pub use facing::emulate_facing;
pub use moving::EmulatedRobot;
use moving::MovingBoard;
pub use port::{BoardPort, PortKind};
pub use pressing::AtHandle;
use pressing::PressingBoard;
pub use scripted::HandScript;
#[cfg(unix)]
pub use terminal::Terminal;

use crate::{DuplexDamage, FaultyLine, LineFaults, at_line::NOBODY};
use haptic_link::{Capabilities, ControllerCost, FRAME_MAX, Refusal};
use haptic_loop::{
    Device, Fault, Reading, SafeForce,
    plant::{ForceSensor, ForceSensorConfig, MassDamperConfig, Sensed},
    realtime::Moment,
    units::{Metres, Seconds},
};
use haptic_remote::{
    DeviceSession, FitsDevice, Hardware, SimulatedAxes, SimulatedPlant, TickSide,
    serial::{HeldClock, Line},
};
use std::{
    cell::{Cell, RefCell},
    io::ErrorKind,
    rc::Rc,
    sync::{
        atomic::{AtomicBool, Ordering},
        mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel},
    },
    time::Duration,
};

/// Pieces of bytes that wait between the threads at most.
const WAITING_MOST: usize = 4096;

/// Settings of an emulated device.
///
/// ```no_run
/// use haptic_emulator::LineFaults;
/// use haptic_emulator::board::{Emulation, BoardPort, PortKind, emulate};
/// use std::sync::atomic::AtomicBool;
///
/// let port = BoardPort::open(PortKind::Address, Some("127.0.0.1:4250".as_ref()))?;
/// println!("a device is at {}", port.path());
/// let emulation = Emulation {
///     axes: 1,
///     body: None,
///     sensor: None,
///     at_handle: None,
///     robot: None,
///     speed: 1.0,
///     faults: LineFaults { drop: 0.01, ..LineFaults::default() },
///     seed: 1,
///     duration: None,
/// };
/// // Until somebody sets the flag.
/// let stop = AtomicBool::new(false);
/// let done = emulate(port.line()?, &emulation, &stop)?;
/// println!("{} ticks", done.ticks);
/// # Ok::<(), haptic_emulator::board::EmulatorError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Emulation {
    /// Axes of the device, 1 to 3.
    pub axes: u8,
    /// The device that it is; `None` for an ideal one, of the mass and damping that a host asks for.
    pub body: Option<Body>,
    /// Its force sensor, if it has one.
    pub sensor: Option<ForceSensorConfig>,
    /// The specimen or the hand at its handle, if there is one; of one axis, and not of boards that face each other.
    pub at_handle: Option<AtHandle>,
    /// A robot that moves in the place of all of these.
    pub robot: Option<EmulatedRobot>,
    /// Device seconds per second of the clock: 1 in real time.
    pub speed: f64,
    /// Faults of the line, both ways.
    pub faults: LineFaults,
    /// Seed of the faults: the same gives the same faults for the same frames.
    pub seed: u64,
    /// Time for which it runs; `None` until stopped.
    pub duration: Option<Duration>,
}

/// Counts of an emulated device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Emulated {
    /// Ticks of the device, by its own clock.
    pub ticks: u64,
    /// Frames both ways, and what the line did to them.
    pub damage: DuplexDamage,
    /// Frames dropped because the queue to the host was full.
    pub unread: u64,
}

/// Runs the device until it is stopped or its time is over.
///
/// # Errors
/// Axes, faults or a body outside their range; a line that cannot be shared.
pub fn emulate(
    line: Box<dyn Line>,
    emulation: &Emulation,
    stop: &AtomicBool,
) -> Result<Emulated, EmulatorError> {
    const NAME: &str = "emulated";
    if let Some(robot) = &emulation.robot {
        let board = MovingBoard::new(NAME, robot)?;
        let [done] = run([(line, emulation, board)], &TickTime::default(), stop)?;
        return Ok(done);
    }
    match (emulation.axes, &emulation.at_handle) {
        (1, Some(there)) => emulate_board(line, emulation, PressingBoard::new(NAME, there)?, stop),
        (axes, Some(_)) => Err(EmulatorError::AtHandle(axes)),
        (1, None) => emulate_board(line, emulation, SimulatedPlant::new(NAME, || 0), stop),
        (2, None) => emulate_board(line, emulation, SimulatedAxes::<2>::new(NAME), stop),
        (3, None) => emulate_board(line, emulation, SimulatedAxes::<3>::new(NAME), stop),
        (axes, None) => Err(EmulatorError::Axes(axes)),
    }
}

fn emulate_board<H: Touched<D> + Hardware<D, Setup: FitsDevice>, const D: usize>(
    line: Box<dyn Line>,
    emulation: &Emulation,
    board: H,
    stop: &AtomicBool,
) -> Result<Emulated, EmulatorError> {
    // A plant of its own moves from tick to tick.
    let board = Embodied::new(board, emulation.body, emulation.sensor)?;
    let [done] = run([(line, emulation, board)], &TickTime::default(), stop)?;
    Ok(done)
}

/// Device time of the present tick, µs, for what is around the boards.
type TickTime = Rc<Cell<u64>>;

/// Boards that share a clock: speed and duration are those of the first.
fn run<H: Hardware<D>, const D: usize, const N: usize>(
    boards: [(Box<dyn Line>, &Emulation, H); N],
    now: &TickTime,
    stop: &AtomicBool,
) -> Result<[Emulated; N], EmulatorError> {
    let over = AtomicBool::new(false);
    let over = &over;
    std::thread::scope(|scope| {
        // Made in here, so that its ends of the queues are gone before the threads are waited for.
        let (arrived, arriving) = sync_channel::<(usize, Vec<u8>)>(WAITING_MOST);
        let mut emulator = Emulator {
            boards: Vec::new(),
            arriving,
            clock: HeldClock::new(Moment::now, boards[0].1.speed),
            speed: boards[0].1.speed,
        };
        let duration = boards[0].1.duration;
        let mut lines = Vec::new();
        for (line, emulation, board) in boards {
            let reading = line.share();
            let reading = reading.map_err(|error| EmulatorError::Terminal(error.to_string()))?;
            let (leave, leaving) = sync_channel::<Vec<u8>>(WAITING_MOST);
            (emulator.boards).push(EmulatedBoard::new(board, emulation, leave)?);
            lines.push((reading, line, leaving));
        }
        for (index, (reading, line, leaving)) in lines.into_iter().enumerate() {
            let arrived = arrived.clone();
            scope.spawn(move || read(reading, |bytes| arrived.send((index, bytes)).is_ok(), over));
            scope.spawn(move || write_all(line, &leaving, over));
        }
        drop(arrived);
        let goes_on = |emulator: &Emulator<H, D>| {
            !stop.load(Ordering::Relaxed)
                && duration.is_none_or(|most| emulator.clock.elapsed() < most)
        };
        while goes_on(&emulator) && emulator.round(now) {}
        over.store(true, Ordering::Relaxed);
        Ok(std::array::from_fn(|index| emulator.boards[index].counts()))
    })
}

struct Emulator<H: Hardware<D>, const D: usize> {
    boards: Vec<EmulatedBoard<H, D>>,
    /// Bytes that arrived, with the index of their board.
    arriving: Receiver<(usize, Vec<u8>)>,
    clock: HeldClock,
    speed: f64,
}

impl<H: Hardware<D>, const D: usize> Emulator<H, D> {
    /// Waits for bytes or the next tick, and works on what came. False when the ports are gone.
    fn round(&mut self, now: &TickTime) -> bool {
        let ticks = self.boards.iter().map(EmulatedBoard::next_us).enumerate();
        // Of two at the same time the first.
        let Some((next, next_us)) = ticks.min_by_key(|(_, next_us)| *next_us) else {
            return false;
        };
        let first = match self.arriving.recv_timeout(self.clock.until(next_us)) {
            Ok(first) => Some(first),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return false,
        };
        // Before anything is put on a line: a frame of the time that is taken back would hold up all that follow it.
        self.clock.catch_up(next_us);
        let now_us = self.clock.now_us();
        for (index, bytes) in first.into_iter().chain(self.arriving.try_iter()) {
            self.boards[index].take(bytes, now_us);
        }
        for board in &mut self.boards {
            board.hear(now_us);
        }
        // A request may have changed its period.
        let next_us = self.boards[next].next_us();
        if now_us >= next_us {
            self.clock.ticked_us = next_us;
            now.set(next_us);
            self.boards[next].tick(self.speed > 1.0);
            self.clock.catch_up(next_us);
        }
        for board in &mut self.boards {
            board.speak(now_us);
        }
        true
    }
}

struct EmulatedBoard<H: Hardware<D>, const D: usize> {
    device: RefCell<TickSide<H, D>>,
    session: DeviceSession,
    from_host: FaultyLine,
    to_host: FaultyLine,
    leave: SyncSender<Vec<u8>>,
    /// Real time at which the watchdog was fed.
    heard: Moment,
    /// Bytes of the host since the end of a frame.
    frame: Vec<u8>,
    /// Room for a frame to the host.
    line: [u8; FRAME_MAX],
    /// Device time of the last tick, µs.
    ticked_us: u64,
    ticks: u64,
    unread: u64,
}

impl<H: Hardware<D>, const D: usize> EmulatedBoard<H, D> {
    fn new(
        board: H,
        emulation: &Emulation,
        leave: SyncSender<Vec<u8>>,
    ) -> Result<Self, EmulatorError> {
        let [from_host, to_host] = FaultyLine::both_ways(emulation.faults, emulation.seed)?;
        let device = TickSide::new(board).map_err(EmulatorError::Device)?;
        Ok(Self {
            device: RefCell::new(device),
            session: DeviceSession::within_this_process(),
            from_host,
            to_host,
            leave,
            heard: Moment::now(),
            frame: Vec::new(),
            line: [0; FRAME_MAX],
            ticked_us: 0,
            ticks: 0,
            unread: 0,
        })
    }

    /// Device time of the next tick, µs.
    fn next_us(&self) -> u64 {
        self.ticked_us + u64::from(self.device.borrow().configuration().0.tick_period_us)
    }

    fn counts(&self) -> Emulated {
        Emulated {
            ticks: self.ticks,
            damage: DuplexDamage {
                to_device: self.from_host.damage(),
                to_host: self.to_host.damage(),
            },
            unread: self.unread,
        }
    }

    /// Puts whole frames on the line from the host.
    fn take(&mut self, bytes: Vec<u8>, now_us: u64) {
        for byte in bytes {
            self.frame.push(byte);
            if byte == 0 || self.frame.len() > 4 * FRAME_MAX {
                self.from_host.send(&self.frame, now_us);
                self.frame.clear();
            }
        }
    }

    /// Hands what has come through to the device, and its answers to the line back.
    fn hear(&mut self, now_us: u64) {
        while let Some(frame) = self.from_host.receive(now_us) {
            let fed = self.session.fed();
            // The device has not been beyond its next tick, or its watchdog would see the future.
            let time_us = now_us.min(self.next_us());
            for byte in frame {
                let length = (self.session).receive(byte, time_us, &self.device, &mut self.line);
                if length > 0 {
                    self.to_host.send(&self.line[..length], now_us);
                }
            }
            if self.session.fed() != fed {
                self.heard = Moment::now();
            }
        }
    }

    /// The next tick. Of a device that is faster than real time `hurried` is true.
    fn tick(&mut self, hurried: bool) {
        self.ticked_us = self.next_us();
        let mut device = self.device.borrow_mut();
        // A host lives in real time, so its silence is measured in real time.
        let watchdog_ms = device.configuration().0.limits.watchdog_ms;
        let silent = self.heard.elapsed() > Duration::from_millis(u64::from(watchdog_ms));
        if hurried && !silent {
            device.heard(self.ticked_us, true);
        }
        device.tick(self.ticked_us);
        self.ticks += 1;
    }

    /// Sends what the device has to say, and lets go of what the line is through with.
    fn speak(&mut self, now_us: u64) {
        loop {
            let length = self.session.poll(&self.device, &mut self.line);
            if length == 0 {
                break;
            }
            self.to_host.send(&self.line[..length], now_us);
        }
        while let Some(frame) = self.to_host.receive(now_us) {
            if let Err(TrySendError::Full(_)) = self.leave.try_send(frame) {
                self.unread += 1;
            }
        }
    }
}

/// A device that an emulated board is, whatever a host takes it for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Mass, damping, friction, delay and lag. The sample time and the stiffness, which belongs to
    /// a hand, come from the run.
    pub plant: MassDamperConfig,
    /// Resolution of its encoder, m per count; 0 for none.
    pub encoder_resolution: Metres,
    /// Standard deviation of its noise, m, 0 for none; and the seed.
    pub noise: (Metres, u64),
}

/// A board that knows the force of the hand on it.
trait Touched<const D: usize> {
    /// That force now, N, positive along the position.
    fn touched(&self) -> [f64; D];
}

impl Touched<1> for SimulatedPlant {
    fn touched(&self) -> [f64; 1] {
        [self.contact_force()]
    }
}

impl Touched<1> for PressingBoard {
    fn touched(&self) -> [f64; 1] {
        [self.contact_force()]
    }
}

impl<const D: usize> Touched<D> for SimulatedAxes<D> {
    fn touched(&self) -> [f64; D] {
        self.contact_force()
    }
}

/// A simulated board with a body, or with that which the host asks for.
struct Embodied<H, const D: usize> {
    board: Sensed<H>,
    body: Option<Body>,
    sensor: Option<ForceSensor>,
    /// Reading of the sensor with the last position, N.
    sensed_n: [f32; D],
}

impl<H, const D: usize> Embodied<H, D> {
    fn new(
        board: H,
        body: Option<Body>,
        sensor: Option<ForceSensorConfig>,
    ) -> Result<Self, EmulatorError> {
        let none = (Metres(0.0), (Metres(0.0), 0));
        let (resolution, noise) = body.map_or(none, |body| (body.encoder_resolution, body.noise));
        let board = Sensed::new(board, resolution, noise.0, noise.1)?;
        Ok(Self {
            board,
            body,
            // A run sets its sample time.
            sensor: sensor
                .map(|sensor| ForceSensor::new(sensor, Seconds(1e-3)))
                .transpose()?,
            sensed_n: [f32::NAN; D],
        })
    }
}

impl<H: Hardware<D> + Touched<D>, const D: usize> Device<f32, D> for Embodied<H, D> {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, D>, Fault> {
        let reading = self.board.read()?;
        if let Some(sensor) = &mut self.sensor {
            let mut force = self.board.device().touched();
            sensor.read(&mut force);
            self.sensed_n = force.map(|force_n| force_n as f32);
        }
        Ok(reading)
    }

    fn write(&mut self, force: SafeForce<f32, D>) -> Result<(), Fault> {
        self.board.write(force)
    }

    fn let_go(&mut self) {
        self.board.let_go();
    }
}

impl<H: Touched<D> + Hardware<D, Setup: FitsDevice>, const D: usize> Hardware<D>
    for Embodied<H, D>
{
    type Setup = H::Setup;

    fn capabilities(&self) -> Capabilities {
        let mut capabilities = self.board.device().capabilities();
        if let Some(body) = &self.body {
            capabilities.position_resolution_m = body.encoder_resolution.0 as f32;
        }
        if let Some(sensor) = &self.sensor {
            capabilities.sensed_force_max_n = sensor.range().0 as f32;
        }
        capabilities
    }

    fn controller_cost(&self) -> Option<ControllerCost> {
        self.board.device().controller_cost()
    }

    fn fit(&self, setup: &mut Self::Setup) -> Result<(), Refusal> {
        self.body.map_or(Ok(()), |body| setup.fit(&body.plant))?;
        self.board.device().fit(setup)
    }

    fn install(&mut self, setup: Self::Setup, tick_period_us: u32) {
        self.board.device_mut().install(setup, tick_period_us);
        if let Some(sensor) = &mut self.sensor {
            sensor.read_every(Seconds(1e-6 * f64::from(tick_period_us)));
        }
    }

    fn sense(&mut self) -> [f32; D] {
        self.sensed_n
    }

    fn restart(&mut self) {
        self.board.device_mut().restart();
    }

    /// A board with a plant of its own stands still while it is read; one that faces another lets go of its mass.
    fn idle(&mut self) -> Result<Reading<f32, D>, Fault> {
        self.let_go();
        self.read()
    }
}

/// Hands over arriving bytes, until they are no longer taken.
fn read(mut port: Box<dyn Line>, taken: impl Fn(Vec<u8>) -> bool, over: &AtomicBool) {
    let mut bytes = [0; 1024];
    while !over.load(Ordering::Relaxed) {
        match port.read(&mut bytes) {
            Ok(count) => {
                if !taken(Vec::from(&bytes[..count])) {
                    return;
                }
            }
            Err(error) if error.kind() == ErrorKind::TimedOut => {}
            // Nobody has it open.
            Err(_) => std::thread::sleep(NOBODY),
        }
    }
}

/// Bytes written at once at most. On a busy machine frames wait, and one call for each of them would let more wait.
const AT_ONCE: usize = 4096;

fn write_all(mut port: Box<dyn Line>, leaving: &Receiver<Vec<u8>>, over: &AtomicBool) {
    while let Ok(mut bytes) = leaving.recv() {
        while bytes.len() < AT_ONCE
            && let Ok(frame) = leaving.try_recv()
        {
            bytes.extend(frame);
        }
        write(port.as_mut(), &bytes, over);
    }
}

/// Writes frames, however long the host takes: one that does not read at all fills the queue before this,
/// and what finds no room there is counted.
fn write(port: &mut dyn Line, frames: &[u8], over: &AtomicBool) {
    let mut rest = frames;
    while !rest.is_empty() && !over.load(Ordering::Relaxed) {
        match port.write(rest) {
            Ok(count) => rest = &rest[count..],
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
            // Nobody has it open.
            Err(_) => return,
        }
    }
}
