//! Dead time, bandwidth and damping of a robot that takes a velocity, from small steps of it.
//!
//! ```text
//! x(s) = x₀ + g·G(s)·e^(−τs)·v(s)/s        G = ω²/(s² + 2ζω·s + ω²)        v held from tick to tick
//! ```
//! *Excitation*: v, of some 60 to 97 % of the speed that is given, goes from one way to the other after times of `HOLDS_S`, and earlier where the robot is `TURNS` of the box away from
//! its start. The forces that command it, [`MEASURING_DAMPING_N_S_PER_M`] for each m/s, have passed the safety chain here, that of the device,
//! and the robot's own chain of motion, within whose limits of speed and acceleration they are.
//!
//! *Estimation*: least squares over (ω, ζ, τ, g, x₀) by Gauss–Newton from the best of a grid; the model is exact for a fraction of a sample of
//! dead time. Intervals treat pieces of the motion as independent, so that residuals of an encoder and of a robot that is no such loop may be
//! correlated within them:
//!
//! ```text
//! cov = Σ over K pieces of d_k·d_kᵀ,   d_k = (A − A_k)⁻¹·J_kᵀ·r_k,   A_k = J_kᵀ·J_k,   A = Σ A_k        or σ²·A⁻¹, where that is more
//! ```

use crate::{
    MeasurePlan, MotionRecord,
    drive::{DriveError, DriveOutcome},
};
use fracdiff::{Real, linear_motion};
use haptic_document::{Failure, Interval};
use haptic_link::MEASURING_DAMPING_N_S_PER_M;
use haptic_loop::{Controller, Device, Environment, Fault, SafetyChain, units::Seconds};
use haptic_trial::{
    keys::admittance::{ROBOT_BANDWIDTH, ROBOT_DAMPING, ROBOT_DEAD_TIME},
    plant_file::calibration::MeasuredNumber,
};
use nalgebra::{SMatrix, SVector, Vector1};
use serde::Serialize;
use std::{
    f64::consts::TAU,
    sync::atomic::{AtomicBool, Ordering},
};

/// Times for which a velocity is held, s: long ones show the loop at rest, short ones how it begins.
const HOLDS_S: [f64; 8] = [0.4, 0.05, 0.1, 0.03, 0.2, 0.05, 0.15, 0.07];
/// Share of the box at which it turns back in any case.
const TURNS: f64 = 0.6;
/// Pieces of a motion whose residuals are taken for independent.
const PIECES: usize = 40;
const NUMBERS: usize = 5;
const STEPS: usize = 60;
/// Shares of a velocity that a robot may lack: a warning from the first on, a refusal from the second on.
const OFF: [f64; 2] = [0.02, 0.2];

/// The law: velocities to and fro.
#[derive(Clone, Copy, Debug)]
struct Steps {
    force_n: f64,
    sample_time_s: f64,
    ticks: u64,
    turns_m: f64,
}

/// See [`Steps`].
#[derive(Clone, Copy, Debug, Default)]
struct Course {
    tick: u64,
    start_m: Option<f64>,
    /// Number of the hold, and ticks since it began.
    hold: usize,
    since: u64,
    backwards: bool,
}

impl<F: Real> Environment<F, 1> for Steps {
    type History = Course;

    fn at_rest(&self) -> Course {
        // The first is half as long: the middle of the motion is where it began.
        Course {
            since: (0.5 * HOLDS_S[0] / self.sample_time_s) as u64,
            ..Course::default()
        }
    }

    fn force(&self, course: &Course, _: &Vector1<F>) -> Vector1<F> {
        // Each by another speed, of which no encoder counts a whole number of steps in every tick.
        let part = 0.618_034 * course.hold as f64;
        let force = self.force_n * (0.97 - 0.4 * (part - libm::floor(part)));
        let force = if course.tick >= self.ticks {
            0.0
        } else if course.backwards {
            -force
        } else {
            force
        };
        Vector1::new(F::from_f64(force))
    }

