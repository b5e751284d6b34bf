//! A board that fails at a tick, in the interrupt and under the main loop of the firmware: no force is left on its motor, and the host is
//! told.

use haptic_board::haptic_link::Configuration;
use haptic_board::haptic_link::{Capabilities, Refusal, Simulation, Start, State};
use haptic_board::haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_board::haptic_remote::{Exclusive as _, Hardware, prepare};
use haptic_board::nalgebra::Vector1;
use haptic_board::{
    Line, MainLoop, NoWatchdog, Place, RetainedMemory, TickTimer, Ticker, one_axis, only_real,
    power_up,
};
use std::cell::RefCell;
use std::rc::Rc;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Fails {
    Read,
    Write,
}

/// A handle that stands still in a spring, and a motor that holds what it was told last.
struct Board {
    motor_n: Rc<RefCell<Vec<f32>>>,
    tick: u64,
    at: u64,
    fails: Fails,
    lasts: bool,
}

impl Board {
    fn failing(&self, place: Fails) -> bool {
        let now = self.tick == self.at || (self.lasts && self.tick > self.at);
        self.fails == place && now
    }
}

impl Device<f32, 1> for Board {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        if self.failing(Fails::Read) {
            self.tick += 1;
            return Err(Fault::EmergencyStop);
        }
        Ok(Reading {
            tick: self.tick,
            time_s: 0.0,
            position_m: Vector1::new(0.01),
        })
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        let fails = self.failing(Fails::Write);
        self.tick += 1;
        if fails {
            return Err(Fault::CurrentMismatch);
        }
        self.motor_n.borrow_mut().push(force.newtons()[0]);
        Ok(())
    }

    /// The enable line of the amplifier, which works without the bus.
    fn let_go(&mut self) {
        self.motor_n.borrow_mut().push(0.0);
    }
}

impl Hardware for Board {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            force_max_n: 5.0,
            force_rate_max_n_per_s: 1e4,
            position_resolution_m: 1e-5,
            ..one_axis("failing")
        }
    }

    fn prepare(simulation: &Simulation, _: u32) -> Result<(), Refusal> {
        only_real(simulation)
    }

    fn install(&mut self, (): (), _: u32) {}

    fn restart(&mut self) {
        self.tick = 0;
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.let_go();
        self.read()
    }
}

#[derive(Debug)]
struct Timer;

impl TickTimer for Timer {
    fn acknowledge(&mut self) {}

    fn is_pending(&self) -> bool {
        false
    }

    fn set_period_us(&mut self, _: u32) {}
}

/// Nobody at the other end, who would keep what is sent.
struct Silent(Vec<u8>);

impl Line for Silent {
    fn receive(&mut self) -> Option<u8> {
        None
    }

    fn take_lost(&mut self) -> u32 {
        0
    }

    fn room(&self) -> usize {
        usize::MAX
    }

    fn send(&mut self, bytes: &[u8]) {
        self.0.extend(bytes);
    }
}

/// A spring of 200 N/m: 2 N at the place of the handle.
fn configuration() -> Configuration {
    let mut configuration = Configuration::PASSIVE;
    configuration.stiffness_n_per_m = 200.0;
    configuration.limits.force_n = 5.0;
    configuration.limits.force_rate_n_per_s = 1e4;
    configuration.limits.rise_time_s = 0.0;
    configuration.limits.start_force_n = 5.0;
    configuration
}

#[test]
fn a_board_that_fails_at_a_tick_has_no_force_left_on_its_motor() {
    for (fails, told) in [
        (Fails::Read, Fault::EmergencyStop),
        (Fails::Write, Fault::CurrentMismatch),
    ] {
        for (at, lasts) in [(5, false), (5, true), (60, false)] {
            let motor_n = Rc::new(RefCell::new(Vec::new()));
            let board = Board {
                motor_n: Rc::clone(&motor_n),
                tick: 0,
                at: u64::MAX,
                fails,
                lasts,
            };
            let retained: &'static RetainedMemory = Box::leak(Box::default());
            let place = Box::leak(Box::new(Place::new()));
            let (device, session) =
                power_up(place, board, [0, 1, 0], retained.take()).expect("a board");
            let mut ticker = Ticker::new(device, Timer, retained);
            device.with(|device| {
                let capabilities = device.hardware().capabilities();
                let prepared = prepare::<Board, 1>(configuration(), &[0.0], &capabilities);
                device
                    .install(prepared.expect("in range"), &[0.0])
                    .expect("idle");
                device.arm(0).expect("no fault");
                device.start(Start::ENDLESS).expect("armed");
                device.hardware_mut().at = at;
            });
            let mut main_loop = MainLoop::new(device, session);
            let mut line = Silent(Vec::new());
            for tick in 1..=100 {
                device.with(|device| device.heard(1000 * tick, true));
                ticker.tick(1000 * tick);
                while !main_loop.round(&mut line, &mut NoWatchdog, || 1000 * tick) {}
                let forces = motor_n.borrow();
                let force = forces.last().copied();
                if tick <= at {
                    assert!(force < Some(-1.0), "{fails:?}, tick {tick}: {force:?}");
                } else {
                    assert_eq!(force, Some(0.0), "{fails:?} at {at}, tick {tick}");
                }
            }
            let status = device.with(|device| device.status());
            assert_eq!((status.state, status.fault), (State::Fault, told.code()));
            assert!(!line.0.is_empty(), "the fault is told");
        }
    }
}
