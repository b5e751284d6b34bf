//! Velocity from positions, the limits of motion, and braking.

use super::clamps::clamp;
use super::fault::Fault;
use super::force::Limiters;
use super::limits::{Limits, SpeedLimit, Workspace};
use crate::error::{ParameterError, positive, range, rounded};
use fracdiff::Real;
use nalgebra::SVector;

/// Where a motion is braked: nowhere below `from`, fully at from + 1/`per`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Zone<F> {
    from: F,
    per: F,
    hard: F,
}

impl<F: Real> Zone<F> {
    /// `soft` wide, up to `hard`; no zone if it has no width.
    fn new(
        what: &'static str,
        hard: f64,
        soft: f64,
        unit: &'static str,
    ) -> Result<Self, ParameterError> {
        let per = if soft > 0.0 { 1.0 / soft } else { 0.0 };
        Ok(Self {
            from: rounded(what, hard - soft, unit)?,
            per: rounded(what, per, unit)?,
            hard: rounded(what, hard, unit)?,
        })
    }

    /// How far into the zone, 0 to 1.
    #[inline]
    fn depth(&self, value: F) -> F {
        clamp((value - self.from) * self.per, F::ZERO, F::ONE)
    }
}

/// The limits of motion, made of good parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MotionLimits<F> {
    /// 1/T.
    rate: F,
    /// 1 − e^(−ωT), ω the bandwidth.
    follow: F,
    /// Towards high, and towards −low.
    workspace: Option<[Zone<F>; 2]>,
    speed: Option<Zone<F>>,
    /// b, N·s/m.
    braking: F,
    /// Share of the braking that fades in a sample.
    fade: F,
}

/// Last position, velocity, and what is left of the braking after a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Motion<F, const D: usize> {
    last: Option<SVector<F, D>>,
    /// Δ, m.
    pub(super) moved: SVector<F, D>,
    /// If Δ was measured; else it is 0.
    pub(super) known: bool,
    /// m/s.
    pub(super) velocity: SVector<F, D>,
    /// 1 before a fault, then down to 0.
    left: F,
}

impl<F: Real, const D: usize> Motion<F, D> {
    pub(super) fn at_rest() -> Self {
        Self {
            last: None,
            moved: SVector::from([F::ZERO; D]),
            known: false,
            velocity: SVector::from([F::ZERO; D]),
            left: F::ONE,
        }
    }

    /// The braking of the next fault is whole again.
    pub(super) fn rearm(&mut self) {
        self.left = F::ONE;
    }

    /// Where the device is, is not known, and a force that opposes its motion neither.
    pub(super) fn lose(&mut self) {
        *self = Self {
            left: F::ZERO,
            ..Self::at_rest()
        };
    }

    /// No braking with an actuator that does not obey.
    pub(super) fn forgo_braking(&mut self) {
        self.left = F::ZERO;
    }
}

impl<F: Real> MotionLimits<F> {
    /// # Errors
    /// A limit outside the range that its field states.
    pub(super) fn new(limits: &Limits, sample_time: f64) -> Result<Self, ParameterError> {
        let bandwidth = positive(
            "bandwidth of the velocity",
            limits.velocity_bandwidth.0,
            "Hz",
        )?;
        let fade_time = positive("braking time", limits.braking_time.0, "s")?;
        let braking = match limits.braking {
            Some(braking) => rounded("braking", positive("braking", braking.0, "N·s/m")?, "N·s/m")?,
            None => F::ZERO,
        };
        let follow = -libm::expm1(-core::f64::consts::TAU * bandwidth * sample_time);
        Ok(Self {
            rate: rounded("sample rate", 1.0 / sample_time, "Hz")?,
            follow: rounded("bandwidth of the velocity", follow, "of the sample rate")?,
            workspace: limits.workspace.map(workspace).transpose()?,
            speed: limits.speed.map(speed).transpose()?,
            braking,
            fade: rounded(
                "braking time",
                f64::min(sample_time / fade_time, 1.0),
                "samples⁻¹",
            )?,
        })
    }