    fn advance(&self, course: &mut Course, position_m: &Vector1<F>) {
        let position_m = position_m[0].to_f64();
        let away = position_m - *course.start_m.get_or_insert(position_m);
        let outwards = if course.backwards { -away } else { away };
        course.tick += 1;
        course.since += 1;
        let held_s = course.since as f64 * self.sample_time_s;
        if outwards > self.turns_m || held_s >= HOLDS_S[course.hold % HOLDS_S.len()] {
            course.backwards = !course.backwards;
            (course.hold, course.since) = (course.hold + 1, 0);
        }
    }
}

impl MeasurePlan {
    /// This plan for a robot.
    #[must_use]
    pub fn of_robot(self) -> Self {
        let force_n = self.speed_m_per_s * f64::from(MEASURING_DAMPING_N_S_PER_M);
        Self {
            force_limit_n: force_n / Self::SHARE,
            ..self
        }
    }
}

/// Moves a robot to and fro. `applied` gives the force that the device really applied in a tick; `progress` hears the number of ticks.
///
/// Whatever ends it, the force is zero when this returns.
///
/// # Errors
/// An end before the last step; a device that did not follow, or limits that make no safety chain.
pub fn drive_robot<F: Real, V: Device<F, 1>>(
    plan: &MeasurePlan,
    device: &mut V,
    applied: &mut dyn FnMut(&V, f64) -> f64,
    progress: &dyn Fn(u64),
    stop: &AtomicBool,
) -> Result<MotionRecord, DriveError<V::Error>> {
    let mut reading = device.read().map_err(DriveError::Device)?;
    let limits = plan.limits(reading.position_m[0].to_f64());
    let chain = SafetyChain::from_limits(&limits, Seconds(plan.sample_time_s));
    let steps = Steps {
        force_n: plan.force_n(),
        sample_time_s: plan.sample_time_s,
        ticks: plan.ticks(plan.duration_s),
        turns_m: TURNS * plan.box_m,
    };
    let mut controller = Controller::<F, 1, _>::new(steps, chain.map_err(DriveError::Plan)?);
    let mut engaged = controller.engage(device);
    let mut record = MotionRecord::with_capacity(plan.sample_time_s, steps.ticks as usize);
    let (mut next, mut outcome) = (reading.tick, None);
    loop {
        let done = engaged.tick_reading(reading).map_err(DriveError::Device)?;
        if outcome.is_none() {
            let force = applied(engaged.device(), done.force.newtons()[0].to_f64());
            let missing = reading.tick.saturating_sub(next);
            record.push(missing, reading.position_m[0].to_f64(), force);
            progress(record.len() as u64);
            let is_over = engaged.controller_mut().law_mut().1.tick >= steps.ticks;
            outcome = match done.fault {
                Some(fault) => Some(DriveOutcome::Fault(fault)),
                None if stop.load(Ordering::Relaxed) => Some(DriveOutcome::Interrupted),
                None => is_over.then_some(DriveOutcome::Complete),
            };
            if outcome.is_some() {
                engaged.controller_mut().stop();
            }
        }
        next = reading.tick + 1;
        if let (Some(outcome), true) = (outcome, engaged.controller().safety().is_at_rest()) {
            complete(outcome, plan)?;
            return Ok(record);
        }
        reading = engaged.read().map_err(DriveError::Device)?;
    }
}

const STANDS: &str = "the robot does not move: check that its program sends the velocity to it, and the position of its sensor";

/// Refuses all but a motion that came to its end, in words of a robot.
fn complete(outcome: DriveOutcome, plan: &MeasurePlan) -> Result<(), Failure> {
    let words = if outcome == DriveOutcome::Fault(Fault::PositionStuck) {
        STANDS
    } else if outcome == DriveOutcome::Fault(Fault::Workspace) {
        "the robot left its box, and stands: give a smaller speed, or check the direction of its sensor"
    } else {
        return outcome.require_complete(plan);
    };
    Err(Failure::run(words))
}

