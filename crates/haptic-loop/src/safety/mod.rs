//! The safety chain: the only way for a force to become a [`SafeForce`].
//!
//! ```text
//! wanted ─▶ finite? ─▶ passivity observer ─▶ start-up ramp ─▶ braking near limits of motion
//!        ─▶ magnitude per axis and by norm (N) ∩ rate of the whole force (N/s) ─▶ envelope of a stop ─▶ energy bounding ─▶ SafeForce
//! ```
//! - *Finite check first*: a NaN passed through `max` and `min` would come out as the full force. A
//!   wanted force that is not finite latches a [`Fault`]; from then on the chain wants zero, until
//!   [`SafetyState::clear`].
//! - *Clamps late*: magnitude and rate hold for everything before them, start-up and braking too.
//! - *Energy bounding last*: it only scales a force down, so magnitude, norm and envelope hold after it. The rate limit
//!   holds back a force that grows, not one that this guard takes away: zero must always be possible.
//! - *After a fault or stop* braking −b·v is wanted, which fades out with the envelope. None after a position that
//!   is not finite, stands still or jumps, nor after [`Fault::CurrentMismatch`]: a damper needs its sensor and its
//!   actuator.
//! - *Start-up*: zero force. *Cost*: some twenty operations per axis with everything on, a few comparisons
//!   without; at most two square roots and three divisions; no allocation, no panic.

pub(crate) mod clamps;
mod force;
mod limits;
mod motion;

pub use force::{Fault, Limiters, SafeForce};
pub use limits::{Limit, SafetyLimits, SpeedLimit, StartRefused, Stuck, Tighter, Workspace};

use crate::error::{Checks, LoopParameterError};
use crate::guard::{GuardLaw, GuardState};
use crate::units::{Newtons, NewtonsPerSecond, Seconds};
use clamps::{Clamps, Release, Released};
use fracdiff::Real;
use motion::{Motion, MotionWatch};
use nalgebra::SVector;

/// The chain's immutable part.
///
/// ```
/// use fracdiff::Seconds;
/// use haptic_loop::units::{Newtons, NewtonsPerSecond};
/// use haptic_loop::{Fault, Limiters, SafetyChain, SafetyState};
/// use nalgebra::vector;
///
/// let chain = SafetyChain::new(Newtons(10.0), NewtonsPerSecond(1000.0), Seconds(1e-3))?;
/// let mut state = SafetyState::default();
/// // 50 N are wanted at once: 1 N a millisecond, and no more than 10 N.
/// let (force, limiters) = chain.apply(&mut state, &vector![0.0], &vector![50.0]);
/// assert_eq!(*force.newtons(), vector![1.0]);
/// assert!(limiters.contains(Limiters::RATE));
/// // What is not finite latches a fault, and the force falls to zero.
/// chain.apply(&mut state, &vector![0.0], &vector![f64::NAN]);
/// assert_eq!(state.fault(), Some(Fault::NonFiniteForce));
/// # Ok::<(), haptic_loop::LoopParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafetyChain<F> {
    clamps: Clamps<F>,
    /// N; infinite if any finite force may start.
    start_force: f64,
    /// Share of the force that is added in a sample after the start.
    rise: Option<F>,
    /// If anything here depends on the position.
    motion: Option<MotionWatch<F>>,
    guard: Option<GuardLaw<F>>,
    release: Release<F>,
}

/// The chain's state: the last force, the latched fault, a wish to stop, the motion and its energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafetyState<F, const D: usize> {
    force: SVector<F, D>,
    fault: Option<Fault>,
    stopping: bool,
    /// Since the first tick after a fault or stop.
    released: Option<Released<F>>,
    /// Share of the wanted force that is used, 0 to 1.
    risen: F,
    motion: Motion<F, D>,
    guard: GuardState<F, D>,
}

impl<F: Real, const D: usize> Default for SafetyState<F, D> {
    fn default() -> Self {
        Self {
            force: SVector::from([F::ZERO; D]),
            fault: None,
            stopping: false,
            released: None,
            risen: F::ZERO,
            motion: Motion::at_rest(),
            guard: GuardState::at_rest(),
        }
    }
}

impl<F: Real, const D: usize> SafetyState<F, D> {
    /// The fault that is latched, until it is cleared.
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// Latches a fault that something else has found. The first fault stays.
    pub fn trip(&mut self, fault: Fault) {
        if self.fault.is_none() && !fault.leaves_braking() {
            // No braking with an actuator that does not obey.
            self.motion.brakes = false;
        }
        self.fault.get_or_insert(fault);
    }

    /// Reports that the device has let go on its own: the force is zero now.
    pub fn let_go(&mut self) {
        self.force = SVector::from([F::ZERO; D]);
        self.guard.let_go();
    }

