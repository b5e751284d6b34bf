//! The controller: an environment behind a safety chain. It runs on a device as [`Engaged`](crate::Engaged), and in no other
//! way.

use crate::device::Reading;
use crate::environment::Environment;
use crate::safety::{Fault, Limiters, SafeForce, SafetyChain, SafetyState, StartRefused};
use fracdiff::Real;
use nalgebra::SVector;

/// The readings and forces of one tick, for a recorder.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LoopSample<F, const D: usize> {
    /// Tick, time and position as the device reported them.
    pub reading: Reading<F, D>,
    /// The force that the environment wanted, N.
    pub environment_force_n: SVector<F, D>,
    /// The force that was sent to the device, N.
    pub force: SafeForce<F, D>,
    /// The limiters of the safety chain that acted on it.
    pub limiters: Limiters,
    /// The energy that its passivity guard observed, J: see [`SafetyState::observed_energy_j`].
    pub observed_energy_j: F,
    /// The latched fault, present from the tick that detected it.
    pub fault: Option<Fault>,
}

impl<F: Real, const D: usize> LoopSample<F, D> {
    /// Applies a chain to the force wanted at a reading, N.
    #[inline]
    pub fn of(
        chain: &SafetyChain<F>,
        safety: &mut SafetyState<F, D>,
        reading: Reading<F, D>,
        wanted: &SVector<F, D>,
    ) -> Self {
        let (force, limiters) = chain.apply(safety, &reading.position_m, wanted);
        Self {
            reading,
            environment_force_n: *wanted,
            force,
            limiters,
            observed_energy_j: safety.observed_energy_j(),
            fault: safety.fault(),
        }
    }
}

/// An environment behind a safety chain, with the state of both.
///
/// *Start-up*: history at rest, force zero.
#[derive(Clone, Debug)]
pub struct Controller<F: Real, const D: usize, E: Environment<F, D>> {
    environment: E,
    chain: SafetyChain<F>,
    history: E::History,
    safety: SafetyState<F, D>,
    /// Number of the tick that comes next, if none is missing.
    next: u64,
}

impl<F: Real, const D: usize, E: Environment<F, D>> Controller<F, D, E> {
    /// A controller at rest: no history, no force.
    pub fn new(environment: E, chain: SafetyChain<F>) -> Self {
        let history = environment.at_rest();
        Self {
            environment,
            chain,
            history,
            safety: SafetyState::default(),
            next: 0,
        }
    }

    /// Changes the environment in place, as a stack may have no room for a second one, takes another
    /// chain, and starts again at rest.
    pub fn replace_within(&mut self, chain: SafetyChain<F>, change: impl FnOnce(&mut E)) {
        change(&mut self.environment);
        self.environment.rest(&mut self.history);
        self.chain = chain;
        self.safety = SafetyState::default();
    }

    /// Tells the safety chain of ticks that did not come.
    #[inline]
    fn follow(&mut self, tick: u64) {
        // The first tick of a run has any number.
        if tick > self.next && self.next > 0 {
            self.safety.skip(tick - self.next);
        }
        self.next = tick.wrapping_add(1);
    }

    /// The force of a tick, of the environment or commanded.
    #[inline]
    pub(crate) fn force(
        &mut self,
        reading: Reading<F, D>,
        commanded: Option<&SVector<F, D>>,
    ) -> (LoopSample<F, D>, SVector<F, D>) {
        self.follow(reading.tick);
        let (wanted, input) = match commanded {
            Some(wanted) => (*wanted, reading.position_m),
            None => (self.environment).force_and_input(&self.history, &reading.position_m),
        };
        (
            LoopSample::of(&self.chain, &mut self.safety, reading, &wanted),
            input,
        )
    }

    /// The rest of a tick of the environment: its history takes in the input and the applied force.
    #[inline]
    pub(crate) fn advance(&mut self, input: &SVector<F, D>, sample: &LoopSample<F, D>) {
        let applied = sample.force.newtons();
        (self.environment).advance_applied(&mut self.history, input, applied);
    }

