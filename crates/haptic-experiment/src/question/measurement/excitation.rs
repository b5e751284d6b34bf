//! Forces that make a device tell what it is: rest, a ramp each way, a multi-sine about the start.

use super::plan::MeasurePlan;
use haptic_loop::Environment;
use nalgebra::{SVector, Vector1};
use std::f64::consts::{PI, TAU};

/// Lowest and highest line of the slow group, Hz: they move the device through the box.
const SLOW_HZ: [f64; 2] = [1.5, 20.0];
/// Lowest line of the fast group, Hz: its lines hardly move the device, but tell delay from lag.
const FAST_FROM_HZ: f64 = 28.0;
/// Highest line, Hz, and as cycles a sample; the lower of the two.
const FAST_TO: (f64, f64) = (400.0, 0.22);
/// Lines of each group.
const LINES: [usize; 2] = [8, 12];
/// Shares of the largest force that the groups have, as rms.
const RMS: [f64; 2] = [0.3, 0.3];
/// Powers of the frequency with which the amplitudes of the groups grow: slow lines move the device furthest, and the fastest tell delay from
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
/// Time constant of the velocity that is looked at for that, s.
const FOLLOWS_S: f64 = 0.01;
/// Time in which the force of a ramp falls to zero, and time to come to rest after it, s.
const FALL_S: f64 = 0.05;
const PAUSE_S: f64 = 0.25;
/// A device that moves less than this share of [`MeasurePlan::near_m`] in so many seconds of the multi-sine is blocked. While the slow group is
/// small, so much less.
const STILL: (f64, f64) = (0.005, 0.5);

/// Facts that end a measurement before its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Finding {
    /// Nothing that the force could do moved it.
    Blocked,
    /// It moved without any force.
    MovesByItself,
}

/// The part of the measurement that is going on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Phase {
    /// No force.
    Rest,
    /// A force that grows, in this direction, until the device moves.
    Ramp(f64),
    /// A force that falls from this one, and a pause.
    Fall(f64),
    /// Multi-sine and spring.
    Driven,
    /// No force any more.
    Over,
}

/// One line of the multi-sine.
#[derive(Clone, Copy, Debug)]
struct Line {
    /// Radians a tick.
    step: f64,
    amplitude_n: f64,
    phase: f64,
}

/// The law: see the module.
#[derive(Clone, Debug)]
pub(super) struct Excitation {
    plan: MeasurePlan,
    slow: Vec<Line>,
    fast: Vec<Line>,
}

/// Where a measurement is.
#[derive(Clone, Debug)]
pub(super) struct Course {
    pub(super) phase: Phase,
    /// Ticks since the phase began.
    since: u64,
    /// All ticks.
    pub(super) tick: u64,
    start_m: Option<f64>,
    /// Position at which the phase began, m.
    from_m: f64,
    /// Forces at which the device moved, upwards and downwards, N.
    pub(super) moved_at_n: [Option<f64>; 2],
    /// Share of the slow group that is used.
    slow: f64,
    /// Position of the tick before, m, and velocity, m/s.
    last_m: f64,
    velocity_m_per_s: f64,
    /// Lowest and highest position since it was looked at last, m.
    seen: (f64, f64),
    pub(super) finding: Option<Finding>,
}

impl Excitation {
    pub(super) fn new(plan: MeasurePlan) -> Self {
        let highest = f64::min(FAST_TO.0, FAST_TO.1 / plan.sample_time_s);
        let group = |[low, high]: [f64; 2], lines: usize, rms: f64, slope: f64| -> Vec<Line> {
            let place = |n: usize| n as f64 / (lines - 1) as f64;
            let frequency = |n: usize| low * libm::pow(high / low, place(n));
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
        let away = position_m - course.start_m.unwrap_or(position_m);
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
    fn find(course: &mut Course, finding: Finding, position_m: f64) {
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
                    Self::find(course, Finding::MovesByItself, position_m);
                } else if course.since >= plan.ticks(MeasurePlan::REST_S) {
                    Self::enter(course, Phase::Ramp(1.0), position_m);
                }
            }
            Phase::Ramp(direction) => {
                let force = self.ramp(course.since);
                if moved > moves {
                    let index = usize::from(direction < 0.0);
                    course.moved_at_n[index] = Some(direction * force);
                    Self::enter(course, Phase::Fall(direction * force), position_m);
                } else if course.since > plan.ticks(MeasurePlan::RAMP_S) {
                    Self::find(course, Finding::Blocked, position_m);
                }
            }
            Phase::Fall(_) if course.since >= plan.ticks(FALL_S + PAUSE_S) => {
                let next = match course.moved_at_n[1] {
                    None => Phase::Ramp(-1.0),
                    Some(_) => Phase::Driven,
                };
                Self::enter(course, next, position_m);
            }
            Phase::Driven => self.watch(course, position_m),
            Phase::Fall(_) | Phase::Over => {}
        }
    }

    /// Keeps the slow group within the box, and sees a device that stands still.
    fn watch(&self, course: &mut Course, position_m: f64) {
        let plan = &self.plan;
        let t = plan.sample_time_s;
        let moved = (position_m - course.last_m) / t - course.velocity_m_per_s;
        course.velocity_m_per_s -= libm::expm1(-t / FOLLOWS_S) * moved;
        let there = position_m + AHEAD_S * course.velocity_m_per_s;
        let away = (there - course.start_m.unwrap_or(there)).abs();
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
                Self::find(course, Finding::Blocked, position_m);
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
            phase: Phase::Rest,
            since: 0,
            tick: 0,
            start_m: None,
            from_m: 0.0,
            moved_at_n: [None; 2],
            slow: BEGINS,
            last_m: 0.0,
            velocity_m_per_s: 0.0,
            seen: (0.0, 0.0),
            finding: None,
        }
    }

    fn force(&self, course: &Course, position_m: &Vector1<f64>) -> Vector1<f64> {
        let force = match course.phase {
            Phase::Rest | Phase::Over => 0.0,
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
        if course.start_m.is_none() {
            course.start_m = Some(position_m);
            course.last_m = position_m;
            Self::enter(course, Phase::Rest, position_m);
        }
        course.since += 1;
        course.tick += 1;
        self.follow(course, position_m);
        course.last_m = position_m;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            assert_eq!(course.finding, Some(Finding::Blocked), "{box_m}");
        }
    }
}
