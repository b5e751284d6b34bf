//! Velocity from positions, the limits of motion, and braking.

use super::clamps::{clamp, whole_ticks};
use super::force::{Fault, Limiters};
use super::limits::{SafetyLimits, SpeedLimit, Stuck, Workspace};
use crate::error::{Checks, LoopParameterError};
use fracdiff::{Real, Seconds};
use nalgebra::SVector;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MotionWatch<F> {
    /// 1/T.
    rate: F,
    /// 1 − e^(−ωT), ω the bandwidth.
    follow: F,
    workspace: Option<Ends<F>>,
    /// Ends for each of several axes, in place of `workspace`.
    #[cfg(feature = "std")]
    workspace_box: Option<[Ends<F>; 3]>,
    speed: Option<Zone<F>>,
    jump: Option<Jump<F>>,
    stuck: Option<Standstill<F>>,
    /// b, N·s/m, of the braking −p·b·v.
    braking: F,
}

/// The farthest that a position moves in a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Jump<F> {
    /// Motion, m, that is allowed beyond the step.
    allowance: F,
    /// Step by the speed limit, m.
    step: F,
}

/// See [`Stuck`](super::Stuck).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Standstill<F> {
    /// Rise of the wanted force, N, beyond which a reading should have moved.
    force: F,
    ticks: F,
}

impl<F: Real> Standstill<F> {
    /// An axis whose reading has not changed. On its own: a device that moves never comes here.
    #[inline(never)]
    fn stands(&self, still: &mut F, least: &mut F, wanted: F, sent: F) -> bool {
        if *still < self.ticks {
            *still += F::ONE;
            *least = wanted;
            return false;
        }
        let stands = wanted > *least + self.force && sent.abs() > self.force;
        if wanted < *least {
            *least = wanted;
        }
        stands
    }
}

/// A zone in which motion is braked: not below `from`, fully at from + 1/`per`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Zone<F> {
    from: F,
    per: F,
    hard: F,
}

impl<F: Real> Zone<F> {
    /// `soft` wide, up to `hard`; no zone if it has no width.
    #[inline(never)]
    fn new(
        what: &'static str,
        hard: f64,
        soft: f64,
        unit: &'static str,
        checks: &mut Checks,
    ) -> Self {
        let per = if soft > 0.0 { 1.0 / soft } else { 0.0 };
        Self {
            from: checks.rounded(what, hard - soft, unit),
            per: checks.rounded(what, per, unit),
            hard: checks.rounded(what, hard, unit),
        }
    }

    /// Depth into the zone, 0 to 1.
    #[inline]
    fn depth(&self, value: F) -> F {
        clamp((value - self.from) * self.per, F::ZERO, F::ONE)
    }
}

/// The ends of a workspace: towards high, and towards −low.
type Ends<F> = [Zone<F>; 2];

/// The zones at the ends of a workspace; refuses an empty or inverted one.
fn workspace<F: Real>(workspace: Workspace, checks: &mut Checks) -> Ends<F> {
    let (low, high, soft) = (workspace.low.0, workspace.high.0, workspace.soft.0);
    checks.range("low end of the workspace", low, true, "finite", "m");
    let (what, allowed) = ("high end of the workspace", "above the low one");
    checks.range(what, high, high > low, allowed, "m");
    let fits = (0.0..=0.5 * (high - low)).contains(&soft);
    let allowed = "from 0 to half the workspace";
    checks.range("workspace soft zone", soft, fits, allowed, "m");
    [
        Zone::new(what, high, soft, "m", checks),
        Zone::new("low end of the workspace", -low, soft, "m", checks),
    ]
}

/// The zone below a speed limit; refuses one that is not above the soft limit.
fn speed<F: Real>(speed: SpeedLimit, checks: &mut Checks) -> Zone<F> {
    let (soft, hard) = (speed.soft.0, speed.hard.0);
    checks.not_negative("soft speed limit", soft, "m/s");
    let (what, allowed) = ("speed limit", "above the soft one");
    checks.range(what, hard, hard > soft, allowed, "m/s");
    Zone::new(what, hard, hard - soft, "m/s", checks)
}