    /// Makes the wanted force zero from the next tick, until [`clear`](Self::clear).
    pub fn stop(&mut self) {
        self.stopping = true;
    }

    pub(crate) const fn is_released(&self) -> bool {
        self.fault.is_some() || self.stopping
    }

    /// The force of the last tick, N.
    pub(crate) const fn force(&self) -> &SVector<F, D> {
        &self.force
    }

    /// True if the force has reached zero on every axis.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.force.iter().all(|&axis| axis == F::ZERO)
    }

    /// The next tick comes after `ticks` missed ones: the way to zero advances by them, and a position may have
    /// moved further.
    #[inline(never)]
    pub fn skip(&mut self, ticks: u64) {
        // More than 2³² make no difference.
        let ticks = F::from_f64(f64::from(u32::try_from(ticks).unwrap_or(u32::MAX)));
        self.motion.skip(ticks);
        if let Some(released) = &mut self.released {
            released.skip(ticks);
        }
    }

    /// The position of the next tick is the first that is measured after `ticks` ticks without one: it may have moved
    /// further.
    #[inline(never)]
    pub fn unmeasured(&mut self, ticks: u32) {
        self.motion.skip(F::from_f64(f64::from(ticks)));
    }

    /// Clears the fault and the wish to stop. The force continues from its present value, and rises as after a
    /// start. At rest, where the device was is forgotten too, so that it may have been moved meanwhile; of the
    /// guard's energy a debt stays.
    pub fn clear(&mut self) {
        self.fault = None;
        self.stopping = false;
        self.released = None;
        self.risen = F::ZERO;
        self.motion.brakes = true;
        if self.is_at_rest() {
            self.motion = Motion::at_rest();
            self.guard.forget_credit();
        }
    }

    /// The energy that the guard has observed, J: positive if the device gave it to the loop; 0 without a
    /// guard.
    #[must_use]
    pub fn observed_energy_j(&self) -> F {
        self.guard.energy()
    }

    /// The estimated velocity, m/s; 0 if no limit needs it.
    #[must_use]
    pub fn velocity_m_per_s(&self) -> &SVector<F, D> {
        &self.motion.velocity
    }
}

impl<F: Real> SafetyChain<F> {
    /// A chain for the largest force per axis, the largest rate of the whole force, and the sample time, everything else off:
    /// [`SafetyLimits::bare`].
    ///
    /// # Errors
    /// Each must be finite and above zero, in the precision of the loop too.
    pub fn new(
        force: Newtons,
        rate: NewtonsPerSecond,
        sample_time: Seconds,
    ) -> Result<Self, LoopParameterError> {
        Self::from_limits(&SafetyLimits::bare(force, rate), sample_time)
    }

    /// A chain with these limits.
    ///
    /// # Errors
    /// A limit outside the range that its field states, or that of the loop's number type; a sample time
    /// that is not above zero.
    pub fn from_limits(
        limits: &SafetyLimits,
        sample_time: Seconds,
    ) -> Result<Self, LoopParameterError> {
        let mut checks = Checks::default();
        let chain = Self::checked(limits, sample_time, &mut checks);
        checks.done().map(|()| chain)
    }

    fn checked(limits: &SafetyLimits, sample_time: Seconds, checks: &mut Checks) -> Self {
        let sample_time = checks.positive("sample time", sample_time.0, "s");
        let clamps = Clamps::new(limits, sample_time, checks);
        let start_force = limits.start_force.map_or(f64::INFINITY, |force| {
            checks.positive("start force", force.0, "N")
        });
        let rise = limits.rise_time.map(|time| {
            let share = sample_time / checks.positive("rise time", time.0, "s");
            checks.rounded("rise per sample", f64::min(share, 1.0), "")
        });
        let guard = limits.guard.as_ref();
        let follows = limits.bound_places() || guard.is_some() || Limit::any_needs_motion(limits);
        Self {
            clamps,
            start_force,
            rise,
            motion: follows.then(|| MotionWatch::new(limits, sample_time, checks)),
            release: Release::new(limits, sample_time, checks),
            guard: guard.map(|guard| GuardLaw::new(guard, sample_time, checks)),
        }
    }

    /// True if the chain has a passivity guard.
    #[must_use]
    pub const fn has_guard(&self) -> bool {
        self.guard.is_some()
    }

