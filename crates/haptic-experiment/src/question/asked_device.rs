//! The device of a question, as its answer repeats it.

use haptic_loop::plant::MassDamperConfig;
use serde::Serialize;

/// What an answer is for: who took a wrong unit sees it here.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AskedDevice {
    /// m.
    pub mass_kg: f64,
    /// b.
    pub damping_n_s_per_m: f64,
    /// k, of the hand.
    pub hand_stiffness_n_per_m: f64,
    /// T.
    pub sample_time_s: f64,
}

impl AskedDevice {
    /// This device.
    #[must_use]
    pub const fn of(device: &MassDamperConfig) -> Self {
        Self {
            mass_kg: device.mass.0,
            damping_n_s_per_m: device.damping.0,
            hand_stiffness_n_per_m: device.stiffness.0,
            sample_time_s: device.sample_time.0,
        }
    }
}
