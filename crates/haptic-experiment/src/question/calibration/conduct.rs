//! The forces of a calibration on an armed axis, through the safety chain: they rise and fall slowly, and are held while a person reads.

use super::line::{Line, Point, line};
use super::{Answers, CALIBRATE_FORCE, CalibrationStep};
use crate::document::failure::Failure;
use crate::question::measurement::MeasurePlan;
use crate::question::measurement::drive::{DriveError, Outcome, Stoppable};
use crate::run::plant_file::calibration::Estimate;
use haptic_loop::realtime::Moment;
use haptic_loop::units::Seconds;
use haptic_loop::{Controller, Device, Engaged, Environment, SafetyChain};
use nalgebra::Vector1;
use num_complex::Complex;
use std::f64::consts::TAU;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Forces that are read, as shares of the largest, and if they are reached from above.
const LEVELS: [(f64, bool); 5] = [
    (1.0 / 3.0, false),
    (2.0 / 3.0, false),
    (1.0, false),
    (2.0 / 3.0, true),
    (1.0 / 3.0, true),
];
/// Lifts of a weight.
const LIFTS: usize = 3;
/// Time in which the force goes from zero to the largest, to settle, and over which is averaged, s.
const RAMP_S: f64 = 1.5;
const SETTLE_S: f64 = 0.7;
const MEAN_S: f64 = 0.3;
/// Frequencies of the sines, Hz; whole periods of each are seen in the time, s, after a wait.
const SINES_HZ: [f64; 4] = [1.0, 1.5, 2.5, 4.0];
const SINE_S: f64 = 2.0;
const WAIT_S: f64 = 1.0;
/// A handle that went so far has moved, m: more than encoders tremble.
const MOVED_M: f64 = 1e-4;
/// A weight that turned and went so far has left its stop, which yields, m.
const LIFTED_M: f64 = 5e-4;
/// A swing of the handle on which an encoder has some steps, m.
const SWINGS_M: f64 = 2e-5;
/// A motor is not left under force for longer.
const PATIENCE: Duration = Duration::from_secs(180);
pub(super) const WRONG_SIGN: &str = "the device goes against its force: swap the two leads of its motor, or the channels A and B of its encoder if positions fall where they should grow; then calibrate again";

/// Axis whose forces and sensor can be seen.
pub(super) trait Axis: Device<f64, 1> {
    /// Force that the device says it made in answer to the newest position, N, from the one that it was sent, and the reading of its force
    /// sensor, NaN without one.
    fn forces_n(&self, sent: f64) -> [f64; 2];
}

impl Axis for Stoppable<'_> {
    fn forces_n(&self, _: f64) -> [f64; 2] {
        [self.applied_n(), self.sensed_n()]
    }
}

/// A force that goes slowly to its target, this far in a tick, N, and a sine on it.
struct Slow(f64);

#[derive(Clone, Copy, Debug, Default)]
struct Level {
    now_n: f64,
    target_n: f64,
    /// Amplitude, N, and phase of a tick, rad.
    sine: (f64, f64),
    ticks: u64,
}

impl Environment<f64, 1> for Slow {
    type History = Level;

    fn at_rest(&self) -> Level {
        Level::default()
    }

    fn force(&self, level: &Level, _: &Vector1<f64>) -> Vector1<f64> {
        let (amplitude_n, step) = level.sine;
        Vector1::new(level.now_n + amplitude_n * libm::sin(step * level.ticks as f64))
    }

    fn advance(&self, level: &mut Level, _: &Vector1<f64>) {
        level.now_n += (level.target_n - level.now_n).clamp(-self.0, self.0);
        level.ticks += 1;
    }
}

/// The handle under a slow force.
pub(super) struct Handle<'a, V: Axis> {
    engaged: Engaged<f64, 1, Slow, &'a mut V, &'a mut Controller<f64, 1, Slow>>,
    plan: &'a MeasurePlan,
    stop: &'a AtomicBool,
}

type Ended<T, V> = Result<T, DriveError<<V as Device<f64, 1>>::Error>>;

