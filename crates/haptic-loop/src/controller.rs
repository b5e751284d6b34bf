//! The controller tick: the one function that every loop runs, on the host, in simulation and in
//! firmware.
//!
//! ```text
//! device.read ─▶ environment.force ─▶ safety chain ─SafeForce─▶ device.write ─▶ environment.advance
//! ```
//! Sensor to force first, everything else after.

use crate::device::{Device, Reading};
use crate::environment::Environment;
use crate::safety::{Fault, Limiters, SafeForce, SafetyChain, SafetyState, StartRefused};
use fracdiff::Real;
use nalgebra::SVector;

/// The readings and forces of one tick, for a recorder.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Sample<F, const D: usize> {
    /// Tick, time and position.
    pub reading: Reading<F, D>,
    /// The force that the environment wanted, N.
    pub environment_force_n: SVector<F, D>,
    /// The force that was sent to the device, N.
    pub force: SafeForce<F, D>,
    /// The limiters of the safety chain that acted on it.
    pub limiters: Limiters,
    /// The energy that its passivity guard observed, J: see [`SafetyState::observed_energy_j`].
    pub observed_energy_j: F,
}

/// An environment behind a safety chain, with the state of both.
///
/// ```
/// use fracdiff::{Order, Seconds, ShortMemory};
/// use haptic_loop::plant::{MassDamper, MassDamperConfig};
/// use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond};
/// use haptic_loop::{Controller, SafetyChain, SpringDamper};
///
/// let t = Seconds(1e-3);
/// let operator = ShortMemory::<f64, 64>::new(Order::new(0.5)?, t)?;
/// let wall = SpringDamper::new(500.0, 2.0, operator)?; // K in N/m, B in N·s^μ/m
/// let chain = SafetyChain::new(Newtons(10.0), NewtonsPerSecond(1e4), t)?;
/// let mut controller = Controller::<_, 1, _>::new(wall, chain);
/// let testbed = MassDamperConfig::ideal(Kilograms(0.065), NewtonSecondsPerMetre(3.5), t);
/// let mut device = MassDamper::<1>::new(testbed)?;
/// for _ in 0..100 {
///     let sample = controller.tick(&mut device).unwrap_or_else(|never| match never {});
///     assert!(sample.force.newtons()[0].abs() <= 10.0);
/// }
/// # Ok::<(), haptic_loop::ParameterError>(())
/// ```
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

/// A tick whose force is known and whose rest is still to come: see [`Controller::begin`].
///
/// It holds the controller, so nothing can come between the two halves: no other tick, stop or reset. *Dropped* it
/// finishes too, so a tick that was given up half way leaves no gap in the history. Only `core::mem::forget` makes one,
/// as a failed read does; the force of a gap is wrong, but the safety chain and its guard know all that was sent.
#[must_use = "send its force, then finish it"]
#[derive(Debug)]
pub struct Begun<'a, F: Real, const D: usize, E: Environment<F, D>> {
    controller: &'a mut Controller<F, D, E>,
    sample: Sample<F, D>,
    /// The force is the environment's own, which then takes the position into its history.
    own: bool,
}

impl<F: Real, const D: usize, E: Environment<F, D>> Begun<'_, F, D, E> {
    /// The force to send to the device.
    #[inline]
    pub const fn force(&self) -> SafeForce<F, D> {
        self.sample.force
    }

    /// The rest of the tick: the history takes the position in.
    #[inline]
    pub fn finish(self) -> Sample<F, D> {
        self.sample
    }
}

