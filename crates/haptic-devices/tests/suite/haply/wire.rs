//! An emulated board at the other end of a line in virtual time, and a device that is armed and runs on it.

use haptic_devices::haply::{
    Axis, Haply2Diy, HaplyName, Home, TORQUES_BYTES, Version, angles_of, configuration,
};
use haptic_emulator::{
    AtLine as _,
    haply::{Board, Body, Hand},
};
use haptic_link::{Configuration, Limits, LoopMode, OperatorShape, Start};
use haptic_remote::{Tick, TickSide, prepare, serial::Line};
use nalgebra::Vector2;
use std::{
    collections::VecDeque,
    io::{self, ErrorKind, Read, Write},
    sync::{Arc, Mutex},
    time::Duration,
};

/// Largest force of these runs, N.
pub(crate) const FORCE_N: f32 = 1.0;
/// T, µs.
pub(crate) const TICK_US: u32 = 1000;

/// Damage to one byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Damage {
    Lost,
    Added(u8),
    /// Bits that flip.
    Changed(u8),
}

/// Both directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    ToBoard,
    ToHost,
}

/// The board, the bytes on their way to the host, and what is to happen to one of them.
#[derive(Clone, Debug)]
pub(crate) struct World {
    pub(crate) board: Board,
    pub(crate) now_us: u64,
    to_host: VecDeque<u8>,
    /// Way, bytes until the one that is hit, damage to it.
    pub(crate) planned: Option<(Way, u32, Damage)>,
    /// Bytes of the host are not heard: the board has stopped.
    pub(crate) dead: bool,
    /// What the board says does not come through yet.
    pub(crate) held: bool,
    /// The port is gone, with whatever the board does behind it.
    pub(crate) gone: bool,
    /// The last frames of the host, as it sent them.
    pub(crate) frames: VecDeque<[u8; TORQUES_BYTES]>,
    /// Largest torque in any of them, N·m.
    largest_nm: f64,
}

impl World {
    /// A board that was switched on with its handle at home, and configured as this name says.
    pub(crate) fn new(board: Board) -> Self {
        Self {
            board,
            now_us: 0,
            to_host: VecDeque::new(),
            planned: None,
            dead: false,
            held: false,
            gone: false,
            frames: VecDeque::new(),
            largest_nm: 0.0,
        }
    }

    /// The byte as it comes through: none, one or two.
    fn damaged(&mut self, way: Way, byte: u8) -> ([u8; 2], usize) {
        let whole = ([byte, 0], 1);
        let Some((planned, left, damage)) = self.planned else {
            return whole;
        };
        if planned != way {
            return whole;
        }
        if left > 0 {
            self.planned = Some((planned, left - 1, damage));
            return whole;
        }
        self.planned = None;
        match damage {
            Damage::Lost => ([0, 0], 0),
            Damage::Added(added) => ([added, byte], 2),
            Damage::Changed(bits) => ([byte ^ bits, 0], 1),
        }
    }
}

/// The torques of a frame, N·m: they stand where angles stand in an answer.
fn numbers(board: &Board, frame: &[u8; TORQUES_BYTES]) -> [f64; 2] {
    let [_, numbers @ ..] = *frame;
    angles_of(board.wired(), numbers).1.map(f64::from)
}

/// The host's end.
#[derive(Clone, Debug)]
pub(crate) struct Wire(pub(crate) Arc<Mutex<World>>);

impl Wire {
    /// Wire to a board that was switched on so long ago.
    fn after(board: Board, now_us: u64) -> Self {
        let mut world = World::new(board);
        world.now_us = now_us;
        Self::new(world)
    }

    pub(crate) fn new(world: World) -> Self {
        Self(Arc::new(Mutex::new(world)))
    }

    pub(crate) fn with<R>(&self, user: impl FnOnce(&mut World) -> R) -> R {
        user(&mut self.0.lock().expect("nobody panicked with it"))
    }
}

impl Read for Wire {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        self.with(|world| {
            if world.gone {
                return Err(ErrorKind::BrokenPipe.into());
            }
            if world.held || world.to_host.is_empty() {
                return Err(ErrorKind::TimedOut.into());
            }
            world.to_host.read(into)
        })
    }
}

