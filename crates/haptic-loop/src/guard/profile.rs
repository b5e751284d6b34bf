//! The books of a guard: energy, and the force that a device really makes of the commands that it is sent: later, and through a lag.
//!
//! ```text
//! a(t) = f_k + r_k·e^(−t/τ),  0 ≤ t < T        r_k = a_k − f_k,   a_{k+1} = f_k + q·r_k,   q = e^(−T/τ)
//! g(t) = a(t − (d + h)T)                       d whole samples and a fraction 0 ≤ h < 1 of delay
//! ```
//! The lag does not care when the commands arrive, so a is computed without the delay and looked at later. In the sample
//! where f₀ is followed by f₁, with s = f₀ − f₁, r₁ = q·r₀ + s and e = e^(−(1−h)T/τ):
//!
//! ```text
//! mean of g − f₁      h·s + (τ/T)·\[r₀(e − q) + r₁(1 − e)\]
//! mean of (g − f₁)²   h·s² + (τ/T)·\[2s·r₀(e − q) + ½r₀²(e² − q²) + ½r₁²(1 − e²)\]
//! ```
//! Both are forms in s and r₀: exactly zero while a force is held. Coefficients are computed in `f64` and rounded once.

use crate::error::Checks;
use crate::units::Seconds;
use fracdiff::Real;
use nalgebra::SVector;

/// Most samples between a write and its force that [`EnergyBounding`](super::EnergyBounding) can keep books of.
pub const MAX_GUARD_DELAY_SAMPLES: usize = 4;
/// Longest lag of an actuator that it can, in sample times.
pub const MAX_GUARD_LAG_SAMPLES: usize = 64;

/// Forces that are kept: those of the whole samples of delay, and the two of the sample that is looked at.
const HISTORY: usize = MAX_GUARD_DELAY_SAMPLES + 2;

/// A force that was sent, and what a lag makes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sent<F, const D: usize> {
    /// `f_k`, N.
    pub(super) force: SVector<F, D>,
    /// `r_k`, N: what the actuator makes beyond it when it begins to act.
    pub(super) rest: SVector<F, D>,
    /// (1/4ρb)·∫a² over its sample, J.
    pub(super) cost: F,
}

impl<F: Real, const D: usize> Sent<F, D> {
    pub(super) fn none() -> Self {
        Self::plain(&SVector::from([F::ZERO; D]))
    }

    pub(super) fn plain(force: &SVector<F, D>) -> Self {
        Self {
            force: *force,
            rest: SVector::from([F::ZERO; D]),
            cost: F::ZERO,
        }
    }
}

/// x²·`square` + x·y·`cross` + y²·`rest`, summed over the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Form<F> {
    square: F,
    cross: F,
    rest: F,
}

impl<F: Real> Form<F> {
    /// Too large by `doubt`, J/N², of x² and y², for terms may cancel. A cost beyond the number type is more than there is: no force follows
    /// from it.
    fn new(unit: f64, doubt: F, terms: [f64; 3]) -> Self {
        let [square, cross, rest] = terms.map(|term| F::from_f64(unit * term));
        Self {
            square: square + doubt,
            cross,
            rest: rest + doubt,
        }
    }

    #[inline(never)]
    pub(super) fn of<const D: usize>(&self, x: &SVector<F, D>, y: &SVector<F, D>) -> F {
        let mut sum = F::ZERO;
        for (&x, &y) in x.iter().zip(y) {
            sum += self.square * (x * x) + self.cross * (x * y) + self.rest * (y * y);
        }
        sum
    }
}

/// Delay and lag in units of the sample time, of parameters that were checked.
#[derive(Debug)]
pub(super) struct Timing {
    /// D/T, the middle of the interval of delays.
    pub(super) delay: f64,
    /// Half the width of that interval.
    pub(super) spread: f64,
    /// τ/T, the lag of the actuator in samples.
    pub(super) lag: f64,
}

/// More than the share of a term of the books that roundings make: some ten of them, and two for each sample that a lag remembers.
pub(super) fn doubt<F: Real>() -> F {
    F::from_f64(256.0) * F::EPSILON
}

