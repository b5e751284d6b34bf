//! The sensors that the user asked for, or none.

use haptic_document::{
    Failure,
    parameters::{ENCODER_RESOLUTION, SENSOR_NOISE},
};
use haptic_loop::{
    plant::{ForceSensor, ForceSensorConfig, Sensed},
    units::{Metres, Seconds},
};
use serde::Serialize;

/// Sensors between the position and the loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sensors {
    /// Encoder resolution, m per count; 0 for none.
    pub encoder_resolution_m: f64,
    /// Standard deviation of the noise, m; 0 for none.
    #[serde(rename = "sensor_noise_m")]
    pub noise_m: f64,
    /// The seed of the noise: the same one makes the same noise, bit for bit.
    pub seed: u64,
}

impl Sensors {
    /// The loop reads the true position.
    pub const NONE: Self = Self {
        encoder_resolution_m: 0.0,
        noise_m: 0.0,
        seed: 1,
    };

    /// True if the loop reads the true position.
    pub fn are_ideal(&self) -> bool {
        !(self.encoder_resolution_m > 0.0 || self.noise_m > 0.0)
    }

    /// Standard deviation of what is read about what is: the noise, and q/√12 of an encoder; m.
    pub fn deviation_m(&self) -> f64 {
        let rounded = self.encoder_resolution_m / 12_f64.sqrt();
        libm::hypot(self.noise_m, rounded)
    }

    /// Puts these sensors in front of a device.
    ///
    /// # Errors
    /// A resolution or noise that is negative or not finite.
    pub fn before<V>(self, device: V) -> Result<Sensed<V>, Failure> {
        let (resolution, noise) = (Metres(self.encoder_resolution_m), Metres(self.noise_m));
        Sensed::new(device, resolution, noise, self.seed).map_err(|error| {
            Failure::input_with_advice(
                error,
                format_args!("give {encoder_resolution_m_0} for an ideal encoder, {sensor_noise_m_0} for no noise", encoder_resolution_m_0 = ENCODER_RESOLUTION.set_to("0"), sensor_noise_m_0 = SENSOR_NOISE.set_to("0")),
            )
        })
    }

    /// Puts these sensors in front of a device, and one of its force, if there is one, which is read every T.
    ///
    /// # Errors
    /// A setting that a sensor cannot have.
    pub fn and_force_before<V>(
        self,
        device: V,
        force_sensor: Option<ForceSensorConfig>,
        sample_time: Seconds,
    ) -> Result<Sensed<V>, Failure> {
        let sensor = force_sensor.map(|sensor| ForceSensor::new(sensor, sample_time));
        let sensor = sensor.transpose().map_err(Failure::input)?;
        Ok(self.before(device)?.with_force_sensor(sensor))
    }
}

/// Friction, delay, current lag and sensors of a simulated device.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Imperfections {
    /// Coulomb friction of the device, N; 0 for none.
    pub friction_n: f64,
    /// Delay from a measurement to the force that answers it, beyond the hold, s.
    pub delay_s: f64,
    /// Time constant of the motor current, s.
    pub current_lag_s: f64,
    /// Encoder steps and sensor noise: the position that the loop reads differs from the true one.
    #[serde(flatten)]
    pub sensors: Sensors,
}

impl Imperfections {
    /// True of a device without any.
    #[must_use]
    pub fn is_ideal(&self) -> bool {
        let none = self.friction_n + self.delay_s + self.current_lag_s <= 0.0;
        none && self.sensors.are_ideal()
    }

    /// Imperfections in words, as in `0.05 N friction, 1 ms delay, 1 ms current lag, 1 µm encoder`.
    #[must_use]
    pub fn words(&self) -> String {
        if self.is_ideal() {
            return "no friction, delay, current lag or encoder steps".to_owned();
        }
        // Without the digits that a binary fraction adds.
        let plain = |value: f64| (value * 1e9).round() / 1e9;
        let parts = [
            (self.friction_n, 1.0, "N friction"),
            (self.delay_s, 1e3, "ms delay"),
            (self.current_lag_s, 1e3, "ms current lag"),
            (self.sensors.encoder_resolution_m, 1e6, "µm encoder"),
            (self.sensors.noise_m, 1e6, "µm sensor noise"),
        ];
        let words: Vec<String> = parts
            .into_iter()
            .filter(|(value, ..)| *value > 0.0)
            .map(|(value, factor, words)| format!("{} {words}", plain(factor * value)))
            .collect();
        words.join(", ")
    }
}
