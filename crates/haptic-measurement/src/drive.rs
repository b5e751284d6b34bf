//! The excitation on a device, through the safety chain, to its end or to whatever ends it.

use crate::{HELD, MEASURE_BOX, MEASURE_FORCE_LIMIT, MeasurePlan, MotionRecord};
use haptic_document::Failure;
use haptic_loop::{
    Controller, Device, Environment, Fault, LoopParameterError, SafetyChain,
    plant::{MassDamper, MassDamperConfig},
    units::Seconds,
};
use haptic_quantity::{digits, written};
use haptic_trial::Sensors;
use nalgebra::{SVector, Vector1};
use std::{
    f64::consts::{PI, TAU},
    sync::atomic::{AtomicBool, Ordering},
};

/// End of a measurement that somebody stopped, in words.
pub const INTERRUPTED: &str = "interrupted: the force is zero, nothing was written";

/// The end of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriveOutcome {
    /// The multi-sine came to its end.
    Complete,
    /// A user stopped it; the record ends there.
    Interrupted,
    /// The safety chain latched a fault.
    Fault(Fault),
    /// No force that is allowed moves the device, or keeps it moving: the force at which it began to move, N, if it did.
    Blocked(Option<f64>),
    /// The device moved against this force, N.
    Against(f64),
    /// The device moved without any force.
    MovesByItself,
}

/// A motion, and how it ended; the force is zero.
#[derive(Clone, Debug)]
pub struct Driven {
    /// The motion up to there.
    pub record: MotionRecord,
    /// The reason for which the motion ended.
    pub outcome: DriveOutcome,
}

/// A measurement that could not be made.
#[derive(Debug)]
pub enum DriveError<E> {
    /// Limits that make no safety chain.
    Plan(LoopParameterError),
    /// It was ended, in words.
    Said(Failure),
    /// The device did not follow a command.
    Device(E),
}

impl<E> From<Failure> for DriveError<E> {
    fn from(failure: Failure) -> Self {
        Self::Said(failure)
    }
}

/// Time in which the slow group reaches its size where nothing makes it smaller, s.
pub(crate) fn grown_s() -> f64 {
    -GROWS_S * libm::log(BEGINS)
}

/// Lines of the multi-sine, slowest first, radians a sample.
pub(crate) fn steps(plan: &MeasurePlan) -> Vec<f64> {
    let Excitation { slow, fast, .. } = Excitation::new(*plan);
    slow.iter().chain(&fast).map(|line| line.step).collect()
}

/// Drives a device through a measurement. `applied` gives the force that the device really applied in a tick, from the one that it was sent;
/// `progress` hears the number of ticks.
///
/// Whatever ends it, the force is zero when this returns.
///
/// # Errors
/// A device that did not follow, or limits that make no safety chain.
pub fn drive<V: Device<f64, 1>>(
    plan: &MeasurePlan,
    device: &mut V,
    applied: &mut dyn FnMut(&V, f64) -> f64,
    progress: &dyn Fn(u64),
    stop: &AtomicBool,
) -> Result<Driven, DriveError<V::Error>> {
    let first = device.read().map_err(DriveError::Device)?;
    let limits = plan.limits(first.position_m[0]);
    let chain = SafetyChain::from_limits(&limits, Seconds(plan.sample_time_s));
    let chain = chain.map_err(DriveError::Plan)?;
    let mut controller = Controller::<f64, 1, _>::new(Excitation::new(*plan), chain);
    // Whatever ends this function, no force stays.
    let mut engaged = controller.engage(device);
    let capacity = plan.ticks_at_most() as usize;
    let mut record = MotionRecord::with_capacity(plan.sample_time_s, capacity);
    let mut outcome = None;
    let mut next = first.tick;
    let mut reading = first;
    loop {
        let phase = engaged.controller_mut().law_mut().1.phase;
        let done = engaged.tick_reading(reading);
        let done = done.map_err(DriveError::Device)?;
        let missing = reading.tick.saturating_sub(next);
        next = reading.tick + 1;
        if outcome.is_none() {
            let force = applied(engaged.device(), done.force.newtons()[0]);
            match phase {
                Phase::Rest => record.rest = record.len() + 1,
                Phase::Driven => {}
                Phase::Centre | Phase::Ramp(_) | Phase::Fall(_) | Phase::Over => {
                    record.driven_from = record.len() + 1;
                }
            }
            record.push(missing, reading.position_m[0], force);
            progress(record.len() as u64);
            let course = engaged.controller_mut().law_mut().1;
            outcome = ended(course, done.fault, stop);
            if let [Some(up), Some(down)] = course.moved_at_n {
                record.breakaway_n = Some((up, down));
            }
        }
        if outcome.is_some() {
            engaged.controller_mut().stop();
        }
        if let (Some(outcome), true) = (outcome, engaged.controller().safety().is_at_rest()) {
            return Ok(Driven { record, outcome });
        }
        reading = engaged.read().map_err(DriveError::Device)?;
    }
}