/// The effect and the possible cost of the forces on their way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Profile<F> {
    /// d, the whole samples of delay.
    whole: usize,
    /// q = e^(−T/τ), the share of a lag's rest that a sample leaves.
    decay: F,
    /// ḡ − f₁ of s and of r₀.
    mean: [F; 2],
    /// (T/4ρb)·Var g, of s and r₀.
    variance: Form<F>,
    /// (1/4ρb)·∫a² over a sample, of f and r.
    whole_cost: Form<F>,
    /// Cost as in `whole_cost`, over the last hT of a sample.
    late_cost: Form<F>,
    /// (1/4ρb)·∫a² from a command f on, all later ones being zero, of f and a.
    command_cost: Form<F>,
}

impl<F: Real> Profile<F> {
    /// `unit` is T/(4ρb), J/N².
    #[inline(never)]
    pub(super) fn new(timing: &Timing, unit: f64) -> Self {
        // A delay 1e-9 below a whole number of samples is that number.
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 ≤ delay ≤ 4"
        )]
        let whole = (timing.delay + 1e-9) as u32;
        let h = f64::max(timing.delay - f64::from(whole), 0.0);
        let lag = timing.lag;
        // e^(−time/lag)
        let fade = |time: f64| {
            if lag > 0.0 {
                1.0 + libm::expm1(-time / lag)
            } else {
                0.0
            }
        };
        let (q, e) = (fade(1.0), fade(1.0 - h));
        let (late, early) = (lag * (e - q), lag * (1.0 - e));
        let late_square = 0.5 * late * (e + q);
        let early_square = 0.5 * early * (1.0 + e);
        let all = late + early;
        // r₁ = q·r₀ + s
        let mean = [h + early, late + q * early];
        let variance = [
            h + early_square - mean[0] * mean[0],
            2.0 * (late + q * early_square - mean[0] * mean[1]),
            late_square + q * q * early_square - mean[1] * mean[1],
        ];
        let costs = [
            variance,
            [1.0, 2.0 * all, 0.5 * all * (1.0 + q)],
            [h, 2.0 * late, late_square],
            [1.0 - all, all, 0.5 * lag],
        ];
        let doubt = F::from_f64(4.0) * doubt::<F>() * F::from_f64(unit);
        let [variance, whole_cost, late_cost, command_cost] =
            costs.map(|terms| Form::new(unit, doubt, terms));
        Self {
            whole: whole as usize,
            decay: F::from_f64(q),
            mean: mean.map(F::from_f64),
            variance,
            whole_cost,
            late_cost,
            command_cost,
        }
    }

    /// ḡ over the sample that is over, N, and (T/4ρb)·Var g, J.
    #[inline]
    pub(super) fn acted<const D: usize>(&self, sent: &[Sent<F, D>; HISTORY]) -> (SVector<F, D>, F) {
        let (new, old) = (&sent[self.whole], &sent[self.whole + 1]);
        let (mut mean, mut step) = (new.force, new.force);
        for axis in 0..D {
            step[axis] = old.force[axis] - new.force[axis];
            mean[axis] += self.mean[0] * step[axis] + self.mean[1] * old.rest[axis];
        }
        (mean, self.variance.of(&step, &old.rest))
    }

    /// (1/4ρb)·∫g² from now to the effect of the next command, J.
    #[inline(never)]
    pub(super) fn on_its_way<const D: usize>(&self, sent: &[Sent<F, D>; HISTORY]) -> F {
        let late = &sent[self.whole];
        let mut cost = self.late_cost.of(&late.force, &late.rest);
        for sent in &sent[..self.whole] {
            cost += sent.cost;
        }
        cost
    }

    /// q·r, the rest of r when the next command takes effect, N: there a = f + q·r.
    #[inline]
    pub(super) fn fading<const D: usize>(&self, last: &Sent<F, D>) -> SVector<F, D> {
        /// Below this it has decayed, N: its square would be no normal number.
        const NONE: f64 = 1e-15;
        let mut fading = last.rest;
        for rest in &mut fading {
            *rest = self.decay * *rest;
            if rest.abs() < F::from_f64(NONE) {
                *rest = F::ZERO;
            }
        }
        fading
    }

    /// The next command with what a lag makes of it. r is small where a force is held: nothing in it is rounded as the force is.
    #[inline]
    pub(super) fn send<const D: usize>(
        &self,
        force: &SVector<F, D>,
        last: &Sent<F, D>,
        fading: &SVector<F, D>,
    ) -> Sent<F, D> {
        let mut rest = *fading;
        for (axis, rest) in rest.iter_mut().enumerate() {
            *rest += last.force[axis] - force[axis];
        }
        Sent {
            force: *force,
            rest,
            cost: self.whole_cost.of(force, &rest),
        }
    }

    /// The cost of a command f and what follows it, in powers of a scale of f: f², f and 1.
    #[inline(never)]
    pub(super) fn command<const D: usize>(
        &self,
        force: &SVector<F, D>,
        actuator: &SVector<F, D>,
    ) -> [F; 3] {
        [
            self.command_cost.square * dot(force, force),
            self.command_cost.cross * dot(force, actuator),
            self.command_cost.rest * dot(actuator, actuator),
        ]
    }
}

