//! The way of a force to zero.

use super::clamps::{clamp, norm};
use super::limits::Limits;
use crate::error::Checks;
use fracdiff::Real;
use nalgebra::SVector;

/// The envelope after a fault, a stop or the end of a run.
///
/// ```text
/// |f| ≤ (1 − k/n)·max(|f₀|, brake force)      k = 1, 2, …: ticks since then,   n = ⌈stop time/T⌉
/// ```
/// f₀ is the force of the moment, |·| the Euclidean norm. It holds whatever the rate limit, and scales towards zero,
/// so a force within convex limits stays there. *Rounding*: exact with one axis, one rounding of the force with more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Release<F> {
    /// n.
    ticks: F,
    /// 1/n.
    share: F,
    /// N.
    brake_force: F,
}

/// A force on its way to zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Released<F> {
    /// The force at which the envelope begins, N.
    from: F,
    /// n − k.
    left: F,
}

impl<F: Real> Released<F> {
    /// Ticks that did not come count too.
    pub(super) fn skip(&mut self, ticks: F) {
        self.left = clamp(self.left - ticks, F::ZERO, self.left);
    }
}

impl<F: Real> Release<F> {
    /// Refuses a time or force outside the range that its field states.
    pub(super) fn new(limits: &Limits, sample_time: f64, checks: &mut Checks) -> Self {
        let (stop, brake) = (limits.stop_time.0, limits.brake_force.0);
        let [least, most] = Limits::STOP_TIME_S;
        let within = (least..=most).contains(&stop);
        checks.range("stop time", stop, within, "in [0.001, 1]", "s");
        let within = (0.0..=Limits::BRAKE_FORCE_MAX_N).contains(&brake);
        checks.range("brake force", brake, within, "in [0, 10]", "N");
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