/// Reason to end, if there is one.
fn ended(course: &Course, fault: Option<Fault>, stop: &AtomicBool) -> Option<DriveOutcome> {
    if let Some(fault) = fault {
        // At rest there is no force yet that could have moved it.
        let moves = matches!(fault, Fault::Workspace | Fault::Velocity);
        return Some(if moves && course.phase == Phase::Rest {
            DriveOutcome::MovesByItself
        } else if fault == Fault::PositionStuck {
            DriveOutcome::Blocked(course.began_to_move_n())
        } else {
            DriveOutcome::Fault(fault)
        });
    }
    if course.finding.is_some() {
        return course.finding;
    }
    if stop.load(Ordering::Relaxed) {
        return Some(DriveOutcome::Interrupted);
    }
    (course.phase == Phase::Over).then_some(DriveOutcome::Complete)
}

impl DriveOutcome {
    /// Refuses all but a measurement that came to its end.
    ///
    /// # Errors
    /// An end before the last of the multi-sine, in words, and what to change.
    pub fn require_complete(self, plan: &MeasurePlan) -> Result<(), Failure> {
        let in_newtons = |force_n| written("force_n", force_n);
        let force = in_newtons(plan.force_n());
        let box_mm = 1e3 * plan.box_m;
        Err(Failure::run(match self {
            Self::Complete => return Ok(()),
            Self::Interrupted => INTERRUPTED.to_owned(),
            Self::Fault(Fault::Workspace) => format!(
                "the device left the box of {box_mm} mm, and the force is zero: enlarge {MEASURE_BOX}, or give a smaller {MEASURE_FORCE_LIMIT}"
            ),
            Self::Fault(fault @ (Fault::Velocity | Fault::PositionJump)) => format!(
                "the device is too fast, and the force is zero ({fault}): give a smaller {MEASURE_FORCE_LIMIT}, or check its sensor"
            ),
            Self::Fault(fault) => {
                format!("the measurement ended in a fault, and the force is zero: {fault}")
            }
            Self::Blocked(None) => format!(
                "the device does not move under {force}, and the force is zero: free it, or give {}",
                plan.asked_for(2.0 * plan.force_n())
            ),
            Self::Blocked(Some(friction_n)) => {
                let needed_n = MeasurePlan::KEEPS_MOVING * friction_n;
                // Friction of the next run may be a few per cent more, which must not ask again.
                let given_n = 1.1 * needed_n;
                format!(
                    "friction holds the device, and the force is zero: it began to move at {}, but up to {force} hardly keep it moving, \
                     which takes {}: give {}",
                    in_newtons(friction_n),
                    in_newtons(needed_n),
                    plan.asked_for(given_n)
                )
            }
            Self::Against(force_n) => format!(
                "the device moved against a force of {}, which is zero now: try again with your hand away, then swap the encoder's \
                 channels or the motor's leads, or turn the sign of this axis where positions or forces are converted",
                in_newtons(force_n)
            ),
            Self::MovesByItself => format!(
                "the device moves by itself, without any force: level it, let go of it, or give {HELD} if a hand holds it"
            ),
        }))
    }
}

/// The force limit whose share is this force, N.
fn set_force(force_n: f64) -> String {
    MEASURE_FORCE_LIMIT.set_to(digits(two_digits_up(force_n / MeasurePlan::SHARE), 2))
}

/// A number above 0 in two digits, and not below it.
fn two_digits_up(value: f64) -> f64 {
    let unit = libm::pow(10.0, libm::floor(libm::log10(value)) - 1.0);
    unit * libm::ceil(value / unit - 1e-9)
}