/// Last position, velocity, for how long it has stood still, and whether braking is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Motion<F, const D: usize> {
    last: Option<SVector<F, D>>,
    /// Δ, m, from the last position to this one.
    pub(super) moved: SVector<F, D>,
    /// If Δ was measured; else it is 0.
    pub(super) known: bool,
    /// Velocity, m/s, Δ/T through a low-pass filter.
    pub(super) velocity: SVector<F, D>,
    /// 1 over the samples from the last position to the next: 1 unless some did not come.
    share: F,
    /// Samples since each reading changed, up to the stuck time.
    still: SVector<F, D>,
    /// Least magnitude of the wanted force since then, N.
    least: SVector<F, D>,
    /// A damper can oppose the motion.
    pub(super) brakes: bool,
}

impl<F: Real, const D: usize> Motion<F, D> {
    pub(super) fn at_rest() -> Self {
        Self {
            last: None,
            moved: SVector::from([F::ZERO; D]),
            known: false,
            velocity: SVector::from([F::ZERO; D]),
            share: F::ONE,
            still: SVector::from([F::ZERO; D]),
            least: SVector::from([F::ZERO; D]),
            brakes: true,
        }
    }

    /// The next position comes after `samples` missed ones.
    pub(super) fn skip(&mut self, samples: F) {
        self.share = F::ONE / (F::ONE + samples);
    }

    /// The next position comes in time.
    #[inline]
    pub(super) fn in_time(&mut self) {
        self.share = F::ONE;
    }

    /// Forgets the position: it is not known any more, nor is a force that opposes the motion.
    pub(super) fn lose(&mut self) {
        *self = Self {
            brakes: false,
            ..Self::at_rest()
        };
    }
}

impl<F: Real> MotionWatch<F> {
    pub(super) fn new(limits: &SafetyLimits, sample_time: f64, checks: &mut Checks) -> Self {
        let bandwidth = checks.positive("velocity bandwidth", limits.velocity_bandwidth.0, "Hz");
        let braking = limits.braking.map_or(F::ZERO, |braking| {
            accepted_braking(limits, braking.0, sample_time, checks)
        });
        let follow = -libm::expm1(-core::f64::consts::TAU * bandwidth * sample_time);
        Self {
            rate: checks.rounded("sample rate", 1.0 / sample_time, "Hz"),
            follow: checks.rounded("velocity bandwidth", follow, "of the sample rate"),
            workspace: limits.workspace.map(|ends| workspace(ends, checks)),
            #[cfg(feature = "std")]
            workspace_box: limits
                .workspace_box
                .map(|axes| axes.map(|ends| workspace(ends, checks))),
            speed: limits.speed.map(|ends| speed(ends, checks)),
            jump: jump(limits, sample_time, checks),
            stuck: limits
                .stuck
                .map(|stuck| standstill(stuck, sample_time, checks)),
            braking,
        }
    }

