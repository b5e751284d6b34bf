//! The passivity guard: keeps a sampled wall from feeding energy into the device that holds it.
//!
//! A force held over a sample does known work, so the energy that the device has given to the loop is
//! known exactly at each sample, from nothing but positions and the forces that were sent:
//!
//! ```text
//! W\[n\] = W\[n−1\] − f\[n−1−d\]·Δ\[n\]        Δ\[n\] = x\[n\] − x\[n−1\], m;   d samples of delay;   W J
//! ```
//! A loop is passive if W stays above a constant. Both guards keep books of this kind, of the force that
//! *was sent*, after all limits: what a guard or limiter takes away is in the books one tick later.
//!
//! - [`EnergyBounding`] knows the viscous damping b of the device and promises: no motion whatever can
//!   make the sampled loop and that damping together give energy. It makes the force smaller.
//! - [`PassivityObserver`] knows nothing and promises less: it adds damping while more energy has come out
//!   than went in. It leaves the stiffness at rest as it is, and cannot hold what damping cannot hold.
//!
//! *Start-up*: no energy. *Cost*: per axis four multiply-adds; while it acts, one division and one square
//! root or none. *Precision*: all in the loop's number type.

use crate::error::{ParameterError, not_negative, positive, range, rounded};
use crate::units::{Kilograms, NewtonSecondsPerMetre, Seconds};
use core::array;
use fracdiff::Real;
use nalgebra::SVector;

/// Most samples between a write and its force that [`EnergyBounding`] can keep books of.
pub const MAX_GUARD_DELAY_SAMPLES: usize = 4;

/// A choice of guard, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Guard {
    /// Adds damping.
    Observer(PassivityObserver),
    /// Bounds the force.
    EnergyBounding(EnergyBounding),
}

/// Time-domain passivity observer and controller.
///
/// ```text
/// E\[n\] = E\[n−1\] − f\[n−1\]·Δ\[n\],    then E ← E·(1 − T/τ) if E > 0          forgotten: only what was dissipated
/// g = f_wanted·Δ\[n\] − E\[n\]                                          what the next sample would owe
/// f = f_wanted − b_c·Δ\[n\]/T,    b_c = 0 if g ≤ 0,  else min(b_max, g·T/|Δ|²)
/// ```
/// - *Prediction*: the next sample moves as the last did.
/// - *No small divisor*: the quotient is formed only where it is below `b_max`.
/// - *Forgetting* shrinks a credit, never a debt, so it makes the guard stricter: what a held spring has
///   stored is forgotten too after some τ, and its release is damped.
/// - *Limit*: damping holds no wall beyond α = KT²/m of about 0.8 and none with a sample of delay.
///
/// Source: B. Hannaford, J.-H. Ryu, *Time-domain passivity control of haptic interfaces*, IEEE Trans. Robotics
/// and Automation 18(1), 2002, in the impedance form; cap, forgetting and exact work are ours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassivityObserver {
    /// `b_max` > 0, the most damping that the device bears: see [`bearable`](Self::bearable).
    pub damping_max: NewtonSecondsPerMetre,
    /// τ, at least a sample time: how long a credit of energy lasts.
    pub forget: Seconds,
}

impl PassivityObserver {
    /// m/(2T), and half a second of credit.
    ///
    /// A sampled damper −B·Δ/T on a mass m is stable for β = B·T/m below 2, and with a spring beside it for
    /// α < 2β(2 − β)/(2 + β). β = 1/2 keeps a margin of four alone and bears a spring of α = 0.6; no β bears more
    /// than 0.69.
    #[must_use]
    pub fn bearable(mass: Kilograms, sample_time: Seconds) -> Self {
        Self {
            damping_max: NewtonSecondsPerMetre(mass.0 / (2.0 * sample_time.0)),
            forget: Seconds(0.5),
        }
    }
}