impl MeasurePlan {
    /// The refusal of a motion that determines no device, as friction took most of the force.
    pub fn held_back(&self, record: &MotionRecord) -> Option<Failure> {
        let (up_n, down_n) = record.breakaway_n?;
        let friction_n = f64::max(up_n, -down_n);
        let held = self.force_n() < Self::KEEPS_MOVING * friction_n;
        held.then(|| DriveOutcome::Blocked(Some(friction_n)).require_complete(self))?
            .err()
    }

    /// Limits that a multi-sine of this force, N, asks for: that of the measurement, if it has less, and those of the device itself.
    fn asked_for(&self, force_n: f64) -> String {
        let more = |key, least: f64, own: f64| {
            let [shown, set] = [two_digits_up(least), own].map(|value| written(key, value));
            (least > own).then(|| format!("{shown} instead of its own {set}"))
        };
        let own = [
            more("force_n", force_n, self.own.force_n),
            more(
                "force_rate_n_per_s",
                Self::RATE_PER_S * force_n,
                self.own.force_rate_n_per_s,
            ),
        ];
        let own: Vec<String> = own.into_iter().flatten().collect();
        let device = (!own.is_empty())
            .then(|| format!("the device {} (`host-cli device set`)", own.join(", and ")));
        // The measurement has the force where the device alone is too slow.
        let is_enough = force_n <= self.force_n() && device.is_some();
        let limit = (!is_enough).then(|| set_force(force_n));
        let all: Vec<String> = limit.into_iter().chain(device).collect();
        all.join(", and ")
    }
}

/// Measures a simulated device in virtual time.
///
/// # Errors
/// A device that cannot be simulated; a measurement that was stopped.
pub fn on_simulated(
    plan: &MeasurePlan,
    device: MassDamperConfig,
    sensors: Sensors,
    progress: &dyn Fn(u64),
    stop: &AtomicBool,
) -> Result<MotionRecord, Failure> {
    let config = MassDamperConfig {
        sample_time: Seconds(plan.sample_time_s),
        ..device
    };
    let plant = MassDamper::<1>::new(config).map_err(Failure::input)?;
    let mut device = sensors.before(plant)?;
    let driven = drive(plan, &mut device, &mut |_, sent| sent, progress, stop);
    let driven = driven.map_err(|error| match error {
        DriveError::Plan(error) => Failure::input(error),
        DriveError::Said(failure) => failure,
        DriveError::Device(never) => match never {},
    })?;
    driven.outcome.require_complete(plan)?;
    Ok(driven.record)
}

/// Lowest and highest line of the slow group, Hz: they move the device through the box.
const SLOW_HZ: [f64; 2] = [1.5, 20.0];
/// Lowest line of the fast group, Hz: its lines hardly move the device, but separate delay from lag.
const FAST_FROM_HZ: f64 = 28.0;
/// Highest line, Hz, and as cycles a sample; the lower of the two.
const FAST_TO: (f64, f64) = (400.0, 0.22);
const LINES: [usize; 2] = [8, 12];
/// Shares of the largest force that the groups have, as rms.
const RMS: [f64; 2] = [0.3, 0.3];
/// Powers of the frequency with which the amplitudes of the groups grow: slow lines move the device furthest, the fastest separate delay from
/// lag.
const SLOPES: [f64; 2] = [1.0, 0.5];
/// Force of the spring at the end of the box, as a share of the largest.
const SPRING: f64 = 0.2;
/// Share of the box beyond which the slow group is made smaller, for the place where the device will be after [`AHEAD_S`].
const WIDE: f64 = 0.5;
const AHEAD_S: f64 = 0.04;
/// Times in which the slow group grows and shrinks, s, and the share with which it begins.
const GROWS_S: f64 = 1.0;
const SHRINKS_S: f64 = 0.03;
const BEGINS: f64 = 0.05;
/// Time constant of the velocity filter for that, s.
const FOLLOWS_S: f64 = 0.01;
/// Time in which the force of a ramp falls to zero, and time to come to rest after it, s.
const FALL_S: f64 = 0.05;
const PAUSE_S: f64 = 0.25;
/// Speed on the way to the middle of the box, in lengths of [`MeasurePlan::near_m`] a second; share of the box that is near enough.
const TO_MIDDLE: (f64, f64) = (4.0, 0.1);
/// A device that moves less than this share of [`MeasurePlan::near_m`] in this time of the multi-sine, s, is blocked; while the slow group is
/// small, the share is smaller in proportion.
const STILL: (f64, f64) = (0.005, 0.5);