    #[inline]
    #[cfg_attr(
        not(feature = "std"),
        expect(unused_variables, reason = "the same on each axis")
    )]
    fn ends<const D: usize>(&self, axis: usize) -> Option<&Ends<F>> {
        #[cfg(feature = "std")]
        if let Some(axes) = self.workspace_box.as_ref().filter(|_| D > 1) {
            return Some(&axes[axis.min(2)]);
        }
        self.workspace.as_ref()
    }

    /// Takes a finite position: Δ, and v ← v + (1 − e^(−ωT))·(Δ/T − v), where T is the time since the last position. A velocity
    /// beyond the number type is a fault and counts as none.
    #[inline]
    pub(super) fn follow<const D: usize>(
        &self,
        motion: &mut Motion<F, D>,
        position_m: &SVector<F, D>,
    ) -> Result<(), Fault> {
        let rate = self.rate * motion.share;
        let last = motion.last.replace(*position_m);
        motion.known = last.is_some();
        let last = last.unwrap_or(*position_m);
        let mut outcome = Ok(());
        for axis in 0..D {
            let moved = position_m[axis] - last[axis];
            let velocity = motion.velocity[axis];
            let velocity = velocity + self.follow * (moved * rate - velocity);
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
        self.jumped(&motion.moved, motion.share)?;
        for axis in 0..D {
            self.left(axis, position_m)?;
            let v = motion.velocity[axis];
            if self.speed.is_some_and(|speed| v.abs() > speed.hard) {
                return Err(Fault::Velocity);
            }
        }
        Ok(())
    }

    /// Beyond which limit of a position alone the device is between two ticks.
    pub(super) fn strays<const D: usize>(
        &self,
        motion: &Motion<F, D>,
        position_m: &SVector<F, D>,
    ) -> Result<(), Fault> {
        let last = motion.last.unwrap_or(*position_m);
        let moved = SVector::from_fn(|axis, _| position_m[axis] - last[axis]);
        self.jumped::<D>(&moved, F::ONE)?;
        (0..D).try_for_each(|axis| self.left(axis, position_m))
    }

    #[inline]
    fn jumped<const D: usize>(&self, moved: &SVector<F, D>, share: F) -> Result<(), Fault> {
        if let Some(jump) = &self.jump {
            let jumped = |moved: &F| (moved.abs() - jump.allowance) * share > jump.step;
            if moved.iter().any(jumped) {
                return Err(Fault::PositionJump);
            }
        }
        Ok(())
    }

    /// The workspace, if the device has left it on this axis.
    #[inline]
    fn left<const D: usize>(&self, axis: usize, position_m: &SVector<F, D>) -> Result<(), Fault> {
        let x = position_m[axis];
        match self.ends::<D>(axis) {
            Some([high, low]) if x > high.hard || -x > low.hard => Err(Fault::Workspace),
            Some(_) | None => Ok(()),
        }
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
            if let Some([high, low]) = self.ends::<D>(axis) {
                // Only outwards.
                let (zone, x) = if v > F::ZERO { (high, x) } else { (low, -x) };
                share = zone.depth(x);
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
            if share > F::ZERO {
                force[axis] -= share * self.braking * v;
            }
        }
        limiters
    }

    /// True if a reading stands still while the force grows: see [`Stuck`](super::Stuck). `wanted` is finite,
    /// `sent` the last force, `most` the limit of a force.
    #[inline]
    pub(super) fn stands_still<const D: usize>(
        &self,
        motion: &mut Motion<F, D>,
        wanted: &SVector<F, D>,
        sent: &SVector<F, D>,
        most: F,
    ) -> bool {
        let Some(stuck) = &self.stuck else {
            return false;
        };
        let mut stands = false;
        for axis in 0..D {
            let wanted = clamp(wanted[axis].abs(), F::ZERO, most);
            let (still, least) = (&mut motion.still[axis], &mut motion.least[axis]);
            if motion.moved[axis].abs() > F::ZERO {
                (*still, *least) = (F::ZERO, wanted);
            } else {
                stands |= stuck.stands(still, least, wanted, sent[axis]);
            }
        }
        stands
    }

    /// The force after a fault or stop: braking, of which this share is left, or none.
    #[inline]
    pub(super) fn fading<const D: usize>(&self, motion: &Motion<F, D>, left: F) -> SVector<F, D> {
        if !motion.brakes || self.braking <= F::ZERO {
            return SVector::from([F::ZERO; D]);
        }
        let damping = left * self.braking;
        motion.velocity.map(|v| -(damping * v))
    }
}

/// Above 0, and at most what the device bears.
fn accepted_braking<F: Real>(
    limits: &SafetyLimits,
    braking: f64,
    sample_time: f64,
    checks: &mut Checks,
) -> F {
    if let Some(mass) = limits.device_mass {
        checks.positive("device mass", mass.0, "kg");
    }
    let most = limits.braking_max(Seconds(sample_time)).0;
    checks.positive("braking", braking, "N·s/m");
    if braking > most {
        checks.refuse(LoopParameterError::Braking {
            value_n_s_per_m: braking,
            most_n_s_per_m: most,
            mass_known: limits.device_mass.is_some(),
        });
    }
    checks.rounded("braking", braking, "N·s/m")
}

fn jump<F: Real>(limits: &SafetyLimits, sample_time: f64, checks: &mut Checks) -> Option<Jump<F>> {
    let allowance = checks.positive("jump", limits.jump?.0, "m");
    let hard = limits.speed?.hard.0;
    Some(Jump {
        allowance: checks.rounded("jump", allowance, "m"),
        step: checks.rounded("step at the speed limit", hard * sample_time, "m"),
    })
}

fn standstill<F: Real>(stuck: Stuck, sample_time: f64, checks: &mut Checks) -> Standstill<F> {
    let force = checks.positive("stuck force", stuck.force.0, "N");
    let time = stuck.time.0;
    let within = (1e-3..=10.0).contains(&time);
    checks.range("stuck time", time, within, "in [0.001, 10] {}", "s");
    let ticks = whole_ticks(time, sample_time);
    Standstill {
        force: checks.rounded("stuck force", force, "N"),
        ticks: checks.rounded("stuck time", ticks, "samples"),
    }
}
