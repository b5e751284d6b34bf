//! A controller at work on a device: the one tick that every loop runs, on the host, in simulation and in firmware.
//!
//! ```text
//! device.read ─▶ environment.force ─▶ safety chain ─SafeForce─▶ device.write ─▶ environment.advance
//! ```
//! Sensor to force first, everything else after.

use crate::controller::{Controller, LoopSample};
use crate::device::{Device, Reading};
use crate::environment::Environment;
use crate::safety::Fault;
use core::borrow::BorrowMut;
use core::marker::PhantomData;
use fracdiff::Real;
use nalgebra::SVector;

/// A loop that stays closed while this value lives, and leaves no force behind: see
/// [`Controller::engage`].
///
/// - *Error* of the device: it [lets go](Device::let_go) at once, and [`Fault::BoardFailed`] is latched, so whoever ticks on gets no
///   force until [`Controller::clear`].
/// - *Fault* of the chain: in the [`LoopSample`]; the force falls to zero within [`SafetyLimits::stop_time`](crate::SafetyLimits::stop_time) while it
///   is ticked.
/// - *Device that moves*: a fault or stop of the chain [stops](Device::stop) it too, as zero force is not zero motion.
/// - *Dropped* before the force is zero, or while the device [moves](Device::moves), by an early return or a panic that unwinds, it lets go: a force that nobody ticks any more
///   would hold for ever, and nothing is left that could bring it down in steps.
/// - *In an interrupt* it owns both, [`Controller::into_engaged`]. A panic there does not unwind: the panic handler has to take the
///   force away by the registers, as each image in `firmware` does.
/// - *Cost* of a tick: the device's read and write, the environment's force and advance, a few comparisons; no allocation, lock,
///   formatting or panic.
///
/// ```
/// use fracdiff::{Order, Seconds, ShortMemory};
/// use haptic_loop::plant::{MassDamper, MassDamperConfig};
/// use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond};
/// use haptic_loop::{Controller, SafetyChain, SpringDamper};
///
/// let t = Seconds(1e-3);
/// let wall = SpringDamper::new(500.0, 2.0, ShortMemory::<f64, 64>::new(Order::new(0.5)?, t)?)?;
/// let chain = SafetyChain::new(Newtons(10.0), NewtonsPerSecond(1e4), t)?;
/// let mut controller = Controller::<_, 1, _>::new(wall, chain);
/// let testbed = MassDamperConfig::ideal(Kilograms(0.065), NewtonSecondsPerMetre(3.5), t);
/// let mut device = MassDamper::<1>::new(testbed)?;
/// {
///     let mut engaged = controller.engage(&mut device);
///     for _ in 0..100 {
///         let Ok(sample) = engaged.tick();
///         assert_eq!(sample.fault, None);
///     }
/// } // lets go here, whatever ended the loop
/// assert!(controller.safety().is_at_rest());
/// # Ok::<(), haptic_loop::LoopParameterError>(())
/// ```
#[derive(Debug)]
pub struct Engaged<F, const D: usize, E, V, C = Controller<F, D, E>>
where
    F: Real,
    E: Environment<F, D>,
    V: Device<F, D>,
    C: BorrowMut<Controller<F, D, E>>,
{
    controller: C,
    device: V,
    runs: PhantomData<Controller<F, D, E>>,
}

impl<F: Real, const D: usize, E: Environment<F, D>> Controller<F, D, E> {
    /// Closes the loop with a device, or with a `&mut` to one, until the value is dropped, which leaves no force behind.
    pub const fn engage<V: Device<F, D>>(&mut self, device: V) -> Engaged<F, D, E, V, &mut Self> {
        Engaged {
            controller: self,
            device,
            runs: PhantomData,
        }
    }

    /// Closes the loop as [`engage`](Self::engage) does, but permanently, for a static whose interrupt ticks.
    #[inline]
    pub const fn into_engaged<V: Device<F, D>>(self, device: V) -> Engaged<F, D, E, V> {
        Engaged {
            controller: self,
            device,
            runs: PhantomData,
        }
    }
}