/// The part of the measurement that is going on.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
enum Phase {
    #[default]
    Rest,
    /// Way to the middle of the box.
    Centre,
    /// A force that grows, in this direction, until the device moves.
    Ramp(f64),
    /// A force that falls from this one, and a pause.
    Fall(f64),
    Driven,
    Over,
}

/// One line of the multi-sine.
#[derive(Clone, Copy, Debug)]
struct Line {
    step: f64,
    amplitude_n: f64,
    phase: f64,
}

/// The law: see the module.
#[derive(Clone, Debug)]
struct Excitation {
    plan: MeasurePlan,
    slow: Vec<Line>,
    fast: Vec<Line>,
}

#[derive(Clone, Debug, Default)]
struct Course {
    phase: Phase,
    /// Ticks since the phase began.
    since: u64,
    /// Middle of the box, m.
    middle_m: Option<f64>,
    /// Force that moves the device there, N, signed as the position.
    pull_n: f64,
    /// It has been there since the last ramp.
    centred: bool,
    /// Position at which the phase began, m.
    from_m: f64,
    /// Forces at which the device moved, upwards and downwards, N.
    moved_at_n: [Option<f64>; 2],
    /// Share of the slow group that is used.
    slow: f64,
    /// Position of the tick before, m, and velocity, m/s.
    last_m: f64,
    velocity_m_per_s: f64,
    /// Lowest and highest position since the last check, m.
    seen: (f64, f64),
    /// Reason to end before the planned time.
    finding: Option<DriveOutcome>,
}

impl Course {
    /// Way from a position to the middle of the box, m.
    fn to_middle_m(&self, position_m: f64) -> f64 {
        self.middle_m.unwrap_or(position_m) - position_m
    }

    /// The larger of the forces at which it began to move, N: an upper bound of friction.
    fn began_to_move_n(&self) -> Option<f64> {
        let found = self.moved_at_n.iter().flatten();
        found.map(|force_n| force_n.abs()).reduce(f64::max)
    }
}

impl Excitation {
    fn new(plan: MeasurePlan) -> Self {
        let highest = f64::min(FAST_TO.0, FAST_TO.1 / plan.sample_time_s);
        let group = |[low, high]: [f64; 2], lines: usize, rms: f64, slope: f64| -> Vec<Line> {
            let share = |n: usize| n as f64 / (lines - 1) as f64;
            let frequency = |n: usize| low * libm::pow(high / low, share(n));
            let weight = |n: usize| libm::pow(frequency(n) / high, slope);
            let squares: f64 = (0..lines).map(|n| 0.5 * weight(n) * weight(n)).sum();
            let unit = rms * plan.force_n() / squares.sqrt();
            let line = |n: usize| {
                Line {
                    step: TAU * frequency(n) * plan.sample_time_s,
                    amplitude_n: unit * weight(n),
                    // M. R. Schroeder's phases: a flat multi-sine with low peaks.
                    phase: -PI * (n * (n + 1)) as f64 / lines as f64,
                }
            };
            (0..lines).map(line).collect()
        };
        let fast_from = f64::min(FAST_FROM_HZ, 0.5 * highest);
        let slow_to = f64::min(SLOW_HZ[1], 0.7 * fast_from);
        Self {
            plan,
            slow: group([SLOW_HZ[0], slow_to], LINES[0], RMS[0], SLOPES[0]),
            fast: group([fast_from, highest], LINES[1], RMS[1], SLOPES[1]),
        }
    }

    fn driven(&self, course: &Course, position_m: f64) -> f64 {
        let most = self.plan.force_n();
        let tick = course.since as f64;
        let sum = |lines: &[Line]| -> f64 {
            let each = lines
                .iter()
                .map(|line| line.amplitude_n * libm::sin(line.step * tick + line.phase));
            each.sum()
        };
        // The fast group rises within half a second.
        let rise = f64::min(1.0, tick * self.plan.sample_time_s / 0.5);
        let away = -course.to_middle_m(position_m);
        let spring = -SPRING * most * away / self.plan.box_m;
        let wanted = spring + course.slow * sum(&self.slow) + rise * sum(&self.fast);
        wanted.clamp(-most, most)
    }

    fn enter(course: &mut Course, phase: Phase, position_m: f64) {
        course.phase = phase;
        course.since = 0;
        course.from_m = position_m;
        course.seen = (position_m, position_m);
    }

