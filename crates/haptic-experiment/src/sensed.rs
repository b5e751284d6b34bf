//! A simulated device behind the sensors that the user asked for, or none.

use crate::failure::Failure;
use fracdiff::Real;
use haptic_loop::plant::{EncoderQuantiser, SensorNoise};
use haptic_loop::units::Metres;
use haptic_loop::{Device, Reading, SafeForce};
use serde::Serialize;

/// Sensors between the position and the loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sensors {
    /// Encoder resolution, m per count; 0 for none.
    pub encoder_resolution_m: f64,
    /// Standard deviation of the noise, m; 0 for none.
    #[serde(rename = "sensor_noise_m")]
    pub noise_m: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl Sensors {
    /// True if the loop reads the true position.
    #[must_use]
    pub fn are_ideal(&self) -> bool {
        !(self.encoder_resolution_m > 0.0 || self.noise_m > 0.0)
    }

    /// Standard deviation of what is read about what is: the noise, and q/√12 of an encoder; m.
    #[must_use]
    pub fn deviation_m(&self) -> f64 {
        let rounded = self.encoder_resolution_m / 12_f64.sqrt();
        self.noise_m.hypot(rounded)
    }
}

/// A device behind its sensors: noise first, then the encoder, as in a real one.
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
    /// Puts the sensors in front of the device.
    ///
    /// # Errors
    /// A resolution or noise that is negative or not finite.
    pub fn new(device: V, sensors: Sensors) -> Result<Self, Failure> {
        let Sensors {
            encoder_resolution_m: resolution,
            noise_m,
            seed,
        } = sensors;
        let noisy = |device| {
            SensorNoise::new(device, Metres(noise_m), seed).map_err(|error| {
                Failure::input_with_advice(error, "give `sensor_noise_m` = 0 for none")
            })
        };
        // Zero means none; anything else that is no resolution is refused below.
        let is_zero = |value: f64| value.abs() < f64::MIN_POSITIVE;
        let no_encoder = |error| {
            Failure::input_with_advice(
                error,
                "give `encoder_resolution_m` = 0 for an ideal encoder",
            )
        };
        let resolution_m = Metres(resolution);
        Ok(match (is_zero(noise_m), is_zero(resolution)) {
            (true, true) => Self::Ideal(device),
            (false, true) => Self::Noisy(noisy(device)?),
            (true, false) => {
                Self::Quantised(EncoderQuantiser::new(device, resolution_m).map_err(no_encoder)?)
            }
            (false, false) => {
                Self::Both(EncoderQuantiser::new(noisy(device)?, resolution_m).map_err(no_encoder)?)
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
}