impl<F, const D: usize, E, V, C> Engaged<F, D, E, V, C>
where
    F: Real,
    E: Environment<F, D>,
    V: Device<F, D>,
    C: BorrowMut<Controller<F, D, E>>,
{
    /// One tick.
    ///
    /// # Errors
    /// The device's own; it has let go. A failed read leaves the history unchanged; after
    /// a failed write it includes the position.
    #[inline]
    pub fn tick(&mut self) -> Result<LoopSample<F, D>, V::Error> {
        self.tick_commanded(None)
    }

    /// One tick that uses the given force, N, if there is one, instead of the environment's. One
    /// function does both, so the chain is compiled only once.
    ///
    /// # Errors
    /// As [`tick`](Self::tick).
    #[inline]
    pub fn tick_commanded(
        &mut self,
        commanded: Option<&SVector<F, D>>,
    ) -> Result<LoopSample<F, D>, V::Error> {
        let reading = self.read()?;
        self.close(reading, commanded)
    }

    /// One tick after some that were missed since the device was at this position, m. The law takes those in on the straight
    /// line from there to where the device is now, as if the whole motion had not been made in one sample time.
    ///
    /// # Errors
    /// As [`tick`](Self::tick).
    #[inline]
    pub fn tick_after(
        &mut self,
        missed: u32,
        last_m: &SVector<F, D>,
        commanded: Option<&SVector<F, D>>,
    ) -> Result<LoopSample<F, D>, V::Error> {
        let reading = self.read()?;
        if missed > 0 && commanded.is_none() {
            self.controller_mut().pass(missed, last_m, &reading);
        }
        self.close(reading, commanded)
    }

    /// Runs up to `ticks` ticks, until `see` returns false or a fault is latched; `true` if it reached the end without a fault.
    ///
    /// # Errors
    /// As [`tick`](Self::tick).
    #[inline]
    pub fn run(
        &mut self,
        ticks: u64,
        mut see: impl FnMut(&LoopSample<F, D>) -> bool,
    ) -> Result<bool, V::Error> {
        for _ in 0..ticks {
            let sample = self.tick()?;
            if !see(&sample) || self.controller().safety().fault().is_some() {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The first part of a tick alone, for a device whose next sample is not ready yet.
    ///
    /// # Errors
    /// As [`tick`](Self::tick).
    #[inline]
    pub fn read(&mut self) -> Result<Reading<F, D>, V::Error> {
        let read = self.device.read();
        if read.is_err() {
            self.let_go(Fault::BoardFailed);
        }
        read
    }

    /// The rest of a tick, for a reading that has already arrived.
    ///
    /// # Errors
    /// As [`tick`](Self::tick), of the write.
    #[inline]
    pub fn tick_reading(&mut self, reading: Reading<F, D>) -> Result<LoopSample<F, D>, V::Error> {
        self.close(reading, None)
    }

    #[inline]
    fn close(
        &mut self,
        reading: Reading<F, D>,
        commanded: Option<&SVector<F, D>>,
    ) -> Result<LoopSample<F, D>, V::Error> {
        let controller = self.controller.borrow_mut();
        let (sample, input) = controller.force(reading, commanded);
        if controller.safety().is_released() {
            self.device.stop();
        }
        let written = self.device.write(sample.force);
        if commanded.is_none() {
            controller.advance(&input, &sample);
        }
        if written.is_err() {
            self.let_go(Fault::BoardFailed);
        }
        written.map(|()| sample)
    }

    /// Call this when the loop cannot continue: the device lets go at once, and this fault is latched
    /// unless another already is. An error of the device does the same.
    #[inline(never)]
    pub fn let_go(&mut self, fault: Fault) {
        self.device.let_go();
        let controller = self.controller.borrow_mut();
        controller.trip(fault);
        controller.let_go();
    }

    /// The controller, to see its state.
    #[inline]
    pub fn controller(&self) -> &Controller<F, D, E> {
        self.controller.borrow()
    }

    /// The controller, to change its law or to stop it.
    #[inline]
    pub fn controller_mut(&mut self) -> &mut Controller<F, D, E> {
        self.controller.borrow_mut()
    }

    /// The device, to look at it between ticks.
    #[inline]
    pub const fn device(&self) -> &V {
        &self.device
    }

    /// The device, for functions outside the loop.
    #[inline]
    pub const fn device_mut(&mut self) -> &mut V {
        &mut self.device
    }
}

impl<F, const D: usize, E, V, C> Drop for Engaged<F, D, E, V, C>
where
    F: Real,
    E: Environment<F, D>,
    V: Device<F, D>,
    C: BorrowMut<Controller<F, D, E>>,
{
    fn drop(&mut self) {
        let controller = self.controller.borrow_mut();
        if !controller.safety().is_at_rest() || self.device.moves() {
            self.device.let_go();
            controller.let_go();
        }
    }
}
