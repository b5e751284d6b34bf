//! A robot that takes a velocity, as the device of a loop: a virtual body between the force at its sensor and that of the law, behind the
//! chain of motion.
//!
//! ```text
//! position, force at the sensor ─▶ read: checked, f_m ─┐
//! law ─▶ safety chain ─▶ write: f_e ───────────────────┴▶ body ─▶ MotionChain ─▶ velocity of the next tick
//! ```
//! - *Rest*: each tick outside of a run watches the sensor, so that a robot that was let alone may be driven at once.
//! - *After a run, fault or stop* the ticks outside of it bring the command to rest, by the greatest deceleration, and hold it there.
//! - *In a run* the host sees the position of the command; before and after one, that of the robot.
//! - *Without a body* it is to be measured: only forces of the law move it, 100 N for each metre per second and at most 50 mm/s, and the host
//!   always sees the position of the robot. A hand at the handle is a fault from half of the limit of its force on.

use crate::prepared::DeviceOperator;
use haptic_link::{Capabilities, MEASURING_DAMPING_N_S_PER_M, Refusal};
use haptic_loop::{
    Admittance, Device, Fault, LoopParameterError, MotionChain, MotionLimits, MotionReading,
    MovingDevice, Reading, SafeForce, VirtualBody,
    units::{MetresPerSecond, NewtonSecondsPerMetre, Seconds},
};

/// Largest speed of a robot that is to be measured, m/s.
const MEASURED_AT_MOST: f64 = 0.05;

/// A robot with D axes, its body and its chain of motion: the part of a [`Hardware`](crate::Hardware) that moves.
#[derive(Debug)]
pub struct MovedRobot<R: MovingDevice<f32, D>, const D: usize = 1> {
    robot: Admittance<f32, D, DeviceOperator, R>,
    /// Largest force and its rate, N and N/s, of one that is to be measured.
    measuring: Option<[f32; 2]>,
}

impl<R: MovingDevice<f32, D>, const D: usize> MovedRobot<R, D> {
    /// A robot that stands still; without a body it is to be measured.
    ///
    /// # Errors
    /// A limit outside its range.
    pub fn new(
        robot: R,
        body: Option<VirtualBody<f32, DeviceOperator>>,
        limits: &MotionLimits<D>,
        sample_time: Seconds,
    ) -> Result<Self, LoopParameterError> {
        let (mut limits, damping) = (*limits, f64::from(MEASURING_DAMPING_N_S_PER_M));
        let mut measuring = None;
        let body = if let Some(body) = body {
            body
        } else {
            let speed = f64::min(limits.speed.0, MEASURED_AT_MOST);
            // A rate that rounding takes beyond the limit would not be the one that is asked for.
            let rate = 0.99 * limits.acceleration.0;
            measuring = Some([damping * speed, damping * rate].map(|most| most as f32));
            limits.speed = MetresPerSecond(speed);
            limits.speed_norm = Some(limits.speed);
            limits.force.0 *= 0.5;
            // The hand is no part of what is measured.
            limits.dead_band = limits.sensor_range;
            (limits.stuck, limits.hand_energy) = (None, None);
            VirtualBody::new(0.0, NewtonSecondsPerMetre(damping), DeviceOperator::SILENT)?
        };
        let chain = MotionChain::new(&limits, sample_time)?;
        Ok(Self {
            robot: Admittance::new(robot, body, chain),
            measuring,
        })
    }

    /// Abilities of such a device.
    pub const fn declare(&self, capabilities: &mut Capabilities) {
        capabilities.lets_go_alone.moves = true;
        if let Some([force_n, rate_n_per_s]) = self.measuring {
            capabilities.lets_go_alone.to_measure = true;
            capabilities.force_max_n = force_n;
            capabilities.force_rate_max_n_per_s = rate_n_per_s;
        }
    }

    /// The robot that is moved, as its driver knows it.
    pub const fn robot(&self) -> &R {
        self.robot.robot()
    }

    /// The robot itself, for what is around it.
    pub const fn robot_mut(&mut self) -> &mut R {
        self.robot.robot_mut()
    }

    /// A tick outside of a run: comes to rest, then rests.
    ///
    /// # Errors
    /// The robot gives no position.
    pub fn idle(&mut self) -> Result<Reading<f32, D>, Fault> {
        self.robot.stop();
        let rested = self.robot.rest();
        let last = rested.ok().and_then(|()| self.robot.reading());
        let MotionReading {
            tick,
            time_s,
            position_m,
            ..
        } = *last.ok_or(Fault::BoardFailed)?;
        let position_m = if self.robot.state().is_at_rest() || self.measuring.is_some() {
            position_m
        } else {
            *self.robot.state().position_m()
        };
        if !position_m.iter().all(|axis| axis.is_finite()) {
            return Err(Fault::BoardFailed);
        }
        Ok(Reading {
            tick,
            time_s,
            position_m,
        })
    }

    /// The law moves the robot from here on, where it stands.
    ///
    /// # Errors
    /// As [`MotionChain::arm`].
    pub fn drive(&mut self) -> Result<(), Refusal> {
        let armed = self.robot.arm().map(|_| ());
        armed.map_err(|refused| {
            let fault = refused.of_loop();
            fault.map_or(Refusal::ForceNotZero, |fault| {
                Refusal::FaultPersists(fault.code())
            })
        })
    }

    /// Reading of the force sensor in this tick, N.
    pub fn sensed_n(&self) -> [f32; D] {
        let last = self.robot.reading();
        last.map_or([f32::NAN; D], |last| last.sensed_force_n.into())
    }

    /// The fault of its motion.
    pub fn fault(&self) -> Option<Fault> {
        self.robot.state().fault().map(|fault| fault.of_loop())
    }
}

impl<R: MovingDevice<f32, D>, const D: usize> Device<f32, D> for MovedRobot<R, D> {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, D>, Fault> {
        let read = self.robot.read();
        let mut reading = read.map_err(|_| self.fault().unwrap_or(Fault::BoardFailed))?;
        if let (Some(_), Some(last)) = (self.measuring, self.robot.reading()) {
            reading.position_m = last.position_m;
        }
        Ok(reading)
    }

    fn write(&mut self, force: SafeForce<f32, D>) -> Result<(), Fault> {
        self.robot.write(force).map_err(|_| Fault::BoardFailed)
    }

    fn let_go(&mut self) {
        self.stop();
    }

    fn stop(&mut self) {
        self.robot.stop();
    }

    fn moves(&self) -> bool {
        self.robot.moves()
    }
}