    /// Checks that a device may be armed with this wanted force, N.
    ///
    /// # Errors
    /// It is not finite, or its magnitude is above [`SafetyLimits::start_force`].
    pub fn may_start<const D: usize>(&self, wanted: &SVector<F, D>) -> Result<(), StartRefused> {
        let squares = wanted.iter().map(|axis| axis.to_f64() * axis.to_f64());
        let wanted_n = libm::sqrt(squares.sum());
        if wanted_n.is_finite() && wanted_n <= self.start_force {
            Ok(())
        } else {
            Err(StartRefused {
                wanted_n,
                allowed_n: self.start_force,
            })
        }
    }

    /// Checks a position between two ticks, m: see [`Controller::strays`](crate::Controller::strays).
    pub(crate) fn strays<const D: usize>(
        &self,
        state: &SafetyState<F, D>,
        position_m: &SVector<F, D>,
    ) -> Result<(), Fault> {
        let strays = |limits: &MotionWatch<F>| limits.strays(&state.motion, position_m);
        self.motion.as_ref().map_or(Ok(()), strays)
    }

    /// Makes the force wanted at a position (m) safe, and says which limiters acted.
    #[inline]
    pub fn apply<const D: usize>(
        &self,
        state: &mut SafetyState<F, D>,
        position_m: &SVector<F, D>,
        wanted: &SVector<F, D>,
    ) -> (SafeForce<F, D>, Limiters) {
        if !is_finite(wanted) {
            state.trip(Fault::NonFiniteForce);
        }
        if let Some(limits) = &self.motion {
            if is_finite(position_m) {
                let followed = limits.follow(&mut state.motion, position_m);
                let within = followed.and_then(|()| limits.breach(&state.motion, position_m));
                state.motion.in_time();
                if let Err(fault) = within {
                    state.trip(fault);
                }
                let most = self.clamps.magnitude;
                if !state.is_released()
                    && limits.stands_still(&mut state.motion, wanted, &state.force, most)
                {
                    state.trip(Fault::PositionStuck);
                }
            } else {
                state.motion.lose();
                state.trip(Fault::NonFiniteForce);
            }
        }
        let mut limiters = Limiters::NONE;
        let mut released = state.is_released();
        let mut aim = if released {
            if state.fault.is_some() {
                limiters.insert(Limiters::FAULT);
            }
            if state.stopping {
                limiters.insert(Limiters::STOPPING);
            }
            self.released(state)
        } else {
            self.restrained(state, position_m, wanted, &mut limiters)
        };
        if !is_finite(&aim) {
            // A sum of finite forces beyond the number type.
            state.trip(Fault::NonFiniteForce);
            limiters.insert(Limiters::FAULT);
            aim = SVector::from([F::ZERO; D]);
            released = true;
        }
        let before = state.force;
        self.clamps.apply(&mut state.force, &aim, &mut limiters);
        if released {
            self.release
                .hold(&mut state.released, &before, &mut state.force);
        }
        if let Some(guard) = &self.guard {
            let moved = state.motion.known.then_some(&state.motion.moved);
            if guard.settle(&mut state.guard, moved, &mut state.force) {
                limiters.insert(Limiters::GUARD);
            }
        }
        (SafeForce(state.force), limiters)
    }

    /// The force wanted after a fault or stop. A function of its own: the way to zero is never in a hurry.
    #[inline(never)]
    fn released<const D: usize>(&self, state: &mut SafetyState<F, D>) -> SVector<F, D> {
        let none = SVector::from([F::ZERO; D]);
        if let Some(guard) = &self.guard {
            // The guard's energy account continues.
            guard.steer(&mut state.guard, &state.motion.moved, &none);
        }
        match &self.motion {
            Some(limits) => {
                let left = self.release.left(state.released.as_ref());
                limits.fading(&state.motion, left)
            }
            None => none,
        }
    }

    /// The rest of the wanted force, with the braking near limits.
    #[inline]
    fn restrained<const D: usize>(
        &self,
        state: &mut SafetyState<F, D>,
        position_m: &SVector<F, D>,
        wanted: &SVector<F, D>,
        limiters: &mut Limiters,
    ) -> SVector<F, D> {
        let mut aim = *wanted;
        if let Some(guard) = &self.guard {
            let (restrained, acted) = guard.steer(&mut state.guard, &state.motion.moved, &aim);
            aim = restrained;
            if acted {
                limiters.insert(Limiters::GUARD);
            }
        }
        if let Some(rise) = self.rise
            && state.risen < F::ONE
        {
            limiters.insert(Limiters::STARTUP);
            for axis in &mut aim {
                *axis = *axis * state.risen;
            }
            state.risen += rise;
        }
        if let Some(limits) = &self.motion {
            limiters.insert(limits.brake(&state.motion, position_m, &mut aim));
        }
        aim
    }
}

#[inline]
fn is_finite<F: Real, const D: usize>(vector: &SVector<F, D>) -> bool {
    vector.iter().all(|axis| axis.is_finite())
}
