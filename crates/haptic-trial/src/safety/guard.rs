//! The guard that an experiment asks for, and what it has to know of the device.

use crate::sensors::Sensors;
use haptic_document::named;
use haptic_link::Capabilities;
use haptic_loop::plant::MassDamperConfig;
use serde::Serialize;

/// Guard that keeps a wall from feeding the device energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum GuardChoice {
    /// No guard: the loop may feed the device energy.
    #[default]
    Off,
    /// Time-domain passivity observer, with the damping that the device bears.
    Observer,
    /// Energy bounding by damping, delay and lag of the device.
    EnergyBounding,
}

named! { GuardChoice:
    Off = "off", "Nothing";
    Observer = "observer", "Time-domain passivity observer, with the damping that the device bears";
    EnergyBounding = "energy-bounding", "Energy bounding by damping, delay and lag of the device";
}

/// Device that a guard is made for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GuardedDevice {
    /// Mass, kg, from a device file or as given, if it is known.
    pub mass_kg: Option<f64>,
    /// Viscous damping, N·s/m, if known.
    pub damping_n_s_per_m: Option<f64>,
    /// Least and most delay from a measurement to the effect of its force, s, if known.
    pub delay_s: Option<(f64, f64)>,
    /// Time constant of the actuator, s, if known.
    pub current_lag_s: Option<f64>,
    /// Standard deviation of the noise of the position, m; none if not known.
    pub noise_m: Option<f64>,
}

impl GuardedDevice {
    /// A simulated device, of which everything is known.
    pub fn simulated(device: &MassDamperConfig, sensors: Sensors) -> Self {
        Self {
            mass_kg: Some(device.mass.0),
            damping_n_s_per_m: Some(device.damping.0),
            delay_s: Some((device.delay.0, device.delay.0)),
            current_lag_s: Some(device.current_lag.0),
            noise_m: Some(sensors.deviation_m()),
        }
    }

    /// Facts that an experiment states about a device not simulated here; an omitted delay or lag is unknown.
    pub fn given(device: &MassDamperConfig) -> Self {
        let (delay, lag) = (device.delay.0, device.current_lag.0);
        Self {
            mass_kg: Some(device.mass.0),
            damping_n_s_per_m: Some(device.damping.0),
            delay_s: (delay > 0.0).then_some((delay, delay)),
            current_lag_s: (lag > 0.0).then_some(lag),
            noise_m: None,
        }
    }

    /// Facts that a board reports about its sensor: it rounds to its resolution.
    pub fn read_by(capabilities: &Capabilities) -> Self {
        let sensors = Sensors {
            encoder_resolution_m: f64::from(capabilities.position_resolution_m),
            noise_m: 0.0,
            seed: 0,
        };
        Self {
            noise_m: Some(sensors.deviation_m()),
            ..Self::default()
        }
    }

    /// Values of this one; where it has none, those of the other.
    pub fn or(self, other: Self) -> Self {
        Self {
            mass_kg: self.mass_kg.or(other.mass_kg),
            damping_n_s_per_m: self.damping_n_s_per_m.or(other.damping_n_s_per_m),
            delay_s: self.delay_s.or(other.delay_s),
            current_lag_s: self.current_lag_s.or(other.current_lag_s),
            noise_m: self.noise_m.or(other.noise_m),
        }
    }
}
