//! The program's robot: readings that it has handed over, and the velocity of its next call.

use crate::description::Description;
use fracdiff::Seconds;
use haptic_loop::{
    LoopParameterError, MotionReading, MovingDevice, SafeMotion,
    units::{Metres, Newtons},
};
use haptic_remote::MovedRobot;
use haptic_trial::robot::OwnRobot;
use nalgebra::SVector;
use std::convert::Infallible;

/// The robot behind its body and its chain.
pub(crate) type Motion<const D: usize> = MovedRobot<Port<D>, D>;

/// Readings that the program has handed over, and the command for it.
#[derive(Debug)]
pub(crate) struct Port<const D: usize> {
    reading: MotionReading<f32, D>,
    command: SafeMotion<f32, D>,
    /// T, µs.
    period_us: u32,
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

/// The robot of a file, within the tighter of its limits and those of the description.
pub(crate) fn motion<const D: usize>(
    description: &Description,
    known: &OwnRobot,
) -> Result<Motion<D>, String> {
    let t = Seconds(f64::from(description.sample_time_us) * 1e-6);
    let limits = &known.limits;
    let [low, high] = [limits.low[0], limits.high[0]];
    let ends = std::array::from_fn::<_, D, _>(|axis| {
        let [from, to] = description.workspace(axis).map(f64::from);
        [from.max(low.0), to.min(high.0)].map(Metres)
    });
    let mut limits = limits.between(ends.map(|[low, _]| low), ends.map(|[_, high]| high));
    let range = description.sensed_force_max_n.min(limits.sensor_range.0);
    limits.sensor_range = Newtons(range);
    limits.force = Newtons(limits.force.0.min(0.5 * range));
    let body = (known.model.as_ref()).map(|model| model.body.on_device(t));
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
        period_us: description.sample_time_us,
    };
    MovedRobot::new(port, body.transpose()?, &limits, t)
        .map_err(|error: LoopParameterError| error.to_string())
}

impl<const D: usize> Port<D> {
    /// The next tick comes, after some that did not.
    pub(crate) fn goes_on(&mut self, skipped: u32) {
        let reading = &mut self.reading;
        reading.tick += 1 + u64::from(skipped);
        reading.time_s = reading.tick as f64 * f64::from(self.period_us) * 1e-6;
    }

    /// Readings of this tick: m, N. One that is missing is not a number, which is a fault of motion.
    pub(crate) fn hand(&mut self, position_m: Option<[f32; D]>, sensed_n: [f32; D]) {
        self.reading.position_m = SVector::from(position_m.unwrap_or([f32::NAN; D]));
        self.reading.sensed_force_n = SVector::from(sensed_n);
    }

    /// The command until the next tick, m/s.
    pub(crate) const fn command(&self) -> &SVector<f32, D> {
        self.command.metres_per_second()
    }
}
