//! The sensors that the user asked for, or none.

use crate::document::failure::Failure;
use crate::document::parameters::{ENCODER_RESOLUTION, SENSOR_NOISE};
use haptic_loop::plant::Sensed;
use haptic_loop::units::Metres;
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
    pub(crate) fn deviation_m(&self) -> f64 {
        let rounded = self.encoder_resolution_m / 12_f64.sqrt();
        self.noise_m.hypot(rounded)
    }

    /// Puts them before a device.
    ///
    /// # Errors
    /// A resolution or noise that is negative or not finite.
    pub fn before<V>(self, device: V) -> Result<Sensed<V>, Failure> {
        let noise = (Metres(self.noise_m), self.seed);
        Sensed::new(device, Metres(self.encoder_resolution_m), noise).map_err(|error| {
            Failure::input_with_advice(
                error,
                format_args!("give {encoder_resolution_m_0} for an ideal encoder, {sensor_noise_m_0} for no noise", encoder_resolution_m_0 = ENCODER_RESOLUTION.set_to("0"), sensor_noise_m_0 = SENSOR_NOISE.set_to("0")),
            )
        })
    }
}
