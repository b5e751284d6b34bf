//! A position sensor with a finite resolution.

use crate::error::positive;
use crate::units::Metres;
use crate::{Device, ParameterError, Reading, SafeForce};
use fracdiff::Real;

/// A device read through an encoder: positions are rounded to the nearest count.
///
/// ```text
/// position = q·round(position/q)
/// ```
/// - *Symbols*: q resolution, m per count, > 0. Halves round away from zero.
/// - *Accuracy*: within q/2 of the true position, plus one rounding to the loop's precision.
/// - *Cost*: one division and one rounding per axis.
///
/// ```
/// use fracdiff::Seconds;
/// use haptic_loop::plant::{EncoderQuantiser, MassDamper, MassDamperConfig, SensorNoise};
/// use haptic_loop::units::{Kilograms, Metres, NewtonSecondsPerMetre};
///
/// let ideal = MassDamperConfig::ideal(Kilograms(0.065), NewtonSecondsPerMetre(3.5), Seconds(1e-3));
/// // Noise of 2 µm, then counts of 5 µm: wrappers may be stacked.
/// let noisy = SensorNoise::new(MassDamper::<1>::new(ideal)?, Metres(2e-6), 1)?;
/// let sensed = EncoderQuantiser::new(noisy, Metres(5e-6))?;
/// # let _ = sensed;
/// # Ok::<(), haptic_loop::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct EncoderQuantiser<V> {
    device: V,
    resolution: f64,
}

impl<V> EncoderQuantiser<V> {
    /// Reads `device` through an encoder of this resolution, m per count.
    ///
    /// # Errors
    /// Unless the resolution is finite and above zero.
    pub fn new(device: V, resolution: Metres) -> Result<Self, ParameterError> {
        let resolution = positive("encoder resolution", resolution.0, "m")?;
        Ok(Self { device, resolution })
    }

    /// The device inside.
    pub const fn device(&self) -> &V {
        &self.device
    }

    /// The device inside, to set its state or an external force.
    pub const fn device_mut(&mut self) -> &mut V {
        &mut self.device
    }
}

impl<F: Real, const D: usize, V: Device<F, D>> Device<F, D> for EncoderQuantiser<V> {
    type Error = V::Error;

    fn read(&mut self) -> Result<Reading<F, D>, Self::Error> {
        let mut reading = self.device.read()?;
        for axis in &mut reading.position_m {
            // position = q·round(position/q)
            let counts = libm::round(axis.to_f64() / self.resolution);
            *axis = F::from_f64(counts * self.resolution);
        }
        Ok(reading)
    }

    fn write(&mut self, force: SafeForce<F, D>) -> Result<(), Self::Error> {
        self.device.write(force)
    }

    fn let_go(&mut self) {
        self.device.let_go();
    }
}