/// A robot as estimated from a record.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasuredRobot {
    /// ω/2π.
    pub bandwidth_hz: MeasuredNumber,
    /// ζ of its velocity loop, a pure number.
    pub damping_ratio: MeasuredNumber,
    /// τ, from a command to the first change of velocity.
    pub dead_time_s: MeasuredNumber,
    /// g, its speed over the commanded one.
    pub gain: MeasuredNumber,
    /// Root mean square of model minus record.
    pub residual_rms_m: f64,
    /// Ticks of the motion, lost ones too.
    pub samples: usize,
    /// Those of which no position came.
    pub lost_samples: usize,
    /// Facts that a user should know.
    pub warnings: Vec<String>,
    /// Time since the start, s, position read and position of the model, m, of each tick.
    #[serde(skip)]
    pub curve: Vec<[f64; 3]>,
}

impl MeasuredRobot {
    /// Bandwidth, damping ratio and dead time, with the key of each.
    fn named(&self) -> [(&'static str, MeasuredNumber); 3] {
        [
            (ROBOT_BANDWIDTH.key, self.bandwidth_hz),
            (ROBOT_DAMPING.key, self.damping_ratio),
            (ROBOT_DEAD_TIME.key, self.dead_time_s),
        ]
    }

    /// Text of the device file, made by this program.
    #[must_use]
    pub fn device_file(&self, program: &str, note: &str) -> String {
        let six = |value: f64| format!("{value:.5e}").parse().unwrap_or(value);
        let named = self.named();
        let intervals = named.map(|(key, MeasuredNumber { low, high, .. })| Interval {
            key,
            low: six(low),
            high: six(high),
        });
        let values = named.map(|(_, number)| six(number.value));
        haptic_trial::robot::measured_file(values, &intervals, program, note)
    }
}

/// A motion, as the fit has it.
struct Motion<'a> {
    record: &'a MotionRecord,
    velocity: Vec<f64>,
}

impl Motion<'_> {
    /// The position of the model at each tick from 0 on, m: (ln ω·T, ln ζ, τ/T).
    fn model(&self, [rate, damping, late]: [f64; 3]) -> Vec<f64> {
        let (rate, damping) = (libm::exp(rate), libm::exp(damping));
        // x′ = v, v′ = ω·z, z′ = ω·(u − v) − 2ζω·z; by columns, in samples.
        let a = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, -rate],
            [0.0, rate, -2.0 * damping * rate],
        ]
        .concat();
        let (whole, part) = (libm::floor(late), late - libm::floor(late));
        let whole = whole.max(0.0) as usize;
        let parts = [part, 1.0 - part].map(|time| linear_motion(&a, &[0.0, 0.0, rate], time));
        let at = |tick: usize, age: usize| {
            let tick = tick.checked_sub(age);
            tick.map_or(0.0, |tick| self.velocity[tick])
        };
        let mut state = [0.0; 3];
        let ticks = 0..self.record.len();
        let positions = ticks.map(|tick| {
            let position = state[0];
            for ((moved, input), age) in parts.iter().zip([whole + 1, whole]) {
                let (u, [x, v, z]) = (at(tick, age), state);
                state = [0, 1, 2].map(|row| {
                    let more = moved[row] * x + moved[row + 3] * v + moved[row + 6] * z;
                    state[row] + more + input[row] * u
                });
            }
            position * self.record.sample_time_s
        });
        positions.collect()
    }

    /// Residuals of g·model + x₀ with the best g and x₀, those two, and the model; 0 where nothing is known.
    fn left(&self, theta: [f64; 3]) -> (Vec<f64>, [f64; 2], Vec<f64>) {
        let model = self.model(theta);
        let read = &self.record.position_m;
        let known = || model.iter().zip(read).filter(|(_, x)| x.is_finite());
        let count = known().count().max(1) as f64;
        let mean = known().fold([0.0; 2], |[y, x], (a, b)| [y + a / count, x + b / count]);
        let sums = known().fold([0.0; 2], |[yy, yx], (y, x)| {
            let y = y - mean[0];
            [yy + y * y, yx + y * (x - mean[1])]
        });
        let gain = sums[1] / sums[0];
        let offset = mean[1] - gain * mean[0];
        let left = model.iter().zip(read).map(|(y, x)| {
            if x.is_finite() {
                gain * y + offset - x
            } else {
                0.0
            }
        });
        (left.collect(), [gain, offset], model)
    }

    /// Sum of squares of the residuals.
    fn error(&self, place: [f64; 3]) -> f64 {
        let error: f64 = self.left(numbers(place)).0.iter().map(|r| r * r).sum();
        if error.is_finite() {
            error
        } else {
            f64::INFINITY
        }
    }

    /// Slopes of the residuals over what `of` makes ln ω, ln ζ and τ of, over g and x₀; the residuals, and g.
    fn slopes(
        &self,
        place: [f64; 3],
        of: fn([f64; 3]) -> [f64; 3],
    ) -> (Vec<Slopes>, Vec<f64>, f64) {
        let (left, [gain, _], model) = self.left(of(place));
        let step = 1e-6;
        let moved = [0, 1, 2].map(|number| {
            let mut moved = place;
            moved[number] += step;
            self.model(of(moved))
        });
        let slopes = model.iter().enumerate().map(|(tick, y)| {
            let is_known = self.record.position_m[tick].is_finite();
            let [a, b, c] = [0, 1, 2].map(|number| gain * (moved[number][tick] - y) / step);
            let slopes = Slopes::from([a, b, c, *y, 1.0]);
            slopes * f64::from(u8::from(is_known))
        });
        (slopes.collect(), left, gain)
    }
}