impl<F: Real, const D: usize, E: Environment<F, D>> Drop for Begun<'_, F, D, E> {
    #[inline]
    fn drop(&mut self) {
        if self.own {
            let Controller {
                environment,
                history,
                ..
            } = &mut *self.controller;
            environment.advance(history, &self.sample.reading.position_m);
        }
    }
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
        self.replace_within(chain, |own| *own = environment);
    }

    /// As [`replace`](Self::replace), with the environment changed in its place: for a stack without room for another one.
    pub fn replace_within(&mut self, chain: SafetyChain<F>, change: impl FnOnce(&mut E)) {
        change(&mut self.environment);
        self.environment.rest(&mut self.history);
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
        let begun = self.begin_either(reading, commanded);
        let written = device.write(begun.force());
        let sample = begun.finish();
        written?;
        Ok(sample)
    }

    /// The first half of a tick, for a device that cannot be written to inside one (DMA, async): the force for this
    /// reading. Send it, then [`finish`](Begun::finish).
    ///
    /// With [`Device::write`] between the two halves it is [`tick`](Self::tick), bit for bit. The safety chain has
    /// booked the force as sent: one that never gets to the device counts as a failed write.
    ///
    /// ```
    /// use fracdiff::{Order, Seconds, ShortMemory};
    /// use haptic_loop::units::{Newtons, NewtonsPerSecond};
    /// use haptic_loop::{Controller, Reading, SafetyChain, SpringDamper};
    /// use nalgebra::vector;
    ///
    /// let t = Seconds(1e-3);
    /// let operator = ShortMemory::<f32, 64>::new(Order::new(0.5)?, t)?;
    /// let wall = SpringDamper::new(500.0, 2.0, operator)?;
    /// let chain = SafetyChain::new(Newtons(10.0), NewtonsPerSecond(1e6), t)?;
    /// let mut controller = Controller::<_, 1, _>::new(wall, chain);
    ///
    /// let reading = Reading { tick: 0, time_s: 0.0, position_m: vector![1e-3_f32] };
    /// let begun = controller.begin(reading);
    /// let transfer = begun.force(); // start it, do not wait for its end
    /// let sample = begun.finish(); // meanwhile the history takes the position in
    /// assert_eq!(sample.force, transfer);
    /// # Ok::<(), haptic_loop::ParameterError>(())
    /// ```
    #[inline]
    pub fn begin(&mut self, reading: Reading<F, D>) -> Begun<'_, F, D, E> {
        self.begin_either(reading, None)
    }

    /// As [`begin`](Self::begin), with a force that somebody else has computed, N.
    #[inline]
    pub fn begin_commanded(
        &mut self,
        reading: Reading<F, D>,
        wanted: &SVector<F, D>,
    ) -> Begun<'_, F, D, E> {
        self.begin_either(reading, Some(wanted))
    }

    #[inline]
    fn begin_either(
        &mut self,
        reading: Reading<F, D>,
        commanded: Option<&SVector<F, D>>,
    ) -> Begun<'_, F, D, E> {
        self.follow(reading.tick);
        let wanted = match commanded {
            Some(wanted) => *wanted,
            None => self.environment.force(&self.history, &reading.position_m),
        };
        let (force, limiters) = self
            .chain
            .apply(&mut self.safety, &reading.position_m, &wanted);
        let sample = Sample {
            reading,
            environment_force_n: wanted,
            force,
            limiters,
            observed_energy_j: self.safety.observed_energy_j(),
        };
        Begun {
            controller: self,
            sample,
            own: commanded.is_none(),
        }
    }

    /// Checks that the device may be armed in its place: the arming code asks before the first tick, and
    /// again before it clears a fault. Changes nothing.
    ///
    /// # Errors
    /// The force wanted at this reading is not finite, or above [`Limits::start_force`](crate::Limits::start_force).
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

    /// Latches a fault that something else has found: the force falls to zero within
    /// [`Limits::stop_time`](crate::Limits::stop_time).
    pub fn trip(&mut self, fault: Fault) {
        self.safety.trip(fault);
    }

    /// The device has let go by itself, so the force is zero now, whatever the rate limit.
    pub fn let_go(&mut self) {
        self.safety.let_go();
    }

    /// The next tick comes after so many that did not, and that its number does not count: see [`SafetyState::skip`].
    pub fn skip(&mut self, ticks: u64) {
        self.safety.skip(ticks);
    }

    /// The position of the next tick comes after so many without one: see [`SafetyState::unmeasured`].
    pub fn unmeasured(&mut self, ticks: u32) {
        self.safety.unmeasured(ticks);
    }

    /// From the next tick on the force falls to zero, within [`Limits::stop_time`](crate::Limits::stop_time).
    pub fn stop(&mut self) {
        self.safety.stop();
    }

    /// Forgets the past, clears a fault and a stop; the force goes on from where it is, at the rate
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

    /// The environment.
    pub const fn environment(&self) -> &E {
        &self.environment
    }

    /// The environment and its memory, to change the law while the loop runs.
    ///
    /// The safety chain goes on: the force moves to that of the new law at the rate limit. A history that has not seen the
    /// same positions makes the wanted force jump; one of another environment makes it wrong.
    pub const fn law_mut(&mut self) -> (&mut E, &mut E::History) {
        (&mut self.environment, &mut self.history)
    }
}