    /// Ends the measurement, if the device does what it must not.
    fn find(course: &mut Course, finding: DriveOutcome, position_m: f64) {
        course.finding = Some(finding);
        Self::enter(course, Phase::Over, position_m);
    }

    fn follow(&self, course: &mut Course, position_m: f64) {
        let plan = &self.plan;
        let moved = (position_m - course.from_m).abs();
        let moves = MeasurePlan::MOVES * plan.near_m();
        match course.phase {
            Phase::Rest => {
                let rests = MeasurePlan::MOVES * plan.box_m;
                // A hand trembles.
                let most = if plan.hand { 10.0 * rests } else { rests };
                if moved > most {
                    Self::find(course, DriveOutcome::MovesByItself, position_m);
                } else if course.since >= plan.ticks(MeasurePlan::REST_S) {
                    self.go_on(course, position_m);
                }
            }
            Phase::Centre => {
                let went = course.to_middle_m(course.from_m);
                let ahead_m = position_m + AHEAD_S * course.velocity_m_per_s;
                let is_there = course.to_middle_m(ahead_m) * went <= 0.0;
                let moved = position_m - course.from_m;
                if moved * went < 0.0 && moved.abs() > moves {
                    Self::find(course, DriveOutcome::Against(course.pull_n), position_m);
                } else if is_there || course.since > plan.ticks(MeasurePlan::CENTRE_S) {
                    course.centred = true;
                    Self::enter(course, Phase::Fall(course.pull_n), position_m);
                } else {
                    self.pull(course);
                }
            }
            Phase::Ramp(direction) => {
                let force = direction * self.ramp(course.since);
                if moved <= moves {
                    if course.since > plan.ticks(MeasurePlan::RAMP_S) {
                        Self::find(
                            course,
                            DriveOutcome::Blocked(course.began_to_move_n()),
                            position_m,
                        );
                    }
                } else if direction * (position_m - course.from_m) < 0.0 && !plan.hand {
                    Self::find(course, DriveOutcome::Against(force), position_m);
                } else {
                    course.moved_at_n[usize::from(direction < 0.0)] = Some(force);
                    course.centred = false;
                    Self::enter(course, Phase::Fall(force), position_m);
                }
            }
            Phase::Fall(_) if course.since >= plan.ticks(FALL_S + PAUSE_S) => {
                self.go_on(course, position_m);
            }
            Phase::Driven => self.watch(course, position_m),
            Phase::Fall(_) | Phase::Over => {}
        }
    }

    /// The next phase: the ramps upwards and downwards, and the multi-sine, the first and the last from the middle of the box.
    fn go_on(&self, course: &mut Course, position_m: f64) {
        let next = match course.moved_at_n {
            [None, _] => Phase::Ramp(1.0),
            [_, None] => Phase::Ramp(-1.0),
            _ => Phase::Driven,
        };
        let away_m = course.to_middle_m(position_m).abs();
        let is_off = !self.plan.hand && away_m > TO_MIDDLE.1 * self.plan.box_m;
        if is_off && !course.centred && next != Phase::Ramp(-1.0) {
            course.pull_n = 0.0;
            Self::enter(course, Phase::Centre, position_m);
            return;
        }
        if next == Phase::Driven {
            // A small multi-sine, all of which friction takes, would be a device that stands still.
            let share = course.began_to_move_n().unwrap_or(0.0) / self.plan.force_n();
            course.slow = share.clamp(BEGINS, 1.0);
        }
        Self::enter(course, next, position_m);
    }

    /// The force towards the middle grows while the device is slower than it should be, as fast as that of a ramp, and falls while it is faster.
    fn pull(&self, course: &mut Course) {
        let plan = &self.plan;
        let speed = TO_MIDDLE.0 * plan.near_m();
        let wanted = libm::copysign(speed, course.to_middle_m(course.from_m));
        let share = (wanted - course.velocity_m_per_s) / speed;
        let most = plan.force_n();
        let step = most * plan.sample_time_s / MeasurePlan::RAMP_S;
        course.pull_n = (course.pull_n + step * share).clamp(-most, most);
    }

