//! A board behind a line of this process, with the device's side of the link and, if wanted, a flaw.
//!
//! Its clock is that of its ticks: where this machine is late, the board is slow, and nothing else changes.

use haptic_document::Failure;
use haptic_emulator::{FaultyLine, LineDamage, LineFaults};
use haptic_link::{
    Capabilities, Configuration, DeviceReport, Direction, FRAME_MAX, Flight, Header, Receiver,
    Scope, State, encode,
};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_remote::serial::{Line as _, Pipe, SerialError, SerialLink};
use haptic_remote::{DeviceSession, Hardware, SimulatedPlant, TickSide};
use std::cell::RefCell;
use std::io::{Read as _, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The promise that a board breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flaw {
    None,
    /// Its watchdog is fed whoever is silent.
    DeafWatchdog,
    /// It makes twice the force that its chain lets through.
    StrongForce,
    /// It pushes while it is idle.
    ForceAtRest,
    /// Its force stays when its chain lets it fall.
    ForceStays,
    /// Its flight recorder is empty.
    NoRecorder,
    /// It counts its position the wrong way.
    Reversed,
    /// It says that the settings of the last connection are in force.
    KeepsSettings,
}

/// A board with an emergency stop and a simulated axis.
struct Axis {
    plant: SimulatedPlant,
    reversed: bool,
    stop_is_open: Arc<AtomicBool>,
}

impl Axis {
    fn look(&self) -> Result<(), Fault> {
        match self.persisting_fault() {
            Some(fault) => Err(fault),
            None => Ok(()),
        }
    }

    fn counted(&self, reading: Reading<f32, 1>) -> Reading<f32, 1> {
        let position_m = if self.reversed {
            -reading.position_m
        } else {
            reading.position_m
        };
        Reading {
            position_m,
            ..reading
        }
    }
}

impl Device<f32, 1> for Axis {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.look()?;
        self.plant.read().map(|reading| self.counted(reading))
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        self.plant.write(force)
    }

    fn let_go(&mut self) {}
}

impl Hardware for Axis {
    type Setup = <SimulatedPlant as Hardware>::Setup;

    fn capabilities(&self) -> Capabilities {
        self.plant.capabilities()
    }

    fn install(&mut self, setup: Self::Setup, tick_period_us: u32) {
        self.plant.install(setup, tick_period_us);
    }

    fn restart(&mut self) {
        self.plant.restart();
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.look()?;
        self.plant.idle().map(|reading| self.counted(reading))
    }

    fn persisting_fault(&self) -> Option<Fault> {
        let open = self.stop_is_open.load(Ordering::Relaxed);
        open.then_some(Fault::EmergencyStop)
    }
}

/// One direction of the line: bytes go in, and come through by frames, or not.
struct Way {
    line: FaultyLine,
    /// Bytes since the end of a frame.
    frame: Vec<u8>,
}

impl Way {
    fn new(faults: LineFaults, seed: u64) -> Self {
        Self {
            line: FaultyLine::new(faults, seed).expect("good chances"),
            frame: Vec::new(),
        }
    }

    fn through(&mut self, bytes: &[u8]) -> Vec<u8> {
        for &byte in bytes {
            self.frame.push(byte);
            if byte == 0 {
                self.line.send(&self.frame, 0);
                self.frame.clear();
            }
        }
        core::iter::from_fn(|| self.line.receive(0))
            .flatten()
            .collect()
    }
}

/// Ways to the board, and to the host.
type Ways = Arc<Mutex<[Way; 2]>>;

/// A board that runs until it is dropped.
pub(crate) struct Board {
    /// The end for hosts, one after another.
    line: Pipe,
    ways: Ways,
    over: Arc<AtomicBool>,
    stop_is_open: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Board {
    pub(crate) fn start(flaw: Flaw) -> Self {
        Self::on_line(flaw, LineFaults::default(), 0)
    }

    /// Board at a line with these faults in both directions.
    pub(crate) fn on_line(flaw: Flaw, faults: LineFaults, seed: u64) -> Self {
        let ways = [0, 1].map(|way| Way::new(faults, 2 * seed + way));
        let ways = Arc::new(Mutex::new(ways));
        let (line, mut port) = Pipe::pair();
        let patience = Duration::from_micros(500);
        port.set_patience(patience).expect("takes a patience");
        let over = Arc::new(AtomicBool::new(false));
        let stop_is_open = Arc::new(AtomicBool::new(false));
        let axis = Axis {
            plant: SimulatedPlant::new("board", || 0),
            reversed: flaw == Flaw::Reversed,
            stop_is_open: Arc::clone(&stop_is_open),
        };
        let ends = Arc::clone(&over);
        let running = Running::new(port, Arc::clone(&ways), axis, flaw);
        let thread = std::thread::spawn(move || running.run(&ends));
        Self {
            line,
            ways,
            over,
            stop_is_open,
            thread: Some(thread),
        }
    }

    /// Greets it once.
    pub(crate) fn greet(&self) -> Result<SerialLink, SerialError> {
        SerialLink::to_line(Box::new(self.line.clone()), "board", None)
    }

    pub(crate) fn connect(&self) -> Result<SerialLink, Failure> {
        self.greet().map_err(Failure::input)
    }

    /// What its line has done, to the board and to the host.
    pub(crate) fn damage(&self) -> [LineDamage; 2] {
        let ways = self.ways.lock().expect("no panic");
        [ways[0].line.damage(), ways[1].line.damage()]
    }

    pub(crate) fn open_stop(&self, open: bool) {
        self.stop_is_open.store(open, Ordering::Relaxed);
    }

    /// Opens the emergency stop after a moment, and closes it again.
    pub(crate) fn press_stop_for_a_moment(&self) {
        let stop_is_open = Arc::clone(&self.stop_is_open);
        std::thread::spawn(move || {
            for open in [true, false] {
                std::thread::sleep(Duration::from_millis(100));
                stop_is_open.store(open, Ordering::Relaxed);
            }
        });
    }

    /// Changes its settings for good.
    pub(crate) fn set(&self, change: impl FnOnce(&mut haptic_link::Limits)) {
        let mut link = self.connect().expect("answers");
        let (mut configuration, coefficients) = link.configuration().expect("has one");
        change(&mut configuration.limits);
        link.set_for(configuration, &coefficients, Scope::Lasting)
            .expect("takes it");
    }

    /// Pulls the plug.
    pub(crate) fn unplug(&self) {
        self.over.store(true, Ordering::Relaxed);
        while self
            .thread
            .as_ref()
            .is_some_and(|thread| !thread.is_finished())
        {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let ended = thread.join();
            assert!(
                ended.is_ok() || std::thread::panicking(),
                "the board panicked"
            );
        }
    }
}

struct Running {
    port: Pipe,
    ways: Ways,
    device: RefCell<TickSide<Axis>>,
    session: DeviceSession,
    flaw: Flaw,
    /// Time of its clock.
    now_us: u64,
    /// What leaves is read again, so that a flaw can change it.
    leaving: Receiver<DeviceReport>,
    /// Force before it began to fall, N.
    held_n: f32,
}

impl Running {
    fn new(port: Pipe, ways: Ways, axis: Axis, flaw: Flaw) -> Self {
        Self {
            port,
            ways,
            device: RefCell::new(TickSide::new(axis).expect("it starts")),
            session: DeviceSession::new([0, 1, 0], 7),
            flaw,
            now_us: 0,
            leaving: Receiver::new(Direction::FromDevice),
            held_n: 0.0,
        }
    }

