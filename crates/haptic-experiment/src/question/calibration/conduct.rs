//! The forces of a calibration on an armed axis, through the safety chain: they rise and fall slowly, and are held while a person reads.

use super::{Person, Task, asked, line::Point};
use crate::question::measurement::serial::Stoppable;
use haptic_document::Failure;
use haptic_loop::{Controller, Device, Engaged, Environment, SafetyChain, units::Seconds};
use haptic_measurement::{
    MEASURE_FORCE_LIMIT, MeasurePlan,
    drive::{DriveError, DriveOutcome},
};
use haptic_quantity::written;
use haptic_trial::plant_file::calibration::MeasuredNumber;
use nalgebra::Vector1;
use num_complex::Complex;
use std::{
    f64::consts::TAU,
    sync::atomic::{AtomicBool, Ordering},
};

/// Forces that are read, in thirds of the largest; the last two are reached from above.
const LEVELS: [f64; 5] = [1.0, 2.0, 3.0, 2.0, 1.0];
/// Times that the handle lifts a weight and sinks with it.
const LIFTS: usize = 3;
/// Time in which the force goes from zero to the largest, to settle, and over which is averaged, s.
const RAMP_S: f64 = 1.5;
const SETTLE_S: f64 = 1.0;
const MEAN_S: f64 = 0.1;
/// Period of the sine that shows the lag, s, and periods of it, the first of which are not seen.
const SINE_S: f64 = 0.25;
const SINES: usize = 8;
const UNSEEN: usize = 2;
/// A handle that turned and went so far has moved, m: more than a stop yields and encoders tremble.
const MOVED_M: f64 = 5e-4;
/// A swing of the handle on which an encoder has some steps, m.
const SWINGS_M: f64 = 2e-5;
/// A motor is not left under force for longer, s.
const PATIENCE_S: f64 = 180.0;
/// No way of a handle is as long, m.
const FAR: f64 = f64::INFINITY;

#[derive(Debug, Default)]
pub(super) struct Found {
    pub points: Vec<Point>,
    /// The free handle at rest, without a weight on it.
    pub idle: Point,
    /// Time by which the sensor follows, s.
    pub lag_s: Option<MeasuredNumber>,
}

/// Axis whose forces and sensor can be seen.
pub(super) trait Axis: Device<f64, 1> {
    /// Force that the device says it made in answer to the newest position, N, from the one that it was sent, and the reading of its force
    /// sensor, NaN without one.
    fn forces_n(&self, sent: f64) -> [f64; 2];
}

impl Axis for Stoppable<'_> {
    fn forces_n(&self, _: f64) -> [f64; 2] {
        self.forces_n()
    }
}

/// A force that is held, N.
struct Level;

impl Environment<f64, 1> for Level {
    type History = f64;

    fn at_rest(&self) -> f64 {
        0.0
    }

    fn force(&self, held_n: &f64, _: &Vector1<f64>) -> Vector1<f64> {
        Vector1::new(*held_n)
    }

    fn advance(&self, _: &mut f64, _: &Vector1<f64>) {}
}

/// A bench with somebody at it.
pub(super) struct Bench<'a> {
    pub plan: MeasurePlan,
    pub person: &'a Person,
    /// Smallest step of the instrument, N.
    pub step_n: f64,
    pub stop: &'a AtomicBool,
}

/// The handle under a slow force.
struct Handle<'a, V: Axis> {
    engaged: Engaged<f64, 1, Level, &'a mut V, &'a mut Controller<f64, 1, Level>>,
    bench: &'a Bench<'a>,
    force_n: f64,
}

type Ended<T, V> = Result<T, DriveError<<V as Device<f64, 1>>::Error>>;

