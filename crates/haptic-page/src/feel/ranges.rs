//! Ranges of what can be set while a law is felt, once.

use fracdiff::parameter::Shown;
use haptic_experiment::Failure;
use haptic_experiment::parameters;
use serde::Serialize;

/// Range, default and step of a number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NumberRange {
    /// Smallest.
    pub least: f64,
    /// Largest.
    pub most: f64,
    /// Where nothing is said of it.
    pub default: f64,
    /// A step of a slider.
    pub step: f64,
}

const fn range(least: f64, most: f64, default: f64, step: f64) -> NumberRange {
    NumberRange {
        least,
        most,
        default,
        step,
    }
}

/// μ. Default of a wall.
pub const ORDER: NumberRange = range(0.0, 1.0, 0.5, 0.001);
/// K, N/m. Default of a wall.
pub const STIFFNESS: NumberRange = range(0.0, 5000.0, 300.0, 1.0);
/// B, N·s^μ/m. Default of a wall.
pub const DISSIPATION: NumberRange = range(0.0, 2000.0, 10.0, 0.1);
/// Factor on K and B.
pub const SCALE: NumberRange = range(0.01, 100.0, 1.0, 0.01);
/// Mass of the device, kg.
pub const MASS: NumberRange = range(0.005, 2.0, parameters::MASS.default_number(), 0.001);
/// Damping of the device, N·s/m.
pub const DAMPING: NumberRange = range(0.0, 50.0, parameters::DAMPING.default_number(), 0.1);
/// Place of the pointer, m.
pub const HAND_M: NumberRange = range(-0.03, 0.03, 0.0, 1e-4);

/// All of them by name.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Ranges {
    order: NumberRange,
    stiffness_n_per_m: NumberRange,
    dissipation_n_s_mu_per_m: NumberRange,
    scale: NumberRange,
    mass_kg: NumberRange,
    damping_n_s_per_m: NumberRange,
    hand_m: NumberRange,
}

/// All of them.
const ALL: Ranges = Ranges {
    order: ORDER,
    stiffness_n_per_m: STIFFNESS,
    dissipation_n_s_mu_per_m: DISSIPATION,
    scale: SCALE,
    mass_kg: MASS,
    damping_n_s_per_m: DAMPING,
    hand_m: HAND_M,
};

/// All of them, with this mass, kg, and damping, N·s/m, as defaults.
pub(crate) const fn with_device(mass_kg: f64, damping_n_s_per_m: f64) -> Ranges {
    let mut ranges = ALL;
    ranges.mass_kg.default = mass_kg;
    ranges.damping_n_s_per_m.default = damping_n_s_per_m;
    ranges
}

impl NumberRange {
    /// The number, if it is in the range.
    ///
    /// # Errors
    /// If not, with name, value and range.
    pub fn checked(self, name: &str, value: f64) -> Result<f64, Failure> {
        let Self { least, most, .. } = self;
        if (least..=most).contains(&value) {
            return Ok(value);
        }
        Err(Failure::bad_input(format_args!(
            "`{name}` = {} is not in [{least}, {most}]: change it",
            Shown(value)
        )))
    }

    /// The number, or the end of the range that is nearest to it.
    #[must_use]
    pub const fn nearest(self, value: f64) -> f64 {
        value.clamp(self.least, self.most)
    }
}