/// Energy bounding: the force is never larger than the energy at hand can pay for.
///
/// ```text
/// E\[n\] = E\[n−1\] − f\[n−1−d\]·Δ\[n\] + ρ(b/T)·|Δ\[n\]|²
/// |f\[n\]|² ≤ 2c·E\[n\] − Σ_{j=1..d} |f\[n−j\]|²,      c = 2ρb/T,   0 < ρ ≤ 1
/// S = Σ_{j=0..d} |f\[n−j\]|²/(2c),     E ← S + (E − S)·(1 − T/τ)             forgotten: only the surplus
/// ```
/// - *Why it is passive*: over a sample the damping of the device takes ∫b·v² ≥ (b/T)·|Δ|². Whatever Δ is,
///   −f·Δ + ρ(b/T)|Δ|² ≥ −|f|²/(2c); so the energy that each force on its way may still cost is |f|²/(2c),
///   the rule keeps all of it covered, and E ≥ 0 for ever. A surplus that is forgotten is a licence given up.
/// - *Why it comes to rest*: for ρ < 1 the rest of the damping, (1 − ρ)b, takes energy from any motion.
/// - *Price*: a spring is no stiffer than c, and c/(d + 1) with delay; for b = 3.5 N·s/m, T = 2 ms and ρ = 0.8 that is
///   2800 N/m of the 3500 at which a spring stops being passive. A passive wall below that is left as it is.
/// - *Surplus*: what a spring softer than c has stored beyond S counts as such. With τ = 0 it is given up at once,
///   and even a soft spring comes back up to a quarter too weak; τ longer than a touch avoids that.
/// - *Needs* b: said 1.25 times too large it uses up ρ = 0.8, beyond that walls shake again. Needs d: round a
///   delay up. A rate limit that keeps a force up makes E negative for a while; no force returns before it is paid.
///
/// With τ = 0 and d = 0 the rule reads |f\[n\]| ≤ |f\[n−1\] − c·Δ\[n\]|.
///
/// Source: J.-P. Kim, J. Ryu, *Robustly stable haptic interaction control using an energy-bounding algorithm*,
/// Int. J. Robotics Research 29(6), 2010, for the idea (the hold's energy bounded by what the device's damping
/// takes); this form, with delay, surplus and several axes, is derived here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyBounding {
    /// b > 0, N·s/m: viscous damping that the device surely has, on each axis.
    pub device_damping: NewtonSecondsPerMetre,
    /// ρ in (0, 1\]: the share of it that the loop may use up.
    pub share: f64,
    /// τ, 0 or at least a sample time: how long a surplus lasts. At 0 it is given up at once.
    pub forget: Seconds,
    /// d, whole samples from a write to its force, at most [`MAX_GUARD_DELAY_SAMPLES`].
    pub delay_samples: usize,
}

impl EnergyBounding {
    /// ρ = 0.8, a surplus for half a second, no delay.
    #[must_use]
    pub const fn of(device_damping: NewtonSecondsPerMetre) -> Self {
        Self {
            device_damping,
            share: 0.8,
            forget: Seconds(0.5),
            delay_samples: 0,
        }
    }
}

/// A guard made of good parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum GuardLaw<F> {
    /// [`PassivityObserver`].
    Observer {
        /// The most damping, over T: N/m.
        damping_max: F,
        /// 1 − T/τ.
        keep: F,
    },
    /// [`EnergyBounding`].
    Bounding {
        /// ρb/T, N/m.
        damping: F,
        /// 2c, N/m.
        per_energy: F,
        /// 1/(2c), m/N.
        per_square: F,
        /// 1 − T/τ.
        keep: F,
        /// d.
        delay: usize,
    },
}

/// Energy and the forces on their way, newest first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GuardState<F, const D: usize> {
    energy: F,
    sent: [SVector<F, D>; MAX_GUARD_DELAY_SAMPLES + 1],
}

impl<F: Real, const D: usize> GuardState<F, D> {
    pub(crate) fn at_rest() -> Self {
        Self {
            energy: F::ZERO,
            sent: [SVector::from([F::ZERO; D]); MAX_GUARD_DELAY_SAMPLES + 1],
        }
    }

    /// E, J.
    pub(crate) const fn energy(&self) -> F {
        self.energy
    }

    /// E ← min(0, E).
    pub(crate) fn forget_credit(&mut self) {
        if self.energy > F::ZERO {
            self.energy = F::ZERO;
        }
    }

    /// Keeps the force that goes to the device.
    #[inline]
    pub(crate) fn sent(&mut self, law: &GuardLaw<F>, force: &SVector<F, D>) {
        for age in (0..law.delay()).rev() {
            self.sent[age + 1] = self.sent[age];
        }
        self.sent[0] = *force;
    }

    /// E ← E − f\[n−1−d\]·Δ + damping·|Δ|². What is not finite is no credit.
    #[inline]
    fn observe(&mut self, delay: usize, damping: F, moved: &SVector<F, D>) {
        let mut work = F::ZERO;
        for (&force, &moved) in self.sent[delay].iter().zip(moved) {
            work += (damping * moved - force) * moved;
        }
        let energy = self.energy + work;
        self.energy = if energy.is_finite() { energy } else { F::ZERO };
    }
}

