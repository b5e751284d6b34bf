//! A device behind the sensors that it has, or none.

use super::{EncoderQuantiser, SensorNoise};
use crate::units::Metres;
use crate::{Device, ParameterError, Reading, SafeForce};
use fracdiff::Real;

/// A device behind its sensors: noise first, then the encoder, as in a real one.
///
/// ```
/// use fracdiff::Seconds;
/// use haptic_loop::Device;
/// use haptic_loop::plant::{MassDamper, MassDamperConfig, Sensed};
/// use haptic_loop::units::{Kilograms, Metres, NewtonSecondsPerMetre};
/// use nalgebra::vector;
///
/// let ideal = MassDamperConfig::ideal(Kilograms(0.065), NewtonSecondsPerMetre(3.5), Seconds(1e-3));
/// let mut sensed = Sensed::new(MassDamper::<1>::new(ideal)?, Metres(0.5), (Metres(0.0), 1))?;
/// sensed.device_mut().set_state(vector![1.3], vector![0.0]);
/// let read = Device::<f64, 1>::read(&mut sensed).unwrap_or_else(|never| match never {});
/// assert_eq!(read.position_m[0], 1.5);
/// # Ok::<(), haptic_loop::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub enum Sensed<V> {
    /// Neither.
    Ideal(V),
    /// Noise alone.
    Noisy(SensorNoise<V>),
    /// An encoder alone.
    Quantised(EncoderQuantiser<V>),
    /// Both.
    Both(EncoderQuantiser<SensorNoise<V>>),
}

impl<V> Sensed<V> {
    /// Puts an encoder of this resolution, m per count, and noise of this standard deviation and seed before the device; 0 for none.
    ///
    /// # Errors
    /// A resolution or noise that is negative or not finite.
    pub fn new(
        device: V,
        resolution: Metres,
        (noise, seed): (Metres, u64),
    ) -> Result<Self, ParameterError> {
        // Zero means none; anything else that is no resolution is refused below.
        let is_zero = |value: f64| value.abs() < f64::MIN_POSITIVE;
        Ok(match (is_zero(noise.0), is_zero(resolution.0)) {
            (true, true) => Self::Ideal(device),
            (false, true) => Self::Noisy(SensorNoise::new(device, noise, seed)?),
            (true, false) => Self::Quantised(EncoderQuantiser::new(device, resolution)?),
            (false, false) => {
                let noisy = SensorNoise::new(device, noise, seed)?;
                Self::Both(EncoderQuantiser::new(noisy, resolution)?)
            }
        })
    }

    /// The device itself.
    pub const fn device(&self) -> &V {
        match self {
            Self::Ideal(device) => device,
            Self::Noisy(noisy) => noisy.device(),
            Self::Quantised(quantised) => quantised.device(),
            Self::Both(both) => both.device().device(),
        }
    }

    /// The device itself, to set its state.
    pub const fn device_mut(&mut self) -> &mut V {
        match self {
            Self::Ideal(device) => device,
            Self::Noisy(noisy) => noisy.device_mut(),
            Self::Quantised(quantised) => quantised.device_mut(),
            Self::Both(both) => both.device_mut().device_mut(),
        }
    }
}

impl<F: Real, const D: usize, V: Device<F, D>> Device<F, D> for Sensed<V> {
    type Error = V::Error;

    fn read(&mut self) -> Result<Reading<F, D>, V::Error> {
        match self {
            Self::Ideal(device) => device.read(),
            Self::Noisy(device) => device.read(),
            Self::Quantised(device) => device.read(),
            Self::Both(device) => device.read(),
        }
    }

    fn write(&mut self, force: SafeForce<F, D>) -> Result<(), V::Error> {
        match self {
            Self::Ideal(device) => device.write(force),
            Self::Noisy(device) => device.write(force),
            Self::Quantised(device) => device.write(force),
            Self::Both(device) => device.write(force),
        }
    }

    fn let_go(&mut self) {
        match self {
            Self::Ideal(device) => device.let_go(),
            Self::Noisy(device) => device.let_go(),
            Self::Quantised(device) => device.let_go(),
            Self::Both(device) => device.let_go(),
        }
    }
}
