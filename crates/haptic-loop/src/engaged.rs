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