    /// Keeps the slow group within the box, and sees a device that stands still.
    fn watch(&self, course: &mut Course, position_m: f64) {
        let plan = &self.plan;
        let t = plan.sample_time_s;
        let ahead = position_m + AHEAD_S * course.velocity_m_per_s;
        let away = course.to_middle_m(ahead).abs();
        course.slow = if away > WIDE * plan.box_m {
            course.slow * libm::exp(-t / SHRINKS_S)
        } else {
            f64::min(1.0, course.slow * libm::exp(t / GROWS_S))
        };
        let (low, high) = course.seen;
        course.seen = (low.min(position_m), high.max(position_m));
        let look = plan.ticks(STILL.1);
        if course.since > 0 && course.since.is_multiple_of(look) {
            if course.seen.1 - course.seen.0 < STILL.0 * course.slow * plan.near_m() {
                Self::find(
                    course,
                    DriveOutcome::Blocked(course.began_to_move_n()),
                    position_m,
                );
                return;
            }
            course.seen = (position_m, position_m);
        }
        if course.since >= plan.ticks(plan.duration_s) {
            Self::enter(course, Phase::Over, position_m);
        }
    }

    /// Force of a ramp, N.
    fn ramp(&self, since: u64) -> f64 {
        let share = since as f64 * self.plan.sample_time_s / MeasurePlan::RAMP_S;
        self.plan.force_n() * share.min(1.0)
    }
}

impl Environment<f64, 1> for Excitation {
    type History = Course;

    fn at_rest(&self) -> Course {
        Course {
            slow: BEGINS,
            ..Course::default()
        }
    }

    fn force(&self, course: &Course, position_m: &Vector1<f64>) -> Vector1<f64> {
        let force = match course.phase {
            Phase::Rest | Phase::Over => 0.0,
            Phase::Centre => course.pull_n,
            Phase::Ramp(direction) => direction * self.ramp(course.since),
            Phase::Fall(from) => {
                let share = course.since as f64 * self.plan.sample_time_s / FALL_S;
                from * f64::max(0.0, 1.0 - share)
            }
            Phase::Driven => self.driven(course, position_m[0]),
        };
        SVector::from([force])
    }

    fn advance(&self, course: &mut Course, position_m: &Vector1<f64>) {
        let position_m = position_m[0];
        if course.middle_m.is_none() {
            course.middle_m = Some(self.plan.middle_m(position_m));
            course.last_m = position_m;
            Self::enter(course, Phase::Rest, position_m);
        }
        course.since += 1;
        let t = self.plan.sample_time_s;
        let faster = (position_m - course.last_m) / t - course.velocity_m_per_s;
        course.velocity_m_per_s -= libm::expm1(-t / FOLLOWS_S) * faster;
        self.follow(course, position_m);
        course.last_m = position_m;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_leaves_the_box_before_there_is_a_force_moves_by_itself() {
        let mut course = Excitation::new(MeasurePlan::default()).at_rest();
        let never = AtomicBool::new(false);
        let mut seen = |phase, fault| {
            course.phase = phase;
            ended(&course, Some(fault), &never)
        };
        for fault in [Fault::Workspace, Fault::Velocity] {
            let itself = seen(Phase::Rest, fault);
            assert_eq!(itself, Some(DriveOutcome::MovesByItself), "{fault}");
            let driven = seen(Phase::Driven, fault);
            assert_eq!(driven, Some(DriveOutcome::Fault(fault)));
        }
        // A sensor that jumps is none that moves.
        let jump = seen(Phase::Rest, Fault::PositionJump);
        assert_eq!(jump, Some(DriveOutcome::Fault(Fault::PositionJump)));
    }

    #[test]
    fn a_device_that_is_held_after_it_moved_is_blocked_in_any_box() {
        for box_m in [0.005, 0.2] {
            let law = Excitation::new(MeasurePlan {
                box_m,
                ..MeasurePlan::default()
            });
            let mut course = law.at_rest();
            law.advance(&mut course, &Vector1::new(0.0));
            Excitation::enter(&mut course, Phase::Driven, 0.0);
            // Held but for a sensor that trembles by a step.
            let step_m = 2e-5;
            let steps = law.plan.ticks(4.0 + STILL.1);
            for tick in 0..steps {
                let read_m = if tick.is_multiple_of(2) { 0.0 } else { step_m };
                law.advance(&mut course, &Vector1::new(read_m));
            }
            assert_eq!(course.finding, Some(DriveOutcome::Blocked(None)), "{box_m}");
        }
    }
}