impl<F: Real> GuardLaw<F> {
    /// # Errors
    /// A parameter outside the range that its field states.
    pub(crate) fn new(guard: &Guard, sample_time: f64) -> Result<Self, ParameterError> {
        match *guard {
            Guard::Observer(PassivityObserver {
                damping_max,
                forget,
            }) => {
                let damping = positive("most damping of the guard", damping_max.0, "N·s/m")?;
                positive("time in which the guard forgets", forget.0, "s")?;
                Ok(Self::Observer {
                    damping_max: rounded(
                        "most damping of the guard",
                        damping / sample_time,
                        "N/m",
                    )?,
                    keep: keep(forget, sample_time)?,
                })
            }
            Guard::EnergyBounding(EnergyBounding {
                device_damping,
                share,
                forget,
                delay_samples,
            }) => {
                let damping = positive("damping of the device", device_damping.0, "N·s/m")?;
                let within = share > 0.0 && share <= 1.0;
                range("share of the damping", share, within, "in (0, 1]", "")?;
                let delay = delay_samples as f64;
                let kept = delay_samples <= MAX_GUARD_DELAY_SAMPLES;
                range("delay of the guard", delay, kept, "at most 4", "samples")?;
                let damping = share * damping / sample_time;
                let name = "bound of the guard";
                Ok(Self::Bounding {
                    damping: rounded(name, damping, "N/m")?,
                    per_energy: rounded(name, 4.0 * damping, "N/m")?,
                    per_square: rounded(name, 0.25 / damping, "m/N")?,
                    keep: keep(forget, sample_time)?,
                    delay: delay_samples,
                })
            }
        }
    }

    const fn delay(&self) -> usize {
        match self {
            Self::Observer { .. } => 0,
            Self::Bounding { delay, .. } => *delay,
        }
    }

    /// The force that may be sent, and whether it is another than the wanted one. `moved` is Δ, m.
    #[inline]
    pub(crate) fn restrain<const D: usize>(
        &self,
        state: &mut GuardState<F, D>,
        moved: &SVector<F, D>,
        wanted: &SVector<F, D>,
    ) -> (SVector<F, D>, bool) {
        match *self {
            Self::Observer { damping_max, keep } => {
                state.observe(0, F::ZERO, moved);
                if state.energy > F::ZERO {
                    state.energy = state.energy * keep;
                }
                // g = f·Δ − E
                let owed = dot(wanted, moved) - state.energy;
                let square = dot(moved, moved);
                if owed.is_finite() && owed <= F::ZERO {
                    return (*wanted, false);
                }
                let damping = if owed < damping_max * square {
                    owed / square
                } else {
                    damping_max
                };
                let pairs = |axis| wanted[axis] - damping * moved[axis];
                (SVector::from(array::from_fn(pairs)), square > F::ZERO)
            }
            Self::Bounding {
                damping,
                per_energy,
                per_square,
                keep,
                delay,
            } => {
                state.observe(delay, damping, moved);
                let mut pledged = F::ZERO;
                for sent in &state.sent[..delay] {
                    pledged += dot(sent, sent);
                }
                // 2c·E − Σ|f|²
                let free = per_energy * state.energy - pledged;
                let square = dot(wanted, wanted);
                if square <= free {
                    let pledged = per_square * (pledged + square);
                    state.energy = pledged + keep * (state.energy - pledged);
                    return (*wanted, false);
                }
                // No surplus: nothing to forget.
                let scale = if free > F::ZERO {
                    (free / square).sqrt()
                } else {
                    F::ZERO
                };
                (wanted.map(|axis| axis * scale), square > F::ZERO)
            }
        }
    }
}

/// 1 − T/τ; 0 for τ = 0.
fn keep<F: Real>(forget: Seconds, sample_time: f64) -> Result<F, ParameterError> {
    let what = "time in which the guard forgets";
    not_negative(what, forget.0, "s")?;
    if forget.0 <= 0.0 {
        return Ok(F::ZERO);
    }
    let whole = forget.0 >= sample_time;
    range(
        what,
        forget.0,
        whole,
        "0 or at least the sample time, in",
        "s",
    )?;
    Ok(F::from_f64(1.0 - sample_time / forget.0))
}

#[inline]
fn dot<F: Real, const D: usize>(left: &SVector<F, D>, right: &SVector<F, D>) -> F {
    let mut sum = F::ZERO;
    for (&left, &right) in left.iter().zip(right) {
        sum += left * right;
    }
    sum
}