#[inline]
pub(super) fn dot<F: Real, const D: usize>(left: &SVector<F, D>, right: &SVector<F, D>) -> F {
    let mut sum = F::ZERO;
    for (&left, &right) in left.iter().zip(right) {
        sum += left * right;
    }
    sum
}

/// Energy and the forces on their way, newest first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GuardState<F, const D: usize> {
    /// E is this and `rest`.
    energy: F,
    /// Rounding error of `energy`, and energy spent since the last sample, J.
    rest: F,
    /// The energy still to be paid for noise, J.
    pub(super) owed: F,
    pub(super) sent: [Sent<F, D>; HISTORY],
}

impl<F: Real, const D: usize> GuardState<F, D> {
    pub(crate) fn at_rest() -> Self {
        Self {
            energy: F::ZERO,
            rest: F::ZERO,
            owed: F::ZERO,
            sent: [Sent::none(); HISTORY],
        }
    }

    #[inline]
    pub(crate) fn energy(&self) -> F {
        self.energy + self.rest
    }

    /// E ← min(0, E), also of what is not finite.
    pub(crate) fn forget_credit(&mut self) {
        let is_debt = self.energy() < F::ZERO;
        if !is_debt {
            (self.energy, self.rest) = (F::ZERO, F::ZERO);
        }
    }

    /// The device has let go on its own: no force is on its way any more, and no credit remains.
    pub(crate) fn let_go(&mut self) {
        self.sent = [Sent::none(); HISTORY];
        self.forget_credit();
    }

    /// Takes the energy of a sample, J. The sum is compensated (W. Kahan, Comm. ACM 8(1), 1965); it is off by a rounding of `work` at
    /// most. One that is not finite is no credit, and keeps a debt.
    #[inline]
    pub(super) fn add(&mut self, work: F) {
        let work = work + self.rest;
        let energy = self.energy + work;
        if energy.is_finite() {
            self.rest = work - (energy - self.energy);
            self.energy = energy;
        } else {
            self.forget_credit();
        }
    }

    #[inline]
    pub(super) fn spend(&mut self, cost: F) {
        self.rest -= cost;
    }

    /// Spends this share of a surplus, J, if there is one.
    #[inline]
    pub(super) fn forget(&mut self, surplus: F, share: F) {
        /// No force is felt for less, J, which stays: it would soon be no normal number.
        const NOTHING: f64 = 1e-25;
        if surplus > F::from_f64(NOTHING) {
            self.spend(surplus * share);
        }
    }

    #[inline]
    pub(super) fn push(&mut self, sent: Sent<F, D>) {
        for age in (1..HISTORY).rev() {
            self.sent[age] = self.sent[age - 1];
        }
        self.sent[0] = sent;
    }
}

/// T/τ, the share of a surplus that is forgotten in a sample; 1 for τ = 0.
pub(super) fn forgotten<F: Real>(forget: Seconds, sample_time: f64, checks: &mut Checks) -> F {
    let what = "time in which the guard forgets";
    checks.not_negative(what, forget.0, "s");
    if forget.0 <= 0.0 {
        return F::ONE;
    }
    let whole = forget.0 >= sample_time;
    checks.range(what, forget.0, whole, "0 or at least the sample time", "s");
    F::from_f64(sample_time / forget.0)
}
