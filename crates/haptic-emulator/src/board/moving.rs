//! An emulated robot that takes a velocity, in a hand, to rehearse a run without one.
//!
//! Body, sensor and chain of motion are those of a robot behind the bridge, see [`MovedRobot`]; below them is a [`SimulatedRobot`]. It has the
//! sample time that it was made for.
//!
//! - *Pushed* by the force that a run gives to its hand, from its start on.
//! - *Silence* of the host, a fault or a stop brings it to rest by its greatest deceleration, in its own tick.
//! - *Outside of a run*, once it stands, it is at its start at 0, and nobody pushes: the sensor rests.

use haptic_link::{Capabilities, ControllerCost, Field, Refusal, Simulation, SimulationKind};
use haptic_loop::{
    Device, Fault, LoopParameterError, MotionLimits, MotionReading, MovingDevice, Reading,
    SafeForce, SafeMotion, VirtualBody,
    plant::{SimulatedRobot, SimulatedRobotConfig},
};
use haptic_remote::{CONTROLLER_COST, DeviceOperator, Hardware, MovedRobot, PlantSetup, abilities};
use std::convert::Infallible;

/// A robot to be emulated.
#[derive(Clone, Debug, PartialEq)]
pub struct EmulatedRobot {
    /// Its own loop, its sensors, the hand at its handle, and T, a whole number of microseconds.
    pub robot: SimulatedRobotConfig,
    /// Its virtual body; `None` for one that is to be measured.
    pub body: Option<VirtualBody<f32, DeviceOperator>>,
    /// Limits that the chain of motion keeps, whoever asks for more.
    pub limits: MotionLimits<1>,
}

/// The simulated robot, whose ticks go on when it goes back to its start.
#[derive(Clone, Debug)]
struct AtHandle {
    robot: SimulatedRobot<1>,
    tick: u64,
}

impl MovingDevice<f32, 1> for AtHandle {
    type Error = Infallible;

    fn sense(&mut self) -> Result<MotionReading<f32, 1>, Infallible> {
        let reading = self.robot.sense()?;
        Ok(MotionReading {
            tick: self.tick,
            ..reading
        })
    }

    fn command(&mut self, motion: SafeMotion<f32, 1>) -> Result<(), Infallible> {
        self.tick += 1;
        self.robot.command(motion)
    }
}

/// A board of one axis that moves.
#[derive(Debug)]
pub(super) struct MovingBoard {
    moved: MovedRobot<AtHandle>,
    start: SimulatedRobot<1>,
    /// It has been driven since it was at its start.
    is_away: bool,
    push_n: f64,
    capabilities: Capabilities,
}

impl MovingBoard {
    /// A board of this name.
    ///
    /// # Errors
    /// A robot or limits outside their range.
    pub(super) fn new(name: &str, emulated: &EmulatedRobot) -> Result<Self, LoopParameterError> {
        let t = emulated.robot.sample_time;
        let start = SimulatedRobot::new(emulated.robot)?;
        let robot = AtHandle {
            robot: start.clone(),
            tick: 0,
        };
        let mut moved = MovedRobot::new(robot, emulated.body.clone(), &emulated.limits, t)?;
        // Its sensor has rested before any host is there.
        for _ in 0..(emulated.limits.rest_time.0 / t.0) as usize + 2 {
            let _ = moved.idle();
        }
        let period_us = (1e6 * t.0).round() as u32;
        let mut capabilities = Capabilities {
            simulated: true,
            tick_period_min_us: period_us,
            tick_period_max_us: period_us,
            // Of the law; the robot itself has no force.
            force_max_n: 100.0,
            force_rate_max_n_per_s: 1e6,
            sensed_force_max_n: emulated.limits.sensor_range.0 as f32,
            position_resolution_m: emulated.robot.position_resolution.0 as f32,
            ..abilities(name, 1)
        };
        moved.declare(&mut capabilities);
        Ok(Self {
            moved,
            start,
            is_away: false,
            push_n: 0.0,
            capabilities,
        })
    }

    /// True position, m, and velocity, m/s, of the robot.
    #[cfg(test)]
    fn place(&self) -> [f64; 2] {
        let robot = &self.moved.robot().robot;
        [robot.position()[0], robot.velocity()[0]]
    }
}

/// Force of the hand in a run, N.
#[derive(Clone, Copy, Debug)]
pub(super) struct Push(f64);

impl PlantSetup for Push {
    fn prepare(simulation: &Simulation, _: u32) -> Result<Self, Refusal> {
        match simulation.kind {
            SimulationKind::Real => Ok(Self(0.0)),
            SimulationKind::MassDamper if simulation.push_n.is_finite() => {
                Ok(Self(simulation.push_n.into()))
            }
            SimulationKind::MassDamper
            | SimulationKind::RigidIndentation
            | SimulationKind::CompliantIndentation => {
                Err(Refusal::Unsupported(Field::SimulationKind))
            }
        }
    }
}

impl Device<f32, 1> for MovingBoard {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.moved.read()
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        self.moved.write(force)
    }

    fn let_go(&mut self) {
        self.stop();
    }

    fn stop(&mut self) {
        self.moved.stop();
    }

    fn moves(&self) -> bool {
        self.moved.moves()
    }
}

impl Hardware for MovingBoard {
    type Setup = Push;

    fn capabilities(&self) -> Capabilities {
        self.capabilities
    }

    fn controller_cost(&self) -> Option<ControllerCost> {
        Some(CONTROLLER_COST)
    }

    fn install(&mut self, setup: Push, _: u32) {
        self.push_n = setup.0;
    }

    fn restart(&mut self) {}

    fn drive(&mut self) -> Result<(), Refusal> {
        self.moved.drive()?;
        self.is_away = true;
        let push = [self.push_n].into();
        self.moved.robot_mut().robot.set_hand_force(push);
        Ok(())
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        if self.is_away && !self.moves() {
            self.moved.robot_mut().robot = self.start.clone();
            self.is_away = false;
        }
        self.moved.idle()
    }

    fn sense(&mut self) -> [f32; 1] {
        self.moved.sensed_n()
    }
}

#[cfg(test)]
mod tests;