    /// Takes a finite position: Δ, and v ← v + (1 − e^(−ωT))·(Δ/T − v). A velocity beyond the number type is a
    /// fault and counts as none.
    #[inline]
    pub(super) fn follow<const D: usize>(
        &self,
        motion: &mut Motion<F, D>,
        position_m: &SVector<F, D>,
    ) -> Result<(), Fault> {
        let last = motion.last.replace(*position_m);
        motion.known = last.is_some();
        let last = last.unwrap_or(*position_m);
        let mut outcome = Ok(());
        for axis in 0..D {
            let moved = position_m[axis] - last[axis];
            let velocity = motion.velocity[axis];
            let velocity = velocity + self.follow * (moved * self.rate - velocity);
            let finite = velocity.is_finite() && moved.is_finite();
            let or_none = |value| if finite { value } else { F::ZERO };
            motion.moved[axis] = or_none(moved);
            motion.velocity[axis] = or_none(velocity);
            if !finite {
                motion.known = false;
                outcome = Err(Fault::Velocity);
            }
        }
        outcome
    }

    /// Beyond which hard limit the device is.
    #[inline]
    pub(super) fn breach<const D: usize>(
        &self,
        motion: &Motion<F, D>,
        position_m: &SVector<F, D>,
    ) -> Result<(), Fault> {
        for (&x, &v) in position_m.iter().zip(&motion.velocity) {
            if let Some([high, low]) = &self.workspace
                && (x > high.hard || -x > low.hard)
            {
                return Err(Fault::Workspace);
            }
            if self.speed.is_some_and(|speed| v.abs() > speed.hard) {
                return Err(Fault::Velocity);
            }
        }
        Ok(())
    }

    /// Adds −p·b·v to a force, p the deeper of the zones that an axis is in.
    #[inline]
    pub(super) fn brake<const D: usize>(
        &self,
        motion: &Motion<F, D>,
        position_m: &SVector<F, D>,
        force: &mut SVector<F, D>,
    ) -> Limiters {
        let mut limiters = Limiters::NONE;
        for axis in 0..D {
            let (x, v) = (position_m[axis], motion.velocity[axis]);
            let mut share = F::ZERO;
            if let Some([high, low]) = &self.workspace {
                // Only outwards.
                share = if v > F::ZERO {
                    high.depth(x)
                } else {
                    low.depth(-x)
                };
                if share > F::ZERO {
                    limiters.insert(Limiters::WORKSPACE);
                }
            }
            if let Some(speed) = &self.speed {
                let depth = speed.depth(v.abs());
                if depth > F::ZERO {
                    limiters.insert(Limiters::VELOCITY);
                }
                if depth > share {
                    share = depth;
                }
            }
            force[axis] -= share * self.braking * v;
        }
        limiters
    }

    /// The force after a fault or stop: braking that fades out, then exactly zero.
    #[inline]
    pub(super) fn fading<const D: usize>(&self, motion: &mut Motion<F, D>) -> SVector<F, D> {
        if motion.left <= F::ZERO || self.braking <= F::ZERO {
            return SVector::from([F::ZERO; D]);
        }
        let damping = motion.left * self.braking;
        motion.left -= self.fade;
        motion.velocity.map(|v| -(damping * v))
    }
}

fn workspace<F: Real>(workspace: Workspace) -> Result<[Zone<F>; 2], ParameterError> {
    let (low, high, soft) = (workspace.low.0, workspace.high.0, workspace.soft.0);
    range(
        "low end of the workspace",
        low,
        true,
        "a finite number of",
        "m",
    )?;
    range(
        "high end of the workspace",
        high,
        high > low,
        "above the low one, in",
        "m",
    )?;
    let fits = (0.0..=0.5 * (high - low)).contains(&soft);
    let allowed = "0 to half the workspace, in";
    range("soft zone of the workspace", soft, fits, allowed, "m")?;
    Ok([
        Zone::new("high end of the workspace", high, soft, "m")?,
        Zone::new("low end of the workspace", -low, soft, "m")?,
    ])
}

fn speed<F: Real>(speed: SpeedLimit) -> Result<Zone<F>, ParameterError> {
    let (soft, hard) = (speed.soft.0, speed.hard.0);
    range("soft speed limit", soft, soft >= 0.0, "at least 0", "m/s")?;
    range(
        "speed limit",
        hard,
        hard > soft,
        "above the soft one, in",
        "m/s",
    )?;
    Zone::new("speed limit", hard, hard - soft, "m/s")
}
