//! The loop's view of a device.

use crate::SafeForce;
use core::fmt::Debug;
use fracdiff::Real;
use nalgebra::SVector;

/// The readings of a device's sensors at the start of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading<F, const D: usize> {
    /// Number of the tick, from 0.
    pub tick: u64,
    /// The device's own time since its start, s. Virtual in simulation.
    pub time_s: f64,
    /// Position of the end effector, m.
    pub position_m: SVector<F, D>,
}

/// A haptic device with D degrees of freedom, real or simulated: read, then write, once a tick.
///
/// The force acts in the direction of positive position and holds until the next write.
pub trait Device<F: Real, const D: usize> {
    /// Why a reading or a force did not get through; `Infallible` for a simulated device.
    type Error: Debug;

    /// Reads the sensors.
    ///
    /// # Errors
    /// As the device says.
    fn read(&mut self) -> Result<Reading<F, D>, Self::Error>;

    /// Applies a force until the next tick. A simulated device moves on by one sample time.
    ///
    /// # Errors
    /// As the device says.
    fn write(&mut self, force: SafeForce<F, D>) -> Result<(), Self::Error>;

    /// No force from now on, whatever was written last: nobody ticks any more, or the device has failed. *Default*: writes zero. A device
    /// with more than that, such as the enable line of an amplifier, uses it here.
    fn let_go(&mut self) {
        // One that cannot even be written to has to let go by its own watchdog.
        let _ = self.write(SafeForce::zero());
    }

    /// Comes to rest from the next write on, and stays there: the loop has a fault or was stopped. *Default*: does nothing, as a
    /// device that only obeys forces gets none. A device that [moves](Self::moves) brakes.
    #[inline]
    fn stop(&mut self) {}

    /// True while the device moves under a command of its own, so that zero force is not zero motion: whoever ends the loop lets it
    /// go. *Default*: false.
    #[inline]
    fn moves(&self) -> bool {
        false
    }
}

impl<F: Real, const D: usize, V: Device<F, D> + ?Sized> Device<F, D> for &mut V {
    type Error = V::Error;

    #[inline]
    fn read(&mut self) -> Result<Reading<F, D>, V::Error> {
        (**self).read()
    }

    #[inline]
    fn write(&mut self, force: SafeForce<F, D>) -> Result<(), V::Error> {
        (**self).write(force)
    }

    fn let_go(&mut self) {
        (**self).let_go();
    }

    #[inline]
    fn stop(&mut self) {
        (**self).stop();
    }

    #[inline]
    fn moves(&self) -> bool {
        (**self).moves()
    }
}
