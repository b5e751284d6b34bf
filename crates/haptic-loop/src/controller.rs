//! The controller tick: the one function that every loop runs, on the host, in simulation and in
//! firmware.
//!
//! ```text
//! device.read ─▶ environment.force ─▶ safety chain ─SafeForce─▶ device.write ─▶ environment.advance
//! ```
//! Sensor to force first, everything else after.

use crate::device::{Device, Reading};
use crate::engaged::Engaged;
use crate::environment::Environment;
use crate::safety::{Fault, Limiters, SafeForce, SafetyChain, SafetyState, StartRefused};
use fracdiff::Real;
use nalgebra::SVector;

/// What one tick read and did: what a recorder keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<F, const D: usize> {
    /// Tick, time and position.
    pub reading: Reading<F, D>,
    /// What the environment wanted, N.
    pub environment_force_n: SVector<F, D>,
    /// What was sent to the device, N.
    pub force: SafeForce<F, D>,
    /// What the safety chain did about it.
    pub limiters: Limiters,
    /// What its passivity guard observed, J: see [`SafetyState::observed_energy_j`].
    pub observed_energy_j: F,
}

/// An environment behind a safety chain, with the state of both.
///
/// *Start-up*: history at rest, force zero. *Cost* of a tick: the device's read and write, the
/// environment's force and advance, a few comparisons; no allocation, lock, formatting or panic.
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
    /// At rest.
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

    /// Takes another environment and chain, and is at rest as if it were new.
    pub fn replace(&mut self, environment: E, chain: SafetyChain<F>) {
        self.history = environment.at_rest();
        self.environment = environment;
        self.chain = chain;
        self.safety = SafetyState::default();
    }

    /// Tells the safety chain of ticks that did not come.
    #[inline]
    fn follow(&mut self, tick: u64) {
        let missed = tick.saturating_sub(self.next);
        // The first tick of a run has any number.
        if missed > 0 && self.next > 0 {
            self.safety.skip(missed);
        }
        self.next = tick.wrapping_add(1);
    }

    /// Closes the loop with a device until the value is dropped, which leaves no force behind.
    pub const fn engage<'a, V: Device<F, D>>(
        &'a mut self,
        device: &'a mut V,
    ) -> Engaged<'a, F, D, E, V> {
        Engaged::new(self, device)
    }

    /// One tick.
    ///
    /// # Errors
    /// The device's own. A failed read leaves everything as it was; after a failed write the
    /// position still enters the history, and the error is returned.
    #[inline]
    pub fn tick<V: Device<F, D>>(&mut self, device: &mut V) -> Result<Sample<F, D>, V::Error> {
        let reading = device.read()?;
        self.tick_reading(device, reading)
    }

    /// The rest of a tick, for a reading that is there already.
    ///
    /// # Errors
    /// As [`tick`](Self::tick), of the write.
    #[inline]
    pub fn tick_reading<V: Device<F, D>>(
        &mut self,
        device: &mut V,
        reading: Reading<F, D>,
    ) -> Result<Sample<F, D>, V::Error> {
        self.close(device, reading, None)
    }

    /// One tick with a force that somebody else has computed, N, in place of the environment's.
    ///
    /// # Errors
    /// The device's own.
    #[inline]
    pub fn tick_commanded<V: Device<F, D>>(
        &mut self,
        device: &mut V,
        wanted: &SVector<F, D>,
    ) -> Result<Sample<F, D>, V::Error> {
        self.tick_either(device, Some(wanted))
    }

    /// One tick with the commanded force, or with the environment's if there is none: one place for both, so that the
    /// chain is compiled once into a tick that chooses.
    ///
    /// # Errors
    /// The device's own.
    #[inline]
    pub fn tick_either<V: Device<F, D>>(
        &mut self,
        device: &mut V,
        commanded: Option<&SVector<F, D>>,
    ) -> Result<Sample<F, D>, V::Error> {
        let reading = device.read()?;
        self.close(device, reading, commanded)
    }

    #[inline]
    fn close<V: Device<F, D>>(
        &mut self,
        device: &mut V,
        reading: Reading<F, D>,
        commanded: Option<&SVector<F, D>>,
    ) -> Result<Sample<F, D>, V::Error> {
        self.follow(reading.tick);
        let wanted = match commanded {
            Some(wanted) => *wanted,
            None => self.environment.force(&self.history, &reading.position_m),
        };
        let (force, limiters) = self
            .chain
            .apply(&mut self.safety, &reading.position_m, &wanted);
        let written = device.write(force);
        if commanded.is_none() {
            self.environment
                .advance(&mut self.history, &reading.position_m);
        }
        written?;
        Ok(Sample {
            reading,
            environment_force_n: wanted,
            force,
            limiters,
            observed_energy_j: self.safety.observed_energy_j(),
        })
    }

    /// Whether the device may be armed where it is: what the arming code asks before the first tick, and
    /// again before it clears a fault. Changes nothing.
    ///
    /// # Errors
    /// The force wanted at this reading is not finite, or above [`Limits::start_force`](crate::Limits::start_force).
    pub fn may_start(&self, reading: &Reading<F, D>) -> Result<(), StartRefused> {
        let wanted = self.environment.force(&self.history, &reading.position_m);
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

    /// Latches a fault that something else has found: the force falls to zero within
    /// [`Limits::stop_time`](crate::Limits::stop_time).
    pub fn trip(&mut self, fault: Fault) {
        self.safety.trip(fault);
    }

    /// The device has let go by itself, so the force is zero now, whatever the rate limit.
    pub fn let_go(&mut self) {
        self.safety.let_go();
    }

    /// From the next tick on the force falls to zero, within [`Limits::stop_time`](crate::Limits::stop_time).
    pub fn stop(&mut self) {
        self.safety.stop();
    }

    /// Forgets the past, clears a fault and a stop; the force goes on from where it is, at the rate
    /// limit.
    pub fn reset(&mut self) {
        self.history = self.environment.at_rest();
        self.next = 0;
        self.safety.clear();
    }

    /// The environment.
    pub const fn environment(&self) -> &E {
        &self.environment
    }
}
