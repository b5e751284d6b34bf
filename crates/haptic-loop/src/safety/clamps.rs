//! Magnitude, norm and rate, all at once; and the way of a force to zero.

use super::force::Limiters;
use super::limits::{Limit, SafetyLimits};
use crate::error::Checks;
use core::array;
use fracdiff::Real;
use nalgebra::SVector;

/// The last stage: whatever is wanted, the next force lies within the limits and one step of the last.
///
/// ```text
/// C = {f: |f_i| ≤ magnitude, |f| ≤ norm},   p ∈ C the last force,   q ∈ C: the wanted one, scaled towards 0
/// f = p + λ(q − p),   λ ≤ 1 the largest with λ·|q − p| ≤ step
/// ```
/// C is convex, so f ∈ C; the force moves by no more than a step, in whatever direction, by the choice of λ; and λ > 0, so no force
/// is stuck. A wanted force on the line of the last one stays on it: no limit turns it. Without a norm C is a box.
/// *Start-up*: p = 0. *Rounding*: magnitude and norm hold exactly, a step to one rounding of the force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Clamps<F> {
    /// Largest force on an axis, N.
    pub(super) magnitude: F,
    /// Largest change in a sample, of the whole force, N.
    step: F,
    norm: Option<Norm<F>>,
}

/// A limit of the norm, with room for rounding: 1 − 2⁻²⁰ of it is aimed at, 1 − 2⁻²¹ is never passed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Norm<F> {
    aim: F,
    aim_square: F,
    never_square: F,
}

impl<F: Real> Clamps<F> {
    pub(super) fn new(limits: &SafetyLimits, sample_time: f64, checks: &mut Checks) -> Self {
        let magnitude = checks.positive("force limit", limits.force.0, "N");
        let rate = checks.positive("force rate limit", limits.rate.0, "N/s");
        let norm = limits.norm.map(|norm| {
            at_most_1e9("force limit", magnitude, checks);
            at_most_1e9("force norm limit", norm.0, checks);
            Norm::new(norm.0, checks)
        });
        Self {
            magnitude: checks.rounded("force limit", magnitude, "N"),
            step: checks.rounded("force step", rate * sample_time, "N"),
            norm,
        }
    }

    #[inline]
    pub(super) fn apply<const D: usize>(
        &self,
        force: &mut SVector<F, D>,
        wanted: &SVector<F, D>,
        limiters: &mut Limiters,
    ) {
        if D == 1 && self.norm.is_none() {
            self.limit_one(force, wanted, limiters);
        } else {
            self.limit_all(force, wanted, limiters);
        }
    }

    /// The only axis: towards the wanted force by one step, then within the magnitude.
    #[inline]
    fn limit_one<const D: usize>(
        &self,
        force: &mut SVector<F, D>,
        wanted: &SVector<F, D>,
        limiters: &mut Limiters,
    ) {
        for (last, &wanted) in force.iter_mut().zip(wanted) {
            let mut bounded = |value: F, low: F, high: F, limiter: Limiters| {
                if value < low {
                    limiters.insert(limiter);
                    low
                } else if value > high {
                    limiters.insert(limiter);
                    high
                } else {
                    value
                }
            };
            let (low, high) = (*last - self.step, *last + self.step);
            let slewed = bounded(wanted, low, high, Limiters::RATE);
            *last = bounded(slewed, -self.magnitude, self.magnitude, Limiters::MAGNITUDE);
        }
    }

    /// All axes at once: p + λ(q − p).
    #[inline]
    fn limit_all<const D: usize>(
        &self,
        force: &mut SVector<F, D>,
        wanted: &SVector<F, D>,
        limiters: &mut Limiters,
    ) {
        let mut aim = self.allowed(wanted);
        if aim != *wanted {
            limiters.insert(Limiters::MAGNITUDE);
        }
        let change: [F; D] = array::from_fn(|axis| aim[axis] - force[axis]);
        let distance = norm(&SVector::from(change));
        if distance > self.step {
            limiters.insert(Limiters::RATE);
            let share = self.step / distance;
            for ((aim, &last), change) in aim.iter_mut().zip(force.iter()).zip(change) {
                // The clamp takes a rounding of the product, no more.
                *aim = clamp(last + share * change, last - self.step, last + self.step);
            }
        }
        // Not so by rounding alone, or where a change is beyond the number type: then p stays, which is in C.
        let within = match &self.norm {
            Some(norm) => square(&aim) <= norm.never_square,
            None => distance.is_finite(),
        };
        if within {
            *force = aim.map(|axis| clamp(axis, -self.magnitude, self.magnitude));
        }
    }

    /// q: into the box and into the ball, on the line to 0.
    #[inline]
    fn allowed<const D: usize>(&self, wanted: &SVector<F, D>) -> SVector<F, D> {
        let within = |axis: F| clamp(axis, -self.magnitude, self.magnitude);
        let mut aim = *wanted;
        if D == 1 {
            aim = aim.map(within);
        } else {
            let largest = largest(wanted);
            if largest > self.magnitude {
                // The quotient first: it is at most 1, whatever is wanted.
                aim = aim.map(|axis| within(axis / largest * self.magnitude));
            }
        }
        if let Some(norm) = &self.norm {
            let square = square(&aim);
            if square > norm.aim_square {
                let scale = norm.aim / square.sqrt();
                aim = aim.map(|axis| axis * scale);
            }
        }
        aim
    }
}

