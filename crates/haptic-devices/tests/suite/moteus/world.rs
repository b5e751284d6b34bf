//! An emulated servo at the end of a line of virtual time, which can be harmed.

use haptic_devices::moteus::{MoteusAxis, MoteusOpenError, MoteusSettings};
use haptic_emulator::moteus::{EmulatedAdapter, EmulatedServo, Shaft};
use haptic_link::{Configuration, Limits, OperatorShape, Start, State};
use haptic_loop::Fault;
use haptic_remote::{Hardware as _, TickSide, prepare, serial::ServedHardware as _};
use std::{
    collections::VecDeque,
    io::{ErrorKind, Read, Result, Write},
    sync::{Arc, Mutex, MutexGuard},
};

/// Time from a line of the host to the answer, µs.
const ROUND_TRIP_US: u64 = 300;
/// Largest force of a run, N.
pub(crate) const FORCE_LIMIT_N: f32 = 1.5;

/// Does something to bytes on their way. True for those to the servo.
pub(crate) type Harm = Box<dyn FnMut(&mut Vec<u8>, bool) + Send>;

/// Servo, adapter and line.
pub(crate) struct World {
    pub(crate) adapter: EmulatedAdapter,
    pub(crate) now_us: u64,
    pub(crate) harm: Option<Harm>,
    to_host: VecDeque<(u64, u8)>,
    /// A read that finds nothing lets so much time pass, µs.
    patience_us: u64,
    pub(crate) gone: bool,
}

/// The host's end of the line.
#[derive(Clone)]
pub(crate) struct Wire {
    world: Arc<Mutex<World>>,
    checksum: bool,
}

impl Wire {
    pub(crate) fn new(shaft: Shaft) -> Self {
        let servo = EmulatedServo::new(1, shaft).expect("a good servo");
        Self::to(EmulatedAdapter::new(servo), true)
    }

    /// Wire to an adapter of which it is known, or not, that it takes checksums.
    pub(crate) fn to(adapter: EmulatedAdapter, checksum: bool) -> Self {
        let world = World {
            adapter,
            now_us: 0,
            harm: None,
            to_host: VecDeque::new(),
            patience_us: 20_000,
            gone: false,
        };
        Self {
            world: Arc::new(Mutex::new(world)),
            checksum,
        }
    }

    pub(crate) fn world(&self) -> MutexGuard<'_, World> {
        self.world.lock().expect("nobody panicked with it")
    }

    /// Opens the servo, as a host does.
    pub(crate) fn open(
        &self,
        settings: MoteusSettings,
    ) -> std::result::Result<Axis, MoteusOpenError> {
        let axis = MoteusAxis::open(self.clone(), settings, self.checksum)?;
        self.world().patience_us = 0;
        Ok(axis)
    }
}

impl std::fmt::Debug for Wire {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Wire")
    }
}

impl Read for Wire {
    fn read(&mut self, into: &mut [u8]) -> Result<usize> {
        let mut world = self.world();
        if world.gone {
            return Ok(0);
        }
        let now_us = world.now_us + world.patience_us;
        let mut count = 0;
        while count < into.len()
            && let Some((_, byte)) = world.to_host.front().filter(|(at, _)| *at <= now_us)
        {
            into[count] = *byte;
            count += 1;
            world.to_host.pop_front();
        }
        if count > 0 {
            return Ok(count);
        }
        world.now_us = now_us;
        Err(ErrorKind::TimedOut.into())
    }
}

impl Write for Wire {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        let mut guard = self.world();
        let world = &mut *guard;
        if world.gone {
            return Err(ErrorKind::BrokenPipe.into());
        }
        let mut sent = bytes.to_vec();
        if let Some(harm) = &mut world.harm {
            harm(&mut sent, true);
        }
        let mut answer = Vec::new();
        let (now_us, arrival_us) = (world.now_us, world.now_us + ROUND_TRIP_US);
        world.adapter.receive(&sent, now_us, &mut answer);
        if let Some(harm) = &mut world.harm {
            harm(&mut answer, false);
        }
        world
            .to_host
            .extend(answer.iter().map(|byte| (arrival_us, *byte)));
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

pub(crate) type Axis = MoteusAxis<Wire>;

/// A device that renders a spring on the emulated servo.
pub(crate) struct Rig {
    pub(crate) wire: Wire,
    pub(crate) device: TickSide<Axis>,
    run: u32,
    period_us: u64,
}

impl Rig {
    pub(crate) fn new(stiffness_n_per_m: f32) -> Self {
        Self::on(Wire::new(Shaft::LEVER), stiffness_n_per_m)
    }