/// Slopes of a residual over the numbers of the model.
type Slopes = SVector<f64, NUMBERS>;
type Square = SMatrix<f64, NUMBERS, NUMBERS>;

/// `JᵀJ` and `Jᵀr`.
fn products(slopes: &[Slopes], left: &[f64]) -> (Square, Slopes) {
    let (mut normal, mut gradient) = (Square::zeros(), Slopes::zeros());
    for (slopes, left) in slopes.iter().zip(left) {
        for row in 0..NUMBERS {
            gradient[row] += slopes[row] * left;
            for column in row..NUMBERS {
                normal[(row, column)] += slopes[row] * slopes[column];
            }
        }
    }
    normal.fill_lower_triangle_with_upper_triangle();
    (normal, gradient)
}

/// ln ω, ln ζ and τ of the logarithm of the whole lag, τ + 2ζ/ω, of ln ζ, and of the share of τ in that lag: numbers of which each shows by itself.
fn numbers([lag, damping, share]: [f64; 3]) -> [f64; 3] {
    let lag = libm::exp(lag);
    let rate = 2.0 * libm::exp(damping) / ((1.0 - share) * lag);
    [libm::log(rate), damping, share * lag]
}

/// Dead time, bandwidth and damping of a robot from its motion.
///
/// # Errors
/// A robot that hardly moved, or did not do what it was told; a loop that this motion does not determine.
pub fn estimate_robot(record: &MotionRecord) -> Result<MeasuredRobot, Failure> {
    let t = record.sample_time_s;
    let per_newton = 1.0 / f64::from(MEASURING_DAMPING_N_S_PER_M);
    let velocity = record.force_n.iter().map(|force| force * per_newton);
    let motion = Motion {
        record,
        velocity: velocity.collect(),
    };
    let (low, high) = record.reach_m();
    if high - low < 1e-6 {
        return Err(Failure::run(STANDS));
    }
    let undetermined = || {
        Failure::run(
            "this motion determines no loop of the robot: give a larger speed and box, or a longer duration",
        )
    };
    // The whole lag, from half a sample to 0.3 s, is the number that shows most.
    let mut best = ([0.0; 3], f64::INFINITY);
    let mut try_at = |place: [f64; 3]| {
        let error = motion.error(place);
        if error < best.1 {
            best = (place, error);
        }
        best
    };
    let lags = (0..30).map(|n| libm::log(0.5) + libm::log(0.6 / t) * f64::from(n) / 29.0);
    for lag in lags {
        try_at([lag, libm::log(0.8), 0.3]);
    }
    let lag = try_at([f64::NAN; 3]).0[0];
    for damping in [0.4_f64, 0.8, 1.6] {
        for share in [0.0, 0.25, 0.5, 0.75] {
            try_at([lag, libm::log(damping), share]);
        }
    }
    let (mut place, mut least) = try_at([lag, libm::log(0.8), 0.3]);
    let mut weight = 1e-3;
    for _ in 0..STEPS {
        let (slopes, left, _) = motion.slopes(place, numbers);
        let (mut weighted, gradient) = products(&slopes, &left);
        for n in 0..NUMBERS {
            weighted[(n, n)] *= 1.0 + weight;
        }
        let step = weighted.lu().solve(&gradient).ok_or_else(undetermined)?;
        let tried = [0, 1, 2].map(|n| place[n] - step[n]);
        // A dead time below 0 is none.
        let tried = [tried[0], tried[1], tried[2].clamp(0.0, 0.999)];
        let error = motion.error(tried);
        if error < least {
            let gained = least - error > 1e-10 * least;
            (place, least) = (tried, error);
            if !gained {
                break;
            }
            weight *= 0.1;
        } else if weight > 1e9 {
            break;
        } else {
            weight *= 10.0;
        }
    }
    let theta = numbers(place);
    let (slopes, left, gain) = motion.slopes(theta, |theta| theta);
    let (normal, _) = products(&slopes, &left);
    let known = record.len() - record.lost();
    let white = least / known.saturating_sub(NUMBERS).max(1) as f64;
    let length = left.len().div_ceil(PIECES).max(1);
    let mut covariance = Square::zeros();
    for (slopes, left) in slopes.chunks(length).zip(left.chunks(length)) {
        let (own, sum) = products(slopes, left);
        let moved = (normal - own).lu().solve(&sum).ok_or_else(undetermined)?;
        covariance += moved * moved.transpose();
    }
    let inverse = normal.try_inverse().ok_or_else(undetermined)?;
    let half = |number: usize| {
        let at = (number, number);
        2.0 * libm::sqrt(f64::max(covariance[at], white * inverse[at]))
    };
    let of_logarithm = |value: f64, half: f64| MeasuredNumber {
        value,
        low: value * libm::exp(-half),
        high: value * libm::exp(half),
    };
    let model = motion.left(theta);
    let read = record.position_m.iter().zip(&model.0);
    let curve = read.enumerate().filter(|(_, (x, _))| x.is_finite());
    let mut found = MeasuredRobot {
        bandwidth_hz: of_logarithm(libm::exp(theta[0]) / (TAU * t), half(0)),
        damping_ratio: of_logarithm(libm::exp(theta[1]), half(1)),
        dead_time_s: MeasuredNumber {
            low: (t * (theta[2] - half(2))).max(0.0),
            ..MeasuredNumber::about(t * theta[2], t * half(2))
        },
        gain: MeasuredNumber::about(gain, half(3)),
        residual_rms_m: libm::sqrt(least / known.max(1) as f64),
        samples: record.len(),
        lost_samples: record.lost(),
        warnings: Vec::new(),
        curve: curve
            .map(|(tick, (x, left))| [tick as f64 * t, *x, x + left])
            .collect(),
    };
    let (off, percent) = ((gain - 1.0).abs(), 100.0 * gain);
    if !(off < OFF[1] && covariance.iter().all(|value| value.is_finite())) {
        return Err(Failure::run(format_args!(
            "the robot moved at {percent:.1} % of its command: check the unit of velocity and position in its program, and that no end of its way is near"
        )));
    }
    if off > OFF[0] {
        found.warnings.push(format!(
            "the robot moves at {percent:.1} % of its command: check the unit of velocity and position in its program"
        ));
    }
    for (key, number) in found.named() {
        if number.high - number.low > 0.2 * number.value {
            found.warnings.push(format!(
                "{key} is known to {:.0} %: give a larger speed and box, or a longer duration",
                50.0 * (number.high - number.low) / number.value
            ));
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests;