impl<V: Axis> Handle<'_, V> {
    fn level(&mut self) -> &mut Level {
        self.engaged.controller_mut().law_mut().1
    }

    /// Position, m, and what the device says.
    fn tick(&mut self) -> Ended<(f64, Point), V> {
        let done = self.engaged.tick().map_err(DriveError::Device)?;
        let outcome = match done.fault {
            Some(fault) => Outcome::Fault(fault),
            None if self.stop.load(Ordering::Relaxed) => Outcome::Interrupted,
            None => Outcome::Complete,
        };
        outcome.require_complete(self.plan)?;
        let [commanded_n, sensed_n] = self.engaged.device().forces_n(done.force.newtons()[0]);
        let seen = Point {
            sensed_n,
            ..Point::rising(commanded_n, 0.0)
        };
        Ok((done.reading.position_m[0], seen))
    }

    /// Goes to a force until it is reached, or until `ends` of two ways along it, m: since the start, and since the handle turned. What was
    /// seen last, and the first of these ways.
    fn go(&mut self, target_n: f64, ends: impl Fn(f64, f64) -> bool) -> Ended<(Point, f64), V> {
        let along = f64::copysign(1.0, target_n - self.level().now_n);
        self.level().target_n = target_n;
        let first_m = along * self.tick()?.0;
        let mut least_m = first_m;
        loop {
            let (position_m, seen) = self.tick()?;
            let place_m = along * position_m;
            least_m = least_m.min(place_m);
            let level = self.level();
            if ends(place_m - first_m, place_m - least_m) {
                level.target_n = level.now_n;
            }
            if (level.now_n - level.target_n).abs() <= 0.0 {
                return Ok((seen, place_m - first_m));
            }
        }
    }

    /// Sees each tick of a time.
    fn watch(&mut self, time_s: f64, mut see: impl FnMut(f64, f64, Point)) -> Ended<(), V> {
        for tick in 0..(time_s / self.plan.sample_time_s).round() as u64 {
            let (position_m, seen) = self.tick()?;
            see(tick as f64, position_m, seen);
        }
        Ok(())
    }

    /// Mean of what the device says, once it has settled.
    fn settled(&mut self) -> Ended<Point, V> {
        self.watch(SETTLE_S, |_, _, _| ())?;
        let mut mean = Point::default();
        self.watch(MEAN_S, |tick, _, seen| {
            mean.commanded_n += (seen.commanded_n - mean.commanded_n) / (tick + 1.0);
            mean.sensed_n += (seen.sensed_n - mean.sensed_n) / (tick + 1.0);
        })?;
        Ok(mean)
    }

    /// The free handle goes with its force; what the sensor shows without force.
    pub(super) fn goes_with_its_force(&mut self) -> Ended<Point, V> {
        let idle = self.settled()?;
        // One that does not move may be held by the instrument already.
        let (_, way_m) = self.go(self.plan.force_n(), |way_m, _| way_m.abs() > MOVED_M)?;
        if way_m < -MOVED_M {
            return Err(Failure::run(WRONG_SIGN).into());
        }
        Ok(idle)
    }

    /// Forces at which a weight lifts and sinks; `hung_n` hangs on the handle.
    pub(super) fn lifts(&mut self, hung_n: f64) -> Ended<Vec<Point>, V> {
        let (most_n, mut points) = (self.plan.force_n(), Vec::new());
        // A weight that was hung swings.
        self.settled()?;
        for (what, falling) in [("lift", false), ("sink", true)].repeat(LIFTS) {
            let target_n = if falling { -most_n } else { most_n };
            let (seen, _) = self.go(target_n, |_, turned_m| turned_m > LIFTED_M)?;
            if (self.level().now_n - target_n).abs() <= 0.0 {
                return Err(Failure::run(format_args!(
                    "the handle does not {what} within {most_n} N: hang less, or give a larger {CALIBRATE_FORCE}"
                )).into());
            }
            points.push(Point {
                force_n: hung_n,
                falling,
                ..seen
            });
        }
        Ok(points)
    }

    /// Readings of an instrument under the handle, of this step, N; and the time by which the sensor follows, s.
    pub(super) fn reads(
        &mut self,
        answers: &mut Answers<'_>,
        step_n: f64,
    ) -> Ended<(Vec<Point>, Option<Estimate>), V> {
        let (most_n, mut points) = (self.plan.force_n(), Vec::<Point>::new());
        for (share, falling) in LEVELS {
            self.go(share * most_n, |_, _| false)?;
            let settled = self.settled()?;
            let step = CalibrationStep::read(settled.commanded_n, points.len() + 1, LEVELS.len());
            let began = Moment::now();
            let force_n = loop {
                self.tick()?;
                if let Some(force_n) = answers.poll(&step)? {
                    break force_n;
                }
                if began.elapsed() > PATIENCE {
                    return Err(Failure::run(
                        "no reading came for 3 minutes, and the force is zero: calibrate again",
                    )
                    .into());
                }
            };
            let top_n = points
                .iter()
                .fold(0.0, |most, point| f64::max(most, point.force_n.abs()));
            points.push(Point {
                force_n,
                falling,
                // Nothing is shown yet on the way up, still the most on the way down.
                held: if falling {
                    force_n.abs() > top_n - step_n
                } else {
                    force_n.abs() < step_n
                },
                ..settled
            });
        }
        Ok((points, self.lag_s(2.0 / 3.0 * most_n)?))
    }

    /// Time by which the sensor follows the spring of the instrument, by the slope of the phase over slow sines about this force; `None`
    /// without a sensor, or where the handle hardly moves.
    fn lag_s(&mut self, about_n: f64) -> Ended<Option<Estimate>, V> {
        self.go(about_n, |_, _| false)?;
        let (t, mut tangents) = (self.plan.sample_time_s, Vec::new());
        for frequency_hz in SINES_HZ {
            let step = TAU * frequency_hz * t;
            (self.level().sine, self.level().ticks) = ((0.5 * about_n, step), 0);
            self.watch(WAIT_S, |_, _, _| ())?;
            let (mut place, mut sensed) = (Complex::<f64>::default(), Complex::<f64>::default());
            self.watch(SINE_S, |tick, position_m, seen| {
                let turn = Complex::from_polar(1.0, -step * tick);
                (place, sensed) = (place + turn * position_m, sensed - turn * seen.sensed_n);
            })?;
            // Half an amplitude for each tick.
            if sensed.re.is_finite() && place.norm() > 0.5 * SWINGS_M * SINE_S / t {
                // That of a low pass of first order grows as its frequency.
                let tangent = libm::tan(-(sensed / place).arg());
                tangents.push(Point::rising(TAU * frequency_hz, tangent));
            }
        }
        self.level().sine = (0.0, 0.0);
        let line = line(&tangents, 0.0, 0.0, "").ok();
        // The sensor may be read a sample before the place, or after it.
        Ok(line.map(|Line { slope, .. }| Estimate {
            low: slope.low - t,
            high: slope.high + t,
            ..slope
        }))
    }
}

/// Lets `conduct` have the handle of an axis, within the limits of the plan; the force is zero when this returns.
pub(super) fn held<V: Axis, T>(
    plan: &MeasurePlan,
    axis: &mut V,
    stop: &AtomicBool,
    conduct: impl FnOnce(&mut Handle<'_, V>) -> Ended<T, V>,
) -> Ended<T, V> {
    let first = axis.read().map_err(DriveError::Device)?;
    let limits = plan.limits(first.position_m[0]);
    let chain = SafetyChain::from_limits(&limits, Seconds(plan.sample_time_s));
    let law = Slow(plan.force_n() * plan.sample_time_s / RAMP_S);
    let mut controller = Controller::<f64, 1, _>::new(law, chain.map_err(DriveError::Plan)?);
    // Whatever ends this function, no force stays.
    let mut handle = Handle {
        engaged: controller.engage(axis),
        plan,
        stop,
    };
    let done = conduct(&mut handle);
    let engaged = &mut handle.engaged;
    engaged.controller_mut().stop();
    while !matches!(done, Err(DriveError::Device(_))) && !engaged.controller().safety().is_at_rest()
    {
        engaged.tick().map_err(DriveError::Device)?;
    }
    done
}
