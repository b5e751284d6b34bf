//! A controller at work on a device, which lets go when nobody ticks it any more.

use crate::controller::{Controller, Sample};
use crate::device::Device;
use crate::environment::Environment;
use crate::safety::SafeForce;
use core::fmt;
use fracdiff::Real;

/// A loop that is closed for as long as this value lives: see [`Controller::engage`].
///
/// *Dropped* before the force is zero, by an early return or a panic, it writes a zero force: a force that nobody
/// ticks any more would hold for ever, and nothing is left that could bring it down in steps.
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
///         engaged.tick().unwrap_or_else(|never| match never {});
///     }
/// } // lets go here, whatever ended the loop
/// assert!(controller.safety().is_at_rest());
/// # Ok::<(), haptic_loop::ParameterError>(())
/// ```
pub struct Engaged<'a, F: Real, const D: usize, E: Environment<F, D>, V: Device<F, D>> {
    controller: &'a mut Controller<F, D, E>,
    device: &'a mut V,
}

impl<F: Real, const D: usize, E: Environment<F, D>> Controller<F, D, E> {
    /// Closes the loop with a device until the value is dropped, which leaves no force behind.
    pub const fn engage<'a, V: Device<F, D>>(
        &'a mut self,
        device: &'a mut V,
    ) -> Engaged<'a, F, D, E, V> {
        Engaged {
            controller: self,
            device,
        }
    }
}

impl<F: Real, const D: usize, E: Environment<F, D>, V: Device<F, D>> Engaged<'_, F, D, E, V> {
    /// See [`Controller::tick`].
    ///
    /// # Errors
    /// As there.
    #[inline]
    pub fn tick(&mut self) -> Result<Sample<F, D>, V::Error> {
        self.controller.tick(self.device)
    }

    /// The controller.
    pub const fn controller(&mut self) -> &mut Controller<F, D, E> {
        self.controller
    }

    /// The device.
    pub const fn device(&mut self) -> &mut V {
        self.device
    }
}

impl<F: Real, const D: usize, E: Environment<F, D>, V: Device<F, D>> fmt::Debug
    for Engaged<'_, F, D, E, V>
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Engaged").finish_non_exhaustive()
    }
}

impl<F: Real, const D: usize, E: Environment<F, D>, V: Device<F, D>> Drop
    for Engaged<'_, F, D, E, V>
{
    fn drop(&mut self) {
        if !self.controller.safety().is_at_rest() {
            // A device that cannot be written to has to let go by its own watchdog.
            let _ = self.device.write(SafeForce::zero());
            self.controller.let_go();
        }
    }
}
