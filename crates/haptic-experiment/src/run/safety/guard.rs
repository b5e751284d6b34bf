//! The guard that an experiment asks for, and what it has to know of the device.

use crate::document::failure::Failure;
use crate::document::named::Named;
use crate::document::parameters::{
    DEVICE_DAMPING, DEVICE_DELAY_LEAST, DEVICE_DELAY_MOST, DEVICE_LAG, DEVICE_MASS, Parameter,
};
use crate::run::sensors::Sensors;
use haptic_link::Capabilities;
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::{Kilograms, Metres, NewtonSecondsPerMetre, Seconds};
use haptic_loop::{EnergyBounding, Guard, PassivityObserver};
use serde::Serialize;
use std::fmt;

/// Guard that keeps a wall from feeding the device energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum GuardChoice {
    /// Nothing.
    #[default]
    Off,
    /// Time-domain passivity observer, with the damping that the device bears.
    Observer,
    /// Energy bounding by damping, delay and lag of the device.
    EnergyBounding,
}

impl Named for GuardChoice {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Off, "off", "Nothing"),
        (
            Self::Observer,
            "observer",
            "Time-domain passivity observer, with the damping that the device bears",
        ),
        (
            Self::EnergyBounding,
            "energy-bounding",
            "Energy bounding by damping, delay and lag of the device",
        ),
    ];
}

/// Device that a guard is made for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GuardedDevice {
    /// Mass, kg, if known.
    pub mass_kg: Option<f64>,
    /// Viscous damping, N·s/m, if known.
    pub damping_n_s_per_m: Option<f64>,
    /// Least and most delay from a measurement to the effect of its force, s, if known.
    pub delay_s: Option<(f64, f64)>,
    /// Time constant of the actuator, s, if known.
    pub lag_s: Option<f64>,
    /// Standard deviation of the noise of the position, m; none if not known.
    pub noise_m: Option<f64>,
}

impl GuardedDevice {
    /// A simulated device, of which everything is known.
    pub(crate) fn simulated(device: &MassDamperConfig, sensors: Sensors) -> Self {
        Self {
            mass_kg: Some(device.mass.0),
            damping_n_s_per_m: Some(device.damping.0),
            delay_s: Some((device.delay.0, device.delay.0)),
            lag_s: Some(device.lag.0),
            noise_m: Some(sensors.deviation_m()),
        }
    }

    /// What an experiment says of a device that is not simulated here: a delay or lag that it does not speak of is not known.
    pub(crate) fn given(device: &MassDamperConfig) -> Self {
        let (delay, lag) = (device.delay.0, device.lag.0);
        Self {
            mass_kg: Some(device.mass.0),
            damping_n_s_per_m: Some(device.damping.0),
            delay_s: (delay > 0.0).then_some((delay, delay)),
            lag_s: (lag > 0.0).then_some(lag),
            noise_m: None,
        }
    }

    /// Facts that a board tells of its sensor: it rounds to its resolution.
    pub(crate) fn read_by(capabilities: &Capabilities) -> Self {
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
    pub(crate) fn or(self, other: Self) -> Self {
        Self {
            mass_kg: self.mass_kg.or(other.mass_kg),
            damping_n_s_per_m: self.damping_n_s_per_m.or(other.damping_n_s_per_m),
            delay_s: self.delay_s.or(other.delay_s),
            lag_s: self.lag_s.or(other.lag_s),
            noise_m: self.noise_m.or(other.noise_m),
        }
    }
}

impl GuardChoice {
    /// The guard for a device, if there is to be one.
    pub(crate) fn of(self, device: &GuardedDevice, t: Seconds) -> Result<Option<Guard>, Failure> {
        let unknown = |what, key: &dyn fmt::Display| {
            Failure::bad_input(format_args!(
                "guard {} needs to know the {what} of a real device: give {key}",
                self.name()
            ))
        };
        let known =
            |value: Option<f64>, what, key: Parameter| value.ok_or_else(|| unknown(what, &key));
        Ok(match self {
            Self::Off => None,
            Self::Observer => {
                let mass = known(device.mass_kg, "mass", DEVICE_MASS)?;
                Some(Guard::Observer(PassivityObserver::bearable(
                    Kilograms(mass),
                    t,
                )))
            }
            Self::EnergyBounding => {
                let damping = known(device.damping_n_s_per_m, "damping", DEVICE_DAMPING)?;
                let (least, most) = device.delay_s.ok_or_else(|| {
                    let both = format_args!("{DEVICE_DELAY_LEAST} and {DEVICE_DELAY_MOST}");
                    unknown("delay", &both)
                })?;
                let lag = known(device.lag_s, "lag", DEVICE_LAG)?;
                Some(Guard::EnergyBounding(EnergyBounding {
                    delay_least: Seconds(least),
                    delay_most: Seconds(most),
                    lag: Seconds(lag),
                    noise: Metres(device.noise_m.unwrap_or_default()),
                    ..EnergyBounding::of(NewtonSecondsPerMetre(damping))
                }))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_guard_says_what_it_has_to_know() {
        let t = Seconds(1e-3);
        let unknown = GuardedDevice::default();
        assert_eq!(GuardChoice::Off.of(&unknown, t).expect("off"), None);
        let damped = GuardedDevice {
            damping_n_s_per_m: Some(3.5),
            ..unknown
        };
        let late = GuardedDevice {
            delay_s: Some((0.0, 1e-3)),
            ..damped
        };
        for (guard, device, option) in [
            (GuardChoice::Observer, unknown, "device_mass_kg"),
            (
                GuardChoice::EnergyBounding,
                unknown,
                "device_damping_n_s_per_m",
            ),
            (GuardChoice::EnergyBounding, damped, "device_delay_least_s"),
            (GuardChoice::EnergyBounding, late, "device_lag_s"),
        ] {
            let error = guard.of(&device, t).expect_err("unknown").to_string();
            assert!(
                error.contains(option) && error.contains(guard.name()),
                "{error}"
            );
        }
    }

    #[test]
    fn what_somebody_says_of_a_device_goes_before_what_it_simulates() {
        use crate::run::remote::guard_of;
        use haptic_link::Simulation;
        let t = Seconds(1e-3);
        let said = GuardedDevice {
            damping_n_s_per_m: Some(2.0),
            delay_s: Some((0.0, 1e-3)),
            lag_s: Some(5e-4),
            ..GuardedDevice::default()
        };
        let bounding =
            |known, simulation| match guard_of(GuardChoice::EnergyBounding, known, simulation, t)
                .expect("known")
            {
                Some(Guard::EnergyBounding(bounding)) => {
                    let delay = (bounding.delay_least.0, bounding.delay_most.0);
                    (bounding.device_damping.0, delay, bounding.lag.0)
                }
                other => panic!("{other:?}"),
            };
        let nothing = GuardedDevice::default();
        let ideal = (3.5, (0.0, 0.0), 0.0);
        assert_eq!(bounding(nothing, &Simulation::TESTBED), ideal);
        let worse = (2.0, (0.0, 1e-3), 5e-4);
        assert_eq!(bounding(said, &Simulation::TESTBED), worse);
        assert_eq!(bounding(said, &Simulation::REAL), worse);
        assert!(guard_of(GuardChoice::EnergyBounding, nothing, &Simulation::REAL, t).is_err());
    }
}