    fn run(mut self, over: &AtomicBool) {
        let mut ticked = Instant::now();
        let mut bytes = [0; 1024];
        let mut line = [0; FRAME_MAX];
        while !over.load(Ordering::Relaxed) {
            // Nothing came.
            let count = self.port.read(&mut bytes).unwrap_or(0);
            for byte in self.through(0, &bytes[..count]) {
                let length = (self.session).receive(byte, self.now_us, &self.device, &mut line);
                self.send(&line[..length]);
            }
            let period_us = u64::from(self.device.borrow().configuration().0.tick_period_us);
            let period = Duration::from_micros(period_us);
            if ticked.elapsed() >= period {
                // A board that is far behind is slow, and does not hurry.
                ticked = (ticked + period).max(Instant::now() - 3 * period);
                self.tick(period_us);
            }
            loop {
                let length = self.session.poll(&self.device, &mut line);
                if length == 0 {
                    break;
                }
                self.send(&line[..length]);
            }
        }
    }

    fn tick(&mut self, period_us: u64) {
        self.now_us += period_us;
        let now_us = self.now_us;
        let mut device = self.device.borrow_mut();
        let silence_ms = device.configuration().0.limits.watchdog_ms;
        assert!(
            silence_ms <= 500,
            "a host that is killed leaves its force for {silence_ms} ms"
        );
        if self.flaw == Flaw::DeafWatchdog {
            device.heard(now_us, true);
        }
        device.tick(now_us);
    }

    fn send(&mut self, frame: &[u8]) {
        for &byte in frame {
            let Some((header, report)) = self.leaving.push(byte) else {
                continue;
            };
            let report = self.spoil(report);
            let mut line = [0; FRAME_MAX];
            let header = Header::from_device(header.sequence as u16);
            let length = encode(&report, header, &mut line).expect("it fits");
            let through = self.through(1, &line[..length]);
            // A host that is gone reads nothing.
            let _ = self.port.write_all(&through);
        }
    }

    fn through(&self, way: usize, bytes: &[u8]) -> Vec<u8> {
        self.ways.lock().expect("no panic")[way].through(bytes)
    }

    fn spoil(&mut self, report: DeviceReport) -> DeviceReport {
        match (self.flaw, report) {
            (Flaw::StrongForce, DeviceReport::Sample(mut sample)) => {
                sample.axes[0].force_n *= 2.0;
                DeviceReport::Sample(sample)
            }
            (Flaw::ForceAtRest, DeviceReport::Sample(mut sample)) => {
                let idle = self.device.borrow().status().state != State::Running;
                if idle {
                    sample.axes[0].force_n = 0.05;
                }
                DeviceReport::Sample(sample)
            }
            (Flaw::ForceStays, DeviceReport::Sample(mut sample)) => {
                // What falls in a fault or after a stop.
                if self.device.borrow().status().state == State::Running {
                    self.held_n = sample.axes[0].force_n;
                }
                sample.axes[0].force_n = self.held_n;
                DeviceReport::Sample(sample)
            }
            (Flaw::NoRecorder, DeviceReport::Flight(flight)) => {
                DeviceReport::Flight(Flight { count: 0, ..flight })
            }
            (
                Flaw::KeepsSettings,
                DeviceReport::Configuration {
                    configuration,
                    digest,
                },
            ) => {
                // Those of the test, once a run has ended in a fault.
                let changed = self.device.borrow().status().faults > 0;
                let set = configuration.limits;
                let limits = haptic_link::Limits {
                    force_n: if changed { 0.1 } else { set.force_n },
                    ..set
                };
                let configuration = Configuration {
                    limits,
                    ..configuration
                };
                DeviceReport::Configuration {
                    configuration,
                    digest,
                }
            }
            (_, report) => report,
        }
    }
}
