//! Imperfections of real devices, beside mass, damping and a hand.

use super::sensors::Sensors;
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::{Newtons, Seconds};
use serde::Serialize;

/// Friction, delay, current lag and sensors of a simulated device.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Imperfections {
    /// Coulomb friction, N.
    pub friction_n: f64,
    /// From a measurement to the force that answers it, beside the hold, s.
    pub delay_s: f64,
    /// Time constant of the motor current, s.
    pub current_lag_s: f64,
    /// Encoder and noise.
    #[serde(flatten)]
    pub sensors: Sensors,
}

impl Imperfections {
    /// A device without any.
    pub const NONE: Self = Self {
        friction_n: 0.0,
        delay_s: 0.0,
        current_lag_s: 0.0,
        sensors: Sensors {
            encoder_resolution_m: 0.0,
            noise_m: 0.0,
            seed: 1,
        },
    };

    /// True if there is none.
    #[must_use]
    pub(crate) fn is_ideal(&self) -> bool {
        let none = self.friction_n + self.delay_s + self.current_lag_s <= 0.0;
        none && self.sensors.are_ideal()
    }

    /// A device that has them.
    #[must_use]
    pub const fn on(&self, ideal: MassDamperConfig) -> MassDamperConfig {
        MassDamperConfig {
            friction: Newtons(self.friction_n),
            delay: Seconds(self.delay_s),
            lag: Seconds(self.current_lag_s),
            ..ideal
        }
    }

    /// Standard deviation of what the sensors add to the position, m: steps of q have q/√12.
    #[must_use]
    pub(crate) fn position_noise_m(&self) -> f64 {
        let steps = self.sensors.encoder_resolution_m / 12.0_f64.sqrt();
        steps.hypot(self.sensors.noise_m)
    }

    /// In words, as in `0.05 N friction, 1 ms delay, 1 ms current lag, 1 µm encoder`.
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
