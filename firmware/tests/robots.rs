//! Instructions of a tick of a robot behind a virtual body.
#![no_std]
#![no_main]

#[path = "support/clock.rs"]
mod clock;
#[path = "support/counted.rs"]
mod counted;
mod listed;
mod lists;
mod support;

use clock::passed;
use core::cell::Cell;
use cortex_m::peripheral::SYST;
use cortex_m_rt::entry;
use counted::{Counted, TICKS, measure};
use fracdiff::portable::Form;
use haptic_link::{Capabilities, Limits, Refusal};
use haptic_loop::units::{
    Metres, MetresPerSecond, MetresPerSecondSquared, NewtonSecondsPerMetre, Newtons, Seconds,
};
use haptic_loop::{
    Device, Fault, MotionLimits, MotionReading, MovingDevice, Reading, SafeForce, SafeMotion,
    VirtualBody,
};
use haptic_remote::{DeviceOperator, Hardware, MovedRobot};
use nalgebra::SVector;

/// A robot without hardware, which looks at the clock.
#[derive(Debug, Default)]
struct Probe {
    tick: u32,
    read_at: Cell<u32>,
    /// Counts from the end of `sense` to the start of `command`.
    path: Cell<u32>,
    position_m: f32,
    push_n: f32,
    noise_n: f32,
}

/// A hand pushes by 2 N into the wall, then pulls back out of it.
impl MovingDevice<f32, 1> for Probe {
    type Error = Fault;

    fn sense(&mut self) -> Result<MotionReading<f32, 1>, Fault> {
        if self.tick == TICKS / 2 {
            self.push_n = -self.push_n;
        }
        // As a sensor shows it: never the same twice.
        self.noise_n = -self.noise_n;
        let reading = MotionReading {
            tick: u64::from(self.tick),
            time_s: 0.0,
            position_m: SVector::from([self.position_m]),
            sensed_force_n: SVector::from([self.push_n + self.noise_n]),
            force_age_s: 1e-3,
        };
        self.tick += 1;
        self.read_at.set(SYST::get_current());
        Ok(reading)
    }

    fn command(&mut self, motion: SafeMotion<f32, 1>) -> Result<(), Fault> {
        let now = SYST::get_current();
        self.path.set(passed(self.read_at.get(), now));
        self.position_m += 1e-3 * motion.metres_per_second()[0];
        Ok(())
    }
}

/// A robot behind a virtual body, as a board has it.
#[derive(Debug)]
struct Robot(MovedRobot<Probe>);

impl Robot {
    /// 0.5 m/s, 10 m/s², 50 mm to both sides, and everything that is on by default.
    fn new(body: DeviceOperator) -> Self {
        let [low, high] = [-0.05, 0.05].map(Metres);
        let limits = MotionLimits::of(
            MetresPerSecond(0.5),
            MetresPerSecondSquared(10.0),
            [low],
            [high],
            Newtons(50.0),
        );
        let body = VirtualBody::new(2.0, NewtonSecondsPerMetre(20.0), body).expect("a body");
        let probe = Probe {
            noise_n: 1e-3,
            ..Probe::default()
        };
        let robot = MovedRobot::new(probe, Some(body), &limits, Seconds(1e-3));
        Self(robot.expect("in range"))
    }
}

impl Device<f32, 1> for Robot {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.0.read()
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        self.0.write(force)
    }

    fn let_go(&mut self) {
        self.0.let_go();
    }

    fn stop(&mut self) {
        self.0.stop();
    }

    fn moves(&self) -> bool {
        self.0.moves()
    }
}

impl Hardware for Robot {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        let mut capabilities = listed::capabilities("robot");
        self.0.declare(&mut capabilities);
        capabilities
    }

    fn install(&mut self, (): (), _: u32) {}

    fn restart(&mut self) {}

    fn drive(&mut self) -> Result<(), Refusal> {
        self.0.drive()?;
        let robot = self.0.robot_mut();
        (robot.tick, robot.push_n) = (0, 2.0);
        Ok(())
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.0.idle()
    }

    fn sense(&mut self) -> [f32; 1] {
        self.0.sensed_n()
    }
}

impl Counted for Robot {
    fn path(&self) -> u32 {
        self.0.robot().path.get()
    }
}

/// D¹ at 1 kHz, as a recursion of degree 1, which a lagged mass is too: y ← g·x − g·x₁.
const MASS: [f32; 3] = [1e3, -1e3, 0.0];

#[entry]
fn main() -> ! {
    clock::start();
    let bare = Limits::bare(2.0, 1000.0);
    for law in lists::all() {
        let mass = || DeviceOperator::new(Form::Recursion, 0, &MASS).expect("good");
        if law.name == "full 200 s" {
            let (values, count) = law.values();
            let fractional = DeviceOperator::new(Form::Modes, 0, &values[..count]);
            let fractional = Robot::new(fractional.expect("good"));
            measure(Robot::new(mass()), &law, "robot, full 200 s", bare, None);
            measure(
                fractional,
                &law,
                "robot, full 200 s, fractional body",
                bare,
                None,
            );
        } else if law.name == "full 24 h" {
            let name = "robot, full 24 h, whole chain";
            measure(Robot::new(mass()), &law, name, Limits::DEFAULT, None);
        }
    }
    support::pass()
}