impl Write for Wire {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.with(|world| {
            if world.gone {
                return Err(ErrorKind::BrokenPipe.into());
            }
            if let Ok(frame) = bytes.try_into() {
                world.frames.push_front(frame);
                let torques = numbers(&world.board, &frame).map(f64::abs);
                world.largest_nm = torques.into_iter().fold(world.largest_nm, f64::max);
                world.frames.truncate(6);
            }
            for &byte in bytes {
                let (through, count) = world.damaged(Way::ToBoard, byte);
                if world.dead {
                    continue;
                }
                let mut answer = Vec::new();
                for &byte in &through[..count] {
                    world.board.receive(byte, world.now_us, &mut answer);
                }
                for byte in answer {
                    let (through, count) = world.damaged(Way::ToHost, byte);
                    world.to_host.extend(&through[..count]);
                }
            }
            Ok(bytes.len())
        })
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Line for Wire {
    fn share(&self) -> io::Result<Box<dyn Line>> {
        Err(ErrorKind::Unsupported.into())
    }

    fn set_baud_rate(&mut self, _: u32) {}

    fn set_patience(&mut self, _: Duration) -> io::Result<()> {
        Ok(())
    }
}

/// A board whose handle a hand strokes, through the surface in the middle.
fn stroking(version: Version) -> Board {
    let model = version.model();
    let from = [0.5 * model.pantograph.base_m + 0.004, 0.085];
    let hand = Hand::Strokes {
        from,
        depth_m: 0.015,
        time_s: 0.5,
    };
    Board::new(model, Body::at_home(&model, hand))
}

/// The same, configured, at this time.
pub(crate) fn stroked(version: Version, now_us: u64) -> Board {
    let mut board = stroking(version);
    for byte in configuration(&version.model()) {
        board.receive(byte, 0, &mut Vec::new());
    }
    board.advance(now_us);
    board
}

/// Settings of a device of this version along y.
pub(crate) fn name(version: Version, home: Home) -> HaplyName {
    HaplyName {
        version,
        axis: Axis::Y,
        home,
        ..HaplyName::at("virtual")
    }
}

/// What a host answers to a tick, N.
pub(crate) type HostLaw<const D: usize> = Box<dyn FnMut(&Tick<D>) -> [f32; D]>;

/// A device in front of its hand, armed and running; and its board.
pub(crate) struct Running<const D: usize = 1> {
    pub(crate) device: TickSide<Haply2Diy<Wire, D>, D>,
    pub(crate) wire: Wire,
    tick_us: u64,
    /// Law of a loop on the host.
    host: Option<HostLaw<D>>,
}

/// Law of a device.
#[derive(Clone, Debug)]
pub(crate) struct Law {
    pub(crate) stiffness: f32,
    pub(crate) dissipation: f32,
    pub(crate) order: f32,
    pub(crate) operator: (OperatorShape, Vec<f32>),
    pub(crate) one_sided: bool,
    pub(crate) tick_us: u32,
    pub(crate) limits: Limits,
}

impl Default for Law {
    /// Nothing.
    fn default() -> Self {
        Self {
            stiffness: 0.0,
            dissipation: 0.0,
            order: 0.0,
            operator: (Configuration::PASSIVE.operator, vec![0.0]),
            one_sided: false,
            tick_us: TICK_US,
            limits: Limits {
                watchdog_ms: 1000,
                ..Limits::bare(FORCE_N, 1000.0)
            },
        }
    }
}

impl Running {
    /// Begins with a board that was configured before, and a spring.
    pub(crate) fn on(board: Board, version: Version, now_us: u64) -> Self {
        let spring = Law {
            stiffness: 60.0,
            one_sided: true,
            ..Law::default()
        };
        Self::with(board, version, now_us, &spring)
    }

