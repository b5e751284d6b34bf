//! The program's robot as a device: a virtual body between the force at its sensor and that of the law, behind the chain of motion.
//!
//! ```text
//! hb_sense, position ─▶ read: checked, f_m ─┐
//! law ─▶ safety chain ─▶ write: f_e ────────┴▶ body ─▶ MotionChain ─▶ velocity of the next call
//! ```
//! - *Rest*: each tick outside of a run watches the sensor, so that a robot that was let alone may be driven at once.
//! - *After a run, fault or stop* the ticks outside of it bring the command to rest, by the greatest deceleration, and hold it there.
//! - *In a run* the host sees the position of the command; before and after one, that of the robot.

use crate::description::Description;
use fracdiff::Seconds;
use fracdiff::portable::Form;
use haptic_link::Refusal;
use haptic_loop::units::{Metres, NewtonSecondsPerMetre, Newtons};
use haptic_loop::{
    Admittance, Device, Fault, LoopParameterError, MotionChain, MotionReading, MovingDevice,
    Reading, SafeForce, SafeMotion, VirtualBody,
};
use haptic_remote::{COEFFICIENTS_MAX, DeviceOperator};
use haptic_trial::robot::{BodyValues, RobotModel, rendered};
use nalgebra::SVector;
use std::convert::Infallible;

#[derive(Debug)]
pub(crate) struct Motion<const D: usize> {
    robot: Admittance<f32, D, DeviceOperator, Port<D>>,
    /// T, µs.
    period_us: u32,
}

/// Readings that the program has handed over, and the command for it.
#[derive(Debug)]
struct Port<const D: usize> {
    reading: MotionReading<f32, D>,
    command: SafeMotion<f32, D>,
}

impl<const D: usize> MovingDevice<f32, D> for Port<D> {
    type Error = Infallible;

    fn sense(&mut self) -> Result<MotionReading<f32, D>, Infallible> {
        Ok(self.reading)
    }

    fn command(&mut self, motion: SafeMotion<f32, D>) -> Result<(), Infallible> {
        self.command = motion;
        Ok(())
    }
}

/// `D^α` of a body, in single precision and in the memory of a device: nothing is allocated when it starts anew.
fn operator(body: &BodyValues, t: Seconds) -> Result<DeviceOperator, String> {
    let made = if let Some(lag_s) = body.lag_s {
        // y ← g·x − g·x₁ + k·y₁, as of a LaggedRate
        let (gain, kept) = (1.0 / (t.0 + lag_s), lag_s / (t.0 + lag_s));
        let values = [gain, -gain, -kept].map(|value| value as f32);
        DeviceOperator::new(Form::Recursion, 0, &values)
    } else {
        let order = body.operator.order();
        let built = rendered::<f32>(body.scheme, order, t).map_err(|error| error.to_string())?;
        let Some(list) = built.list() else {
            let scheme = body.scheme;
            return Err(format!(
                "body_scheme = {scheme} runs on no device: give full"
            ));
        };
        DeviceOperator::new(list.form, list.integer, &list.values)
    };
    made.map_err(|error| {
        format!("body_scheme has more than {COEFFICIENTS_MAX} taps, or another flaw ({error}): give full")
    })
}

impl<const D: usize> Motion<D> {
    /// The robot of a model, within the tighter of its limits and those of the description.
    pub(crate) fn new(description: &Description, model: &RobotModel) -> Result<Self, String> {
        let t = Seconds(f64::from(description.sample_time_us) * 1e-6);
        let limits = &model.limits;
        let [low, high] = [limits.low[0], limits.high[0]];
        let ends = std::array::from_fn::<_, D, _>(|axis| {
            let [from, to] = description.workspace(axis).map(f64::from);
            [from.max(low.0), to.min(high.0)].map(Metres)
        });
        let mut limits = limits.between(ends.map(|[low, _]| low), ends.map(|[_, high]| high));
        let range = description.sensed_force_max_n.min(limits.sensor_range.0);
        limits.sensor_range = Newtons(range);
        limits.force = Newtons(limits.force.0.min(0.5 * range));
        let words = |error: LoopParameterError| error.to_string();
        let chain = MotionChain::new(&limits, t).map_err(words)?;
        let body = &model.body;
        let damping = NewtonSecondsPerMetre(body.damping);
        let body = VirtualBody::new(body.inertance, damping, operator(body, t)?).map_err(words)?;
        let none = SVector::from([0.0; D]);
        let port = Port {
            reading: MotionReading {
                tick: 0,
                time_s: 0.0,
                position_m: none,
                sensed_force_n: none,
                force_age_s: 0.0,
            },
            command: SafeMotion::zero(),
        };
        Ok(Self {
            robot: Admittance::new(port, body, chain),
            period_us: description.sample_time_us,
        })
    }

    /// The next tick comes, after some that did not.
    pub(crate) fn goes_on(&mut self, skipped: u32) {
        let reading = &mut self.robot.robot_mut().reading;
        reading.tick += 1 + u64::from(skipped);
        reading.time_s = reading.tick as f64 * f64::from(self.period_us) * 1e-6;
    }

    /// Readings of this tick: m, N. One that is missing is not a number, which is a fault of motion.
    pub(crate) fn hand(&mut self, position_m: Option<[f32; D]>, sensed_n: [f32; D]) {
        let reading = &mut self.robot.robot_mut().reading;
        reading.position_m = SVector::from(position_m.unwrap_or([f32::NAN; D]));
        reading.sensed_force_n = SVector::from(sensed_n);
    }

    pub(crate) fn read(&mut self) -> Result<Reading<f32, D>, Fault> {
        let read = self.robot.read();
        read.map_err(|_| self.fault().unwrap_or(Fault::BoardFailed))
    }

    pub(crate) fn write(&mut self, force: SafeForce<f32, D>) -> Result<(), Fault> {
        self.robot.write(force).map_err(|_| Fault::BoardFailed)
    }

    /// A tick outside of a run: comes to rest, then rests.
    pub(crate) fn idle(&mut self) -> Result<Reading<f32, D>, Fault> {
        self.robot.stop();
        // A port never fails.
        let _ = self.robot.rest();
        let MotionReading {
            tick,
            time_s,
            position_m,
            ..
        } = self.robot.robot().reading;
        let position_m = if self.robot.state().is_at_rest() {
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

    /// Brakes from the next tick on.
    pub(crate) fn stop(&mut self) {
        self.robot.stop();
    }

    /// The law moves the robot from here on, where it stands.
    pub(crate) fn drive(&mut self) -> Result<(), Refusal> {
        let armed = self.robot.arm().map(|_| ());
        armed.map_err(|refused| {
            let fault = refused.of_loop();
            fault.map_or(Refusal::ForceNotZero, |fault| {
                Refusal::FaultPersists(fault.code())
            })
        })
    }

    pub(crate) fn moves(&self) -> bool {
        self.robot.moves()
    }

    pub(crate) fn fault(&self) -> Option<Fault> {
        self.robot.state().fault().map(|fault| fault.of_loop())
    }

    /// The command until the next tick, m/s.
    pub(crate) const fn command(&self) -> &SVector<f32, D> {
        self.robot.robot().command.metres_per_second()
    }
}
