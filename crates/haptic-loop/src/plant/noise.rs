//! A position sensor with Gaussian noise.

use crate::error::not_negative;
use crate::units::Metres;
use crate::{Device, ParameterError, Reading, SafeForce};
use fracdiff::Real;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::{Pcg32, rand_core::SeedableRng};

/// A device whose positions carry white Gaussian noise.
///
/// ```text
/// position = position + σ·g,    g independent, standard normal, one per axis and reading
/// ```
/// - *Symbols*: σ standard deviation, m, ≥ 0.
/// - *Repeatable*: the same seed gives the same readings, bit for bit, in the order they are taken.
/// - *Cost*: one ziggurat draw per axis from a 64-bit permuted congruential generator.
#[derive(Clone, Debug)]
pub struct SensorNoise<V> {
    device: V,
    deviation: f64,
    generator: Pcg32,
}

impl<V> SensorNoise<V> {
    /// Adds noise of this standard deviation to the positions of `device`.
    ///
    /// # Errors
    /// Unless the standard deviation is finite and at least zero.
    pub fn new(device: V, deviation: Metres, seed: u64) -> Result<Self, ParameterError> {
        Ok(Self {
            device,
            deviation: not_negative("standard deviation of the noise", deviation.0, "m")?,
            generator: Pcg32::seed_from_u64(seed),
        })
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

impl<F: Real, const D: usize, V: Device<F, D>> Device<F, D> for SensorNoise<V> {
    type Error = V::Error;

    fn read(&mut self) -> Result<Reading<F, D>, Self::Error> {
        let mut reading = self.device.read()?;
        for axis in &mut reading.position_m {
            // position = position + σ·g
            let normal: f64 = StandardNormal.sample(&mut self.generator);
            *axis = F::from_f64(axis.to_f64() + self.deviation * normal);
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
