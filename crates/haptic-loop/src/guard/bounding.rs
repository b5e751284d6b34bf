//! Energy bounding: the force never needs more energy than is available.

use super::profile::{
    GuardState, MAX_GUARD_DELAY_SAMPLES, MAX_GUARD_LAG_SAMPLES, Profile, Timing, dot, doubt,
    forgotten,
};
use crate::error::Checks;
use crate::units::{Metres, NewtonSecondsPerMetre, Seconds};
use fracdiff::Real;
use nalgebra::SVector;

/// Energy bounding: the force is never larger than the energy at hand can pay for.
///
/// Let g(t) be the force that the device makes from the commands it received: delayed by D = (d +
/// h)T, through a lag τ. Over a sample it has the mean ḡ and the variance Var g, known from the
/// forces that were sent.
///
/// ```text
/// E\[n\] = E\[n−1\] − ḡ·Δ\[n\] + ρ(b/T)·|Δ\[n\]|² − (T/4ρb)·Var g          the books
/// E\[n\] ≥ (1/4ρb)·∫ g(t)² dt over all time to come if every later force is zero       before f\[n\] leaves
/// ```
/// - *Why it is passive*: with the damping ρb of the device, and whatever the motion inside a sample, its energy changes by
///   at least what the books say, and that by at least −(1/4ρb)∫g² over the sample. So what the rule keeps covered
///   pays for the worst motion, zero may always be sent next, and E ≥ 0 for ever.
/// - *The rule* is quadratic in f\[n\]. A force that is too large is scaled down, direction kept; at worst to zero.
/// - *An interval* of delays instead of one, W wide: the force differs from the one with the delay in its middle, D, by at most
///   N = ⌈W/2T⌉ steps f\[k\] − f\[k−1\] for W/2 each, and a lag makes the square integral of that no larger. A part ρ₂ of ρ pays
///   for it, N·(W/2)·|f\[n\] − f\[n−1\]|²/(4ρ₂b) at each command and the same for the way back to zero; ρ₁ pays for the rest.
///   Each command may have its own delay, as long as they keep their order. ρ₁ and ρ₂ make the price least.
/// - *Why it comes to rest*: for ρ < 1 the rest of the damping, (1 − ρ)b, takes energy from any motion.
/// - *Price*: a spring is no stiffer than (2ρb/T)/(1 + D/T + τ/2T), and with an interval divided by (1 + √(N·W/2/(T + D + τ/2)))²;
///   for b = 3.5 N·s/m, T = 2 ms, ρ = 0.8 and no delay that is 2800 N/m of the 3500 at which a spring stops being
///   passive. A passive wall below that is left as it is.
/// - *Surplus*: energy beyond what must be covered is forgotten with the time `forget`. At 0 it is given up at once,
///   and even a soft spring comes back up to a quarter too weak; a time longer than a touch avoids that.
/// - *Noise* σ of the position looks like motion. Each sample and axis owes 2ρ(b/T)σ² for it, paid with energy beyond what
///   the force of the sample before needs: so a force that is held is not spent. At most 1000 samples are owed.
/// - *Needs* b, D and τ as they are. b said 1.25 times too large uses up ρ = 0.8; beyond that walls shake again. A delay
///   rounded to whole samples is not safe, in neither direction: say the fraction, or an interval.
/// - *Rounding* gives no energy, in `f32` as in `f64`: sums are compensated, and each gain is booked by 256 steps of the last place too
///   small, 3e-5 of it in `f32`, each cost by as much too large. What counts are the positions and forces as numbers of the loop.
/// - *Start-up*: no energy. After a position that was lost the worst motion is booked. *Not finite* energy is no
///   credit, and no force follows from it.
/// - *Cost*: some 30 multiply-adds per axis; while it acts one division and one square root.
///
/// Source: J.-P. Kim, J. Ryu, *Robustly stable haptic interaction control using an energy-bounding algorithm*,
/// Int. J. Robotics Research 29(6), 2010, for the idea (the hold's energy bounded by what the device's damping
/// takes); this form, with delay, lag, surplus and several axes, is derived here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyBounding {
    /// b > 0, N·s/m: viscous damping that the device surely has, on each axis.
    pub device_damping: NewtonSecondsPerMetre,
    /// ρ in (0, 1\]: the share of that damping that the loop may use up.
    pub share: f64,
    /// 0 or at least a sample time: how long a surplus of energy lasts. At 0 it is discarded at
    /// once.
    pub forget: Seconds,
    /// Shortest delay from measuring a position to the effect of its force, beyond the hold; at
    /// least 0.
    pub delay_least: Seconds,
    /// Longest such delay: at least `delay_least`, at most
    /// [`MAX_GUARD_DELAY_SAMPLES`](super::MAX_GUARD_DELAY_SAMPLES) sample times. The same as
    /// `delay_least` if the delay is known.
    pub delay_most: Seconds,
    /// τ: time constant with which the actuator's force follows, 0 to
    /// [`MAX_GUARD_LAG_SAMPLES`](super::MAX_GUARD_LAG_SAMPLES) sample times.
    pub current_lag: Seconds,
    /// σ, m, at least 0: standard deviation of the noise of the position.
    pub noise: Metres,
}