    /// The environment takes in missed ticks, evenly on the line from the last position, m, to this reading.
    #[inline(never)]
    pub(crate) fn pass(&mut self, ticks: u32, last_m: &SVector<F, D>, reading: &Reading<F, D>) {
        let held = *self.safety.force();
        for tick in 1..=ticks {
            let share = F::from_f64(f64::from(tick) / (f64::from(ticks) + 1.0));
            let on_line = |axis| last_m[axis] + (reading.position_m[axis] - last_m[axis]) * share;
            let position_m = SVector::from_fn(|axis, _| on_line(axis));
            let (_, input) = (self.environment).force_and_input(&self.history, &position_m);
            (self.environment).advance_applied(&mut self.history, &input, &held);
        }
    }

    /// Starts at this reading, after a [`reset`](Self::reset): see [`Environment::settle`].
    pub fn settle(&mut self, reading: &Reading<F, D>) {
        (self.environment).settle(&mut self.history, &reading.position_m);
    }

    /// Checks whether the device may be armed at this position: the arming code asks before the
    /// first tick, and again before it clears a fault. Changes nothing.
    ///
    /// # Errors
    /// The force wanted at this reading is not finite, or above [`SafetyLimits::start_force`](crate::SafetyLimits::start_force).
    pub fn may_start(&self, reading: &Reading<F, D>) -> Result<(), StartRefused> {
        let wanted = self
            .environment
            .starting_force(&self.history, &reading.position_m);
        self.chain.may_start(&wanted)
    }

    /// The safety chain's state: its fault, if any.
    pub const fn safety(&self) -> &SafetyState<F, D> {
        &self.safety
    }

    /// The energy that the passivity guard has observed, J; `None` without a guard.
    pub fn guarded_energy_j(&self) -> Option<F> {
        self.chain
            .has_guard()
            .then(|| self.safety.observed_energy_j())
    }

    /// Checks a position between two ticks, m, by the limits that need no velocity: workspace and jump. Changes nothing.
    ///
    /// # Errors
    /// The fault that the next tick would find here.
    pub fn strays(&self, position_m: &SVector<F, D>) -> Result<(), Fault> {
        self.chain.strays(&self.safety, position_m)
    }

    /// Latches a fault detected elsewhere: the force falls to zero within
    /// [`SafetyLimits::stop_time`](crate::SafetyLimits::stop_time).
    pub fn trip(&mut self, fault: Fault) {
        self.safety.trip(fault);
    }

    /// The device has let go, so the force is zero now, whatever the rate limit.
    pub(crate) fn let_go(&mut self) {
        self.safety.let_go();
    }

    /// Reports that this many ticks were skipped before the next one and are missing from its
    /// number: see [`SafetyState::skip`].
    pub fn skip(&mut self, ticks: u64) {
        self.safety.skip(ticks);
    }

    /// Reports that this many ticks without a position precede the next one: see
    /// [`SafetyState::unmeasured`].
    pub fn unmeasured(&mut self, ticks: u32) {
        self.safety.unmeasured(ticks);
    }

    /// Lets the force fall to zero from the next tick on, within [`SafetyLimits::stop_time`](crate::SafetyLimits::stop_time).
    pub fn stop(&mut self) {
        self.safety.stop();
    }

    /// Forgets the past, clears a fault and a stop; the force continues from its present value, at the rate
    /// limit.
    pub fn reset(&mut self) {
        self.environment.rest(&mut self.history);
        self.clear();
    }

    /// Clears a fault and a stop as [`reset`](Self::reset) does, but the environment remembers.
    pub fn clear(&mut self) {
        self.next = 0;
        self.safety.clear();
    }

    /// The law that it renders.
    pub const fn environment(&self) -> &E {
        &self.environment
    }

    /// The environment and its memory, to change the law while the loop runs.
    ///
    /// The safety chain continues: the force moves to the new law's force at the rate limit. A
    /// history of other positions makes the wanted force jump; a history of another environment
    /// makes it wrong.
    pub const fn law_mut(&mut self) -> (&mut E, &mut E::History) {
        (&mut self.environment, &mut self.history)
    }
}