impl<F: Real> Norm<F> {
    fn new(limit: f64, checks: &mut Checks) -> Self {
        let what = "force norm limit";
        let aim = limit * (1.0 - 1.0 / 1_048_576.0);
        let never = limit * (1.0 - 1.0 / 2_097_152.0);
        Self {
            aim: checks.rounded(what, aim, "N"),
            aim_square: checks.rounded(what, aim * aim, "N"),
            never_square: checks.rounded(what, never * never, "N"),
        }
    }
}

/// The envelope after a fault, a stop or the end of a run.
///
/// ```text
/// |f| ≤ (1 − k/n)·max(|f₀|, brake force)      k = 1, 2, …: ticks since then,   n = ⌈stop time/T⌉
/// ```
/// f₀ is the force of the moment, |·| the Euclidean norm. It holds whatever the rate limit, and scales towards zero,
/// so a force within convex limits stays there. *Rounding*: exact with one axis, one rounding of the force with more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Release<F> {
    /// n, the ticks in which the force falls to 0.
    ticks: F,
    /// 1/n.
    share: F,
    /// Brake force, N, the least height at which the envelope begins.
    brake_force: F,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Released<F> {
    /// The force at which the envelope begins, N.
    from: F,
    left: F,
}

impl<F: Real> Released<F> {
    /// Ticks that did not come count too.
    pub(super) fn skip(&mut self, ticks: F) {
        self.left = clamp(self.left - ticks, F::ZERO, self.left);
    }
}

impl<F: Real> Release<F> {
    pub(super) fn new(limits: &SafetyLimits, sample_time: f64, checks: &mut Checks) -> Self {
        let (stop, brake) = (limits.stop_time.0, limits.brake_force.0);
        let is_within = |limit: Limit, number| {
            let [least, most] = limit.range();
            (least..=most).contains(&number)
        };
        let within = is_within(Limit::StopTime, stop);
        checks.range("stop time", stop, within, "in [0.001, 1] {}", "s");
        let within = is_within(Limit::BrakeForce, brake);
        checks.range("brake force", brake, within, "in [0, 10] {}", "N");
        let ticks = whole_ticks(stop, sample_time);
        Self {
            ticks: checks.rounded("stop time", ticks, "samples"),
            share: checks.rounded("stop time", 1.0 / ticks, "samples⁻¹"),
            brake_force: checks.rounded("brake force", brake, "N"),
        }
    }

    /// The share of the braking that is left before this tick, from 1 down.
    #[inline]
    pub(super) fn left(&self, released: Option<&Released<F>>) -> F {
        released.map_or(F::ONE, |released| released.left * self.share)
    }

    /// Scales a force into the envelope of this tick; the first begins it at the force before. One of 0 N makes the
    /// force exactly zero.
    #[inline(never)]
    pub(super) fn hold<const D: usize>(
        &self,
        released: &mut Option<Released<F>>,
        before: &SVector<F, D>,
        force: &mut SVector<F, D>,
    ) {
        let released = released.get_or_insert_with(|| {
            let norm = norm(before);
            Released {
                from: if norm > self.brake_force {
                    norm
                } else {
                    self.brake_force
                },
                left: self.ticks,
            }
        });
        released.skip(F::ONE);
        let envelope = released.from * (released.left * self.share);
        let some = envelope > F::ZERO;
        if !some {
            *force = SVector::from([F::ZERO; D]);
            return;
        }
        let norm = norm(force);
        if norm > envelope {
            let scale = envelope / norm;
            for axis in force {
                *axis = clamp(*axis * scale, -envelope, envelope);
            }
        }
    }
}

/// A time in whole samples, at least one: rounded up, but to the number itself where it is above a whole one by no
/// more than single precision makes of it. More than 2²³ could not be counted in single precision.
#[inline(never)]
pub(super) fn whole_ticks(time: f64, sample_time: f64) -> f64 {
    libm::ceil(time / sample_time * (1.0 - 1e-6)).clamp(1.0, 8_388_608.0)
}

/// Above 0, and so small that its square is a number in single precision.
fn at_most_1e9(what: &'static str, force: f64, checks: &mut Checks) {
    let accepted = force > 0.0 && force <= 1e9;
    checks.range(what, force, accepted, "above 0 and at most 1e9 {}", "N");
}

#[inline]
pub(crate) fn square<F: Real, const D: usize>(vector: &SVector<F, D>) -> F {
    let mut sum = F::ZERO;
    for &axis in vector {
        sum += axis * axis;
    }
    sum
}

/// The largest size of an axis; one that is no number is left out.
#[inline]
pub(crate) fn largest<F: Real, const D: usize>(vector: &SVector<F, D>) -> F {
    let mut largest = F::ZERO;
    for axis in vector {
        if axis.abs() > largest {
            largest = axis.abs();
        }
    }
    largest
}

/// The Euclidean norm, without a square that overflows.
#[inline]
pub(crate) fn norm<F: Real, const D: usize>(vector: &SVector<F, D>) -> F {
    let largest = largest(vector);
    if D == 1 || largest <= F::ZERO {
        return largest;
    }
    let mut squares = F::ZERO;
    for &axis in vector {
        let share = axis / largest;
        squares += share * share;
    }
    largest * squares.sqrt()
}

pub(crate) fn clamp<F: Real>(value: F, low: F, high: F) -> F {
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}