impl EnergyBounding {
    /// ρ = 0.8, a surplus for half a second; no delay, lag or noise: an ideal device.
    #[must_use]
    pub const fn of(device_damping: NewtonSecondsPerMetre) -> Self {
        Self {
            device_damping,
            share: 0.8,
            forget: Seconds(0.5),
            delay_least: Seconds(0.0),
            delay_most: Seconds(0.0),
            current_lag: Seconds(0.0),
            noise: Metres(0.0),
        }
    }
}

fn check(bounding: &EnergyBounding, sample_time: f64, checks: &mut Checks) {
    let (share, noise) = (bounding.share, bounding.noise.0);
    let (damping, lag) = (bounding.device_damping.0, bounding.current_lag.0);
    let (least, most) = (bounding.delay_least.0, bounding.delay_most.0);
    // With room for a rounding to single precision.
    let reach = |samples: usize| (1.0 + 1e-6) * sample_time * samples as f64;
    let late = most >= least && most <= reach(MAX_GUARD_DELAY_SAMPLES);
    let slow = lag >= 0.0 && lag <= reach(MAX_GUARD_LAG_SAMPLES);
    checks.positive("damping of the device", damping, "N·s/m");
    let some = share > 0.0 && share <= 1.0;
    checks.range("share of the damping", share, some, "in (0, 1]", "");
    checks.not_negative("device noise", noise, "m");
    checks.not_negative("least delay of the guard", least, "s");
    let delays = "from the least delay to 4 sample times";
    checks.range("delay of the guard", most, late, delays, "s");
    let lags = "from 0 to 64 sample times";
    checks.range("lag of the actuator", lag, slow, lags, "s");
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounding<F> {
    /// ρ₁b/T, N/m.
    damping: F,
    /// T/(2ρ₁b), m/N.
    per_force: F,
    /// 2ρ₁(b/T)σ², J.
    noise: F,
    /// T/`forget`.
    forgotten: F,
    /// N·(W/2)/(4ρ₂b), J/N².
    step: F,
    profile: Profile<F>,
}

impl<F: Real> Bounding<F> {
    #[inline(never)]
    pub(super) fn new(bounding: &EnergyBounding, sample_time: f64, checks: &mut Checks) -> Self {
        check(bounding, sample_time, checks);
        let t = sample_time;
        let (share, noise) = (bounding.share, bounding.noise.0);
        let (damping, lag) = (bounding.device_damping.0, bounding.current_lag.0);
        let (least, most) = (bounding.delay_least.0, bounding.delay_most.0);
        let timing = Timing {
            delay: 0.5 * (least + most) / t,
            spread: 0.5 * (most - least) / t,
            lag: lag / t,
        };
        // ρb/T, and the parts of it that make (1 + D/T + τ/2T)/ρ₁ + N·(W/2T)/ρ₂ least.
        let whole = share * damping / t;
        let held = 1.0 + timing.delay + 0.5 * timing.lag;
        let steps = if timing.spread > 1.0 { 2.0 } else { 1.0 };
        let uncertain = steps * timing.spread;
        let root = libm::sqrt(uncertain / held);
        let damping = whole / (1.0 + root);
        let unit = 0.25 / damping;
        let rounded = checks.rounded::<F>("bound of the guard", damping, "N/m");
        let noise = F::from_f64(noise);
        Self {
            damping: rounded * (F::ONE - doubt()),
            per_force: F::from_f64(0.5) / rounded,
            noise: (rounded + rounded) * noise * noise,
            forgotten: forgotten(bounding.forget, sample_time, checks),
            // N·(W/2T)/(4ρ₂b/T), ρ₂ = ρ·root/(1 + root).
            step: F::from_f64(held * root * unit) * (F::ONE + doubt()),
            profile: Profile::new(&timing, unit),
        }
    }

    /// Bounds the force that is about to be sent, and keeps it; says whether it was made smaller. Not inlined: every tick
    /// function would have a copy.
    #[inline(never)]
    pub(super) fn bound<const D: usize>(
        &self,
        state: &mut GuardState<F, D>,
        moved: Option<&SVector<F, D>>,
        force: &mut SVector<F, D>,
    ) -> bool {
        self.observe(state, moved);
        let (profile, step) = (&self.profile, self.step);
        let last = state.sent[0];
        let fading = profile.fading(&last);
        let actuator = last.force + fading;
        if self.noise > F::ZERO {
            self.pay_for_noise(state, &actuator);
        }
        // Cost of f from now on: s²·square + s·along + zero for s·f.
        let [square, along, zero] = profile.command(force, &actuator);
        let square = square + (step + step) * dot(force, force);
        let along = along - (step + step) * dot(force, &last.force);
        let back = step * dot(&last.force, &last.force);
        let zero = zero + back + profile.on_its_way(&state.sent);
        let energy = state.energy();
        let spare = energy - zero;
        let mut cost = square + along;
        let within = cost <= spare;
        if !within {
            let scale = scale(square, along, spare);
            cost = scale * (scale * square + along);
            for axis in force.iter_mut() {
                *axis = *axis * scale;
            }
        }
        state.forget(energy - (zero + cost), self.forgotten);
        let mut paid = F::ZERO;
        for (&force, &last) in force.iter().zip(&last.force) {
            paid += step * ((force - last) * (force - last));
        }
        state.spend(paid);
        state.push(profile.send(force, &last, &fading));
        !within && square > F::ZERO
    }

    /// E ← E − ḡ·Δ + ρ(b/T)|Δ|² − (T/4ρb)·Var g; of a motion that is not known the worst, Δ = (T/2ρb)·ḡ.
    #[inline]
    fn observe<const D: usize>(&self, state: &mut GuardState<F, D>, moved: Option<&SVector<F, D>>) {
        let (mean, variance) = self.profile.acted(&state.sent);
        let mut work = -variance;
        for axis in 0..D {
            let worst = self.per_force * mean[axis];
            let moved = moved.map_or(worst, |moved| moved[axis]);
            let gain = (self.damping * moved - mean[axis]) * moved;
            work += gain - doubt::<F>() * gain.abs();
        }
        state.add(work);
    }

    /// Energy beyond what it takes to send the last force again pays for noise.
    #[inline]
    fn pay_for_noise<const D: usize>(
        &self,
        state: &mut GuardState<F, D>,
        actuator: &SVector<F, D>,
    ) {
        const OWED_MOST: f64 = 1000.0;
        for _ in 0..D {
            state.owed += self.noise;
        }
        let most = F::from_f64(OWED_MOST) * self.noise;
        if state.owed > most {
            state.owed = most;
        }
        let force = state.sent[0].force;
        let [square, along, rest] = self.profile.command(&force, actuator);
        let back = self.step * dot(&force, &force);
        let spare =
            state.energy() - (square + along + rest + back + self.profile.on_its_way(&state.sent));
        if spare > F::ZERO {
            let paid = if spare < state.owed {
                spare
            } else {
                state.owed
            };
            state.owed -= paid;
            state.spend(paid);
        }
    }
}

/// The largest s in [0, 1] with s²·`square` + s·`along` ≤ `spare`, in the form that does not cancel; 0 for NaN.
#[inline]
fn scale<F: Real>(square: F, along: F, spare: F) -> F {
    let four = F::from_f64(4.0);
    let root = (along * along + four * square * spare).sqrt();
    let scale = if along > F::ZERO {
        (spare + spare) / (along + root)
    } else {
        (root - along) / (square + square)
    };
    if !(spare > F::ZERO && scale > F::ZERO && scale.is_finite()) {
        F::ZERO
    } else if scale > F::ONE {
        // By rounding alone.
        F::ONE
    } else {
        scale
    }
}

#[cfg(test)]
mod tests {
    use super::scale;

    #[test]
    fn a_small_share_keeps_its_digits() {
        // s² + s = 1e-6, with 1e-6 less than a digit of 1.
        assert!((scale(1.0_f32, 1.0, 1e-6) / 1e-6 - 1.0).abs() < 2e-6);
        // s² − s = 1e-8 is above 1, s² − 2s = −0.75 at neither: no energy to spare.
        assert!((scale(1.0_f32, -1.0, 1e-8) - 1.0).abs() < 1e-6);
        assert!(scale(1.0_f32, -2.0, -0.75).abs() <= 0.0);
    }

    #[test]
    fn forces_whose_products_overflow_let_nothing_through() {
        for along in [f32::NEG_INFINITY, f32::NAN, -1e30] {
            let through = scale(1.0_f32, along, 1.0);
            assert!(through.abs() <= 0.0, "{along}: {through}");
        }
        // A good one: s² + s = 2 at s = 1, half of it with less to spare.
        assert!((scale(1.0_f32, 1.0, 2.0) - 1.0).abs() < 1e-6);
        assert!((scale(1.0_f32, 1.0, 0.75) - 0.5).abs() < 1e-6);
    }
}