    /// Begins with a board that was configured before.
    pub(crate) fn with(board: Board, version: Version, now_us: u64, law: &Law) -> Self {
        let wire = Wire::after(board, now_us);
        let hardware = Haply2Diy::<_, 1>::greet(wire.clone(), &name(version, Home::Before));
        let configuration = Configuration {
            stiffness_n_per_m: law.stiffness,
            dissipation_n_s_mu_per_m: law.dissipation,
            order: law.order,
            one_sided: law.one_sided,
            operator: law.operator.0,
            limits: law.limits,
            ..limited(law.tick_us)
        };
        let device = started(hardware.expect("answers"), configuration, &law.operator.1);
        Self {
            device,
            wire,
            tick_us: u64::from(law.tick_us),
            host: None,
        }
    }
}

impl Running<2> {
    /// Begins with both axes, and a loop on the host.
    pub(crate) fn both(
        board: Board,
        version: Version,
        now_us: u64,
        tick_us: u32,
        host: HostLaw<2>,
    ) -> Self {
        let wire = Wire::after(board, now_us);
        let hardware = Haply2Diy::<_, 2>::greet(wire.clone(), &name(version, Home::Before));
        let configuration = Configuration {
            loop_mode: LoopMode::Host,
            ..limited(tick_us)
        };
        Self {
            device: started(hardware.expect("answers"), configuration, &[0.0]),
            wire,
            tick_us: u64::from(tick_us),
            host: Some(host),
        }
    }
}

/// No law, and the limits of these runs.
fn limited(tick_period_us: u32) -> Configuration {
    Configuration {
        tick_period_us,
        limits: Law::default().limits,
        ..Configuration::PASSIVE
    }
}

/// The device's loop, armed and running.
fn started<const D: usize>(
    hardware: Haply2Diy<Wire, D>,
    configuration: Configuration,
    values: &[f32],
) -> TickSide<Haply2Diy<Wire, D>, D> {
    let mut device = TickSide::new(hardware).expect("starts");
    let capabilities = haptic_remote::Hardware::capabilities(device.hardware());
    let prepared = prepare::<Haply2Diy<Wire, D>, D>(configuration, values, &capabilities);
    let installed = device.install(prepared.expect("good"), values);
    installed.expect("is idle");
    device.arm(0).expect("nothing is wrong");
    device.start(Start::ENDLESS).expect("is armed");
    device
}

impl<const D: usize> Running<D> {
    /// The next tick, a period later.
    pub(crate) fn tick(&mut self) {
        self.tick_after(0);
    }

    /// The next tick, after so many periods in which this machine was too busy for one.
    pub(crate) fn tick_after(&mut self, skipped: u32) {
        let period_us = self.tick_us * (1 + u64::from(skipped));
        if skipped > 0 {
            self.device.skip(skipped);
        }
        let now_us = self.wire.with(|world| {
            world.now_us += period_us;
            world.board.advance(world.now_us);
            world.now_us
        });
        self.device.heard(now_us, true);
        if let Some(host) = &mut self.host {
            let newest = *self.device.newest();
            self.device.command(newest.tick, host(&newest));
        }
        self.device.tick(now_us);
    }

    /// The force at the handle that the motors make now, N.
    pub(crate) fn force(&self) -> Vector2<f64> {
        self.wire.with(|world| {
            let [first, second] = world.board.torques_nm();
            let pantograph = self.device.hardware().model().pantograph;
            let posture = pantograph
                .posture(world.board.body().angles())
                .expect("in order");
            posture.force(Vector2::new(first, second))
        })
    }

    /// True if a motor makes a torque that no frame of late has asked for, and that is one.
    pub(crate) fn is_wrong(&self) -> bool {
        self.wire.with(|world| {
            let made = world.board.torques_nm();
            let frames = world
                .frames
                .iter()
                .map(|frame| numbers(&world.board, frame));
            let frames: Vec<[f64; 2]> = frames.collect();
            (0..2).any(|joint| {
                let asked = frames
                    .iter()
                    .any(|frame| (frame[joint] - made[joint]).abs() < 1e-12);
                made[joint].abs() > 1e-30 && !asked
            })
        })
    }

    /// Largest torque that the board was to make so far, and the largest that was sent, N·m.
    pub(crate) fn largest_torques(&self) -> (f64, f64) {
        self.wire
            .with(|world| (world.board.counted().largest_nm, world.largest_nm))
    }

    /// Larger of both torques, N·m.
    pub(crate) fn torque(&self) -> f64 {
        self.wire.with(|world| {
            let [first, second] = world.board.torques_nm();
            first.abs().max(second.abs())
        })
    }
}