impl<V: Axis> Handle<'_, V> {
    /// A tick under the force and so much more, N: position, m, and what the device says.
    fn tick(&mut self, more_n: f64) -> Ended<(f64, Point), V> {
        *self.engaged.controller_mut().law_mut().1 = self.force_n + more_n;
        let done = self.engaged.tick().map_err(DriveError::Device)?;
        let outcome = match done.fault {
            Some(fault) => DriveOutcome::Fault(fault),
            None if self.bench.stop.load(Ordering::Relaxed) => DriveOutcome::Interrupted,
            None => DriveOutcome::Complete,
        };
        outcome.require_complete(&self.bench.plan)?;
        let [commanded_n, sensed_n] = self.engaged.device().forces_n(done.force.newtons()[0]);
        let seen = Point {
            commanded_n,
            sensed_n,
            ..Point::default()
        };
        Ok((done.reading.position_m[0], seen))
    }

    /// Goes to a force until the handle turned and went so far along it, m: what was seen last, if it did. Going as far against it as
    /// `against_m` is refused.
    fn go(&mut self, target_n: f64, far_m: f64, against_m: f64) -> Ended<Option<Point>, V> {
        let along = f64::copysign(1.0, target_n - self.force_n);
        let step_n = self.bench.plan.force_n() * self.bench.plan.sample_time_s / RAMP_S;
        let (first_m, _) = self.tick(0.0)?;
        let mut least_m = FAR;
        loop {
            let (position_m, seen) = self.tick(0.0)?;
            let way_m = along * (position_m - first_m);
            least_m = least_m.min(way_m);
            if way_m - least_m > far_m {
                return Ok(Some(seen));
            }
            if way_m < -against_m {
                DriveOutcome::Against(seen.commanded_n).require_complete(&self.bench.plan)?;
            }
            let left_n = target_n - self.force_n;
            if left_n.abs() <= 0.0 {
                return Ok(None);
            }
            self.force_n += left_n.clamp(-step_n, step_n);
        }
    }

    /// Mean of what the device says, once it has settled.
    fn settled(&mut self) -> Ended<Point, V> {
        let (mut mean, t) = (self.tick(0.0)?.1, self.bench.plan.sample_time_s);
        for _ in 0..(SETTLE_S / t) as u64 {
            let (_, seen) = self.tick(0.0)?;
            mean.commanded_n += t / MEAN_S * (seen.commanded_n - mean.commanded_n);
            mean.sensed_n += t / MEAN_S * (seen.sensed_n - mean.sensed_n);
        }
        Ok(mean)
    }

    /// Forces at which the handle lifts and sinks with this weight on it, N; the free handle must go with its force.
    fn lifts(&mut self, hung_n: f64, found: &mut Found) -> Ended<(), V> {
        let (most_n, is_free) = (self.bench.plan.force_n(), hung_n <= 0.0);
        // A weight that was hung swings.
        let idle = self.settled()?;
        if is_free {
            found.idle = idle;
        }
        let ways = [(most_n, "lift"), (-most_n, "sink")].repeat(LIFTS);
        for (way, (target_n, words)) in ways.into_iter().enumerate() {
            let against_m = if is_free && way == 0 { MOVED_M } else { FAR };
            let seen = self.go(target_n, MOVED_M, against_m)?.ok_or_else(|| {
                Failure::run(format_args!(
                    "the handle does not {words} within {}: free it, hang less, or give a larger {MEASURE_FORCE_LIMIT}",
                    written("force_n", most_n)
                ))
            })?;
            found.points.push(Point {
                force_n: hung_n,
                falling: target_n < 0.0,
                ..seen
            });
        }
        Ok(())
    }

    /// Readings of an instrument under the handle, and the lag of the sensor.
    fn reads(&mut self, found: &mut Found) -> Ended<(), V> {
        let (bench, mut top_n) = (self.bench, 0.0_f64);
        let third_n = bench.plan.force_n() / 3.0;
        // The free handle was at another place.
        found.points.clear();
        for (reading, thirds) in LEVELS.into_iter().enumerate() {
            self.go(thirds * third_n, FAR, FAR)?;
            let settled = self.settled()?;
            let words = format!(
                "reading {} of 5, at {} commanded: once it is steady, what does the instrument show?",
                reading + 1,
                written("force_n", settled.commanded_n)
            );
            let mut left_s = PATIENCE_S;
            let force_n = asked(bench.person, words, Some(settled.commanded_n), || {
                self.tick(0.0)?;
                left_s -= bench.plan.sample_time_s;
                if left_s > 0.0 {
                    Ok(())
                } else {
                    Err(DriveError::from(Failure::run(
                        "no reading came for 3 minutes, and the force is zero: calibrate again",
                    )))
                }
            })?;
            // Friction holds the handle where it was if nothing is shown yet on the way up, or still the most on the way down.
            let falling = reading > 2;
            let held = if falling {
                force_n.abs() > top_n - bench.step_n
            } else {
                force_n.abs() < bench.step_n
            };
            top_n = top_n.max(force_n.abs());
            if !held {
                found.points.push(Point {
                    force_n,
                    falling,
                    ..settled
                });
            }
        }
        found.lag_s = self.lag_s(2.0 * third_n)?;
        Ok(())
    }

    /// Time by which the sensor follows the spring of the instrument, by the phase of a sine about this force; `None` without a sensor, or
    /// where the handle hardly moves.
    fn lag_s(&mut self, about_n: f64) -> Ended<Option<MeasuredNumber>, V> {
        self.go(about_n, FAR, FAR)?;
        let (t, mut ends) = (self.bench.plan.sample_time_s, [FAR, -FAR]);
        // A period is a whole number of ticks.
        let ticks = (SINE_S / t).round();
        for sine in 0..SINES {
            let mut sums = [Complex::<f64>::default(); 2];
            for tick in 0..ticks as u64 {
                let (sin, cos) = libm::sincos(TAU / ticks * tick as f64);
                let turn = Complex::new(cos, -sin);
                let (position_m, seen) = self.tick(-0.5 * about_n * turn.im)?;
                // The sensor shows the force on the device, which is against that on the instrument.
                sums = [sums[0] + turn * position_m, sums[1] - turn * seen.sensed_n];
            }
            let [place, sensed] = sums;
            let behind = sensed / place;
            // Half an amplitude for each tick; the tangent of a low pass of first order grows as its lag.
            let lag_s = -behind.im / behind.re * ticks * t / TAU;
            if !(lag_s.is_finite() && place.norm() > 0.5 * SWINGS_M * ticks) {
                return Ok(None);
            }
            if sine >= UNSEEN {
                ends = [ends[0].min(lag_s), ends[1].max(lag_s)];
            }
        }
        // The sensor may be read a sample before the place, or after it.
        let [low, high] = ends;
        Ok(Some(MeasuredNumber::about(
            0.5 * (low + high),
            0.5 * (high - low) + t,
        )))
    }
}

/// A task of an armed axis, within the limits of the plan.
pub(super) fn done<V: Axis>(
    bench: &Bench<'_>,
    axis: &mut V,
    task: Task,
    found: &mut Found,
) -> Ended<(), V> {
    let (first, plan) = (axis.read().map_err(DriveError::Device)?, &bench.plan);
    let limits = plan.limits(first.position_m[0]);
    let chain = SafetyChain::from_limits(&limits, Seconds(plan.sample_time_s));
    let mut controller = Controller::<f64, 1, _>::new(Level, chain.map_err(DriveError::Plan)?);
    // Whatever ends this function, no force stays.
    let mut handle = Handle {
        engaged: controller.engage(axis),
        bench,
        force_n: 0.0,
    };
    match task {
        Some(hung_n) => handle.lifts(hung_n, found)?,
        None => handle.reads(found)?,
    }
    handle.go(0.0, FAR, FAR).map(drop)
}
