//! A device behind the sensors that it has, or none.

use super::ForceSensor;
use super::noise::normal;
use crate::units::Metres;
use crate::{Device, LoopParameterError, Reading, SafeForce};
use fracdiff::Real;
use fracdiff::parameter::{not_negative, positive};
use rand_pcg::{Pcg32, rand_core::SeedableRng};

/// A device behind its sensors: noise first, then the encoder, as in a real one.
///
/// ```text
/// position = q·round((position + σ·g)/q)      q resolution m per count, σ standard deviation m, 0 for none;
///                                             g independent, standard normal, one per axis and reading
/// ```
/// - *Repeatable*: the same seed gives the same readings, bit for bit, in the order they are taken.
/// - *Rounding*: halves away from zero; each step is rounded once to the loop's precision.
/// - *Cost* per axis: a normal number, one division and one rounding.
#[derive(Clone, Debug)]
pub struct Sensed<V> {
    device: V,
    resolution: Option<f64>,
    noise: Option<(f64, Pcg32)>,
    force_sensor: Option<ForceSensor>,
}

impl<V> Sensed<V> {
    /// Puts an encoder of this resolution, m per count, and noise of this standard deviation and seed before the device; 0 for none.
    ///
    /// # Errors
    /// A resolution or noise that is negative or not finite.
    pub fn new(
        device: V,
        resolution: Metres,
        noise: Metres,
        seed: u64,
    ) -> Result<Self, LoopParameterError> {
        let some =
            |value: f64| (value.abs() >= f64::MIN_POSITIVE || value.is_nan()).then_some(value);
        let noise = match some(noise.0) {
            Some(noise) => {
                let deviation = not_negative("standard deviation of the noise", noise, "m")?;
                Some((deviation, Pcg32::seed_from_u64(seed)))
            }
            None => None,
        };
        let resolution = some(resolution.0);
        Ok(Self {
            device,
            resolution: resolution
                .map(|resolution| positive("encoder resolution", resolution, "m"))
                .transpose()?,
            noise,
            force_sensor: None,
        })
    }

    /// Device with a force sensor too, or without one.
    #[must_use]
    pub fn with_force_sensor(self, force_sensor: Option<ForceSensor>) -> Self {
        Self {
            force_sensor,
            ..self
        }
    }

    /// Turns the force of the hand on each axis, N, into the next reading of the force sensor; false without one.
    pub fn sense(&mut self, forces: &mut [f64]) -> bool {
        let sensor = self.force_sensor.as_mut();
        sensor.map(|sensor| sensor.read(forces)).is_some()
    }

    /// The device behind the sensors, as it truly is.
    pub const fn device(&self) -> &V {
        &self.device
    }

    /// The device itself, to set its state.
    pub const fn device_mut(&mut self) -> &mut V {
        &mut self.device
    }
}

impl<F: Real, const D: usize, V: Device<F, D>> Device<F, D> for Sensed<V> {
    type Error = V::Error;

    fn read(&mut self) -> Result<Reading<F, D>, V::Error> {
        let mut reading = self.device.read()?;
        for axis in &mut reading.position_m {
            if let Some((deviation, generator)) = &mut self.noise {
                let noise = normal(generator);
                *axis = F::from_f64(axis.to_f64() + *deviation * noise);
            }
        }
        if let Some(resolution) = self.resolution {
            for axis in &mut reading.position_m {
                let counts = libm::round(axis.to_f64() / resolution);
                *axis = F::from_f64(counts * resolution);
            }
        }
        Ok(reading)
    }

    fn write(&mut self, force: SafeForce<F, D>) -> Result<(), V::Error> {
        self.device.write(force)
    }

    fn let_go(&mut self) {
        self.device.let_go();
    }

    fn stop(&mut self) {
        self.device.stop();
    }

    fn moves(&self) -> bool {
        self.device.moves()
    }
}