    /// Rig at a port of an adapter that knows no checksums.
    pub(crate) fn without_checksum(stiffness_n_per_m: f32) -> Self {
        let servo = EmulatedServo::new(1, Shaft::LEVER).expect("a good servo");
        let adapter = EmulatedAdapter::without_checksums(servo);
        Self::on(Wire::to(adapter, false), stiffness_n_per_m)
    }

    pub(crate) fn on(wire: Wire, stiffness_n_per_m: f32) -> Self {
        let spring = Configuration {
            stiffness_n_per_m,
            operator: OperatorShape {
                count: 1,
                ..Configuration::PASSIVE.operator
            },
            ..Configuration::PASSIVE
        };
        Self::with(wire, spring, &[0.0])
    }

    /// One with a spring, started.
    pub(crate) fn running(stiffness_n_per_m: f32) -> Self {
        let mut rig = Self::new(stiffness_n_per_m);
        rig.start();
        rig
    }

    /// Rig with a law, and the limits of all rigs.
    pub(crate) fn with(wire: Wire, law: Configuration, coefficients: &[f32]) -> Self {
        let axis = wire.open(MoteusSettings::DEFAULT).expect("it answers");
        let capabilities = axis.capabilities();
        let mut device = TickSide::new(axis).expect("no configuration is refused");
        let configuration = Configuration {
            limits: Limits {
                force_n: FORCE_LIMIT_N,
                start_force_n: 0.0,
                rise_time_s: 0.0,
                ..Limits::DEFAULT
            },
            ..law
        };
        let period_us = u64::from(configuration.tick_period_us);
        let prepared =
            prepare::<Axis, 1>(configuration, coefficients, &capabilities).expect("good");
        device.install(prepared, coefficients).expect("idle");
        Self {
            wire,
            device,
            run: 0,
            period_us,
        }
    }

    pub(crate) fn tick(&mut self) {
        self.tick_after(0);
    }

    /// The next tick, after so many periods in which this machine was too busy for one.
    pub(crate) fn tick_after(&mut self, skipped: u32) {
        let now_us = {
            let mut world = self.wire.world();
            world.now_us += self.period_us * (1 + u64::from(skipped));
            world.now_us
        };
        if skipped > 0 {
            self.device.skip(skipped);
        }
        // A host keeps its watchdog quiet.
        self.device.heard(now_us, true);
        self.device.tick(now_us);
    }

    /// Arms and starts, after whatever fault there was. So many ticks until then.
    pub(crate) fn start(&mut self) -> u32 {
        for ticks in 0..500 {
            if self.state() == State::Running {
                return ticks;
            }
            let faults = self.device.status().faults;
            if matches!(self.state(), State::Fault | State::Idle) {
                // Refused while the board is not well.
                let _ = self.device.arm(faults);
            }
            if self.state() == State::Armed {
                self.run += 1;
                let start = Start {
                    run: self.run,
                    ..Start::ENDLESS
                };
                let _ = self.device.start(start);
            }
            self.tick();
        }
        panic!("does not start again: {:?}", self.trouble());
    }

    pub(crate) fn state(&self) -> State {
        self.device.status().state
    }

    pub(crate) fn fault(&self) -> Option<Fault> {
        Fault::from_code(self.device.status().fault)
    }

    pub(crate) fn trouble(&self) -> String {
        let trouble = self.device.hardware().trouble();
        trouble.map_or_else(String::new, |trouble| trouble.words)
    }

    /// The torque that the servo makes now, N·m.
    pub(crate) fn torque_nm(&self) -> f64 {
        let mut world = self.wire.world();
        let now_us = world.now_us;
        world.adapter.servo.advance(now_us);
        world.adapter.servo.torque_nm()
    }

    /// Leads the lever to a place, m, at 0.2 m/s, and holds it there for some ticks.
    pub(crate) fn lead(&mut self, to_m: f64) {
        let metres = MoteusSettings::DEFAULT.metres_per_revolution();
        let from_m = metres * self.wire.world().adapter.servo.position_rev();
        let steps = ((to_m - from_m).abs() / 2e-4).ceil();
        for step in 1..=steps as u32 + 25 {
            let share = f64::from(step).min(steps) / steps;
            self.place(from_m + share * (to_m - from_m));
            self.tick();
        }
    }

    /// Puts the lever somewhere, m.
    pub(crate) fn place(&self, position_m: f64) {
        let metres = MoteusSettings::DEFAULT.metres_per_revolution();
        self.wire.world().adapter.servo.place(position_m / metres);
    }
}
