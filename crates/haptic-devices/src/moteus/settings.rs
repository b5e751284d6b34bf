//! Settings of a servo as an axis, each with its range.

use core::ops::RangeInclusive;
use haptic_loop::{ParameterError, RangeError};

/// A servo that turns a capstan or a lever, as one axis in metres and newtons.
///
/// ```text
/// x = 2π·r·(p − p₀),   τ = r·f        p in revolutions, p₀ the place at which it was opened
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MoteusSettings {
    /// Number of the servo on its bus.
    pub id: u8,
    /// r, m. A negative one turns the direction round.
    pub radius_m: f64,
    /// Largest torque that is ever asked of the servo, N·m.
    pub torque_limit_nm: f64,
    /// Silence of this program after which the servo lets go by itself, s.
    pub watchdog_s: f64,
    /// Ticks in a row without an answer that are a fault.
    pub lost_most: u32,
}

impl MoteusSettings {
    /// A servo as it is delivered, with a capstan of 20 mm; 0.1 N·m are 5 N there, which no hand minds.
    pub const DEFAULT: Self = Self {
        id: 1,
        radius_m: 0.02,
        torque_limit_nm: 0.1,
        watchdog_s: 0.1,
        lost_most: 4,
    };

    /// Range of the number on the bus.
    pub const ID: RangeInclusive<u32> = 1..=126;
    /// Range of the radius, m; not within [`RADIUS_LEAST_M`](Self::RADIUS_LEAST_M) of 0.
    pub const RADIUS_M: RangeInclusive<f64> = -1.0..=1.0;
    /// Range of the torque limit, N·m.
    pub const TORQUE_LIMIT_NM: RangeInclusive<f64> = 1e-4..=20.0;
    /// Range of the servo's watchdog, s.
    pub const WATCHDOG_S: RangeInclusive<f64> = 0.01..=1.0;
    /// Range of lost answers in a row.
    pub const LOST_MOST: RangeInclusive<u32> = 2..=1000;
    /// Least radius either way, m.
    pub const RADIUS_LEAST_M: f64 = 1e-3;

    /// Largest force at the radius, N.
    #[must_use]
    pub fn force_max_n(&self) -> f64 {
        self.torque_limit_nm / self.radius_m.abs()
    }

    /// Metres in a revolution; negative where the direction is turned round.
    #[must_use]
    pub fn metres_per_revolution(&self) -> f64 {
        core::f64::consts::TAU * self.radius_m
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// The first value outside its range.
    pub fn check(&self) -> Result<(), ParameterError> {
        let number =
            |range: RangeInclusive<u32>| f64::from(*range.start())..=f64::from(*range.end());
        let radius = Self::RADIUS_LEAST_M..=*Self::RADIUS_M.end();
        all_within([
            (
                "servo id",
                f64::from(self.id),
                number(Self::ID),
                "in [1, 126]",
                "",
            ),
            (
                "radius",
                self.radius_m.abs(),
                radius,
                "in [0.001, 1], or the negative of it",
                "m",
            ),
            (
                "torque limit",
                self.torque_limit_nm,
                Self::TORQUE_LIMIT_NM,
                "in [0.0001, 20]",
                "N·m",
            ),
            (
                "watchdog of the servo",
                self.watchdog_s,
                Self::WATCHDOG_S,
                "in [0.01, 1]",
                "s",
            ),
            (
                "number of lost answers",
                f64::from(self.lost_most),
                number(Self::LOST_MOST),
                "in [2, 1000]",
                "",
            ),
        ])
    }
}

/// Name of a value, the value and its range; the range in words, and the unit.
pub(super) type Ranged = (
    &'static str,
    f64,
    RangeInclusive<f64>,
    &'static str,
    &'static str,
);

/// Refuses the first value outside its range.
pub(super) fn all_within<const N: usize>(values: [Ranged; N]) -> Result<(), ParameterError> {
    for (what, value, range, allowed, unit) in values {
        if !range.contains(&value) {
            return Err(RangeError::new(what, value, allowed, unit).into());
        }
    }
    Ok(())
}

impl Default for MoteusSettings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

#[cfg(test)]
mod tests {
    use super::MoteusSettings;

    #[test]
    fn a_value_outside_its_range_is_named() {
        MoteusSettings::DEFAULT
            .check()
            .expect("the default is good");
        let default = MoteusSettings::DEFAULT;
        let bad = [
            (MoteusSettings { id: 0, ..default }, "servo id 0"),
            (MoteusSettings { id: 127, ..default }, "servo id 127"),
            (
                MoteusSettings {
                    radius_m: 0.0,
                    ..default
                },
                "radius 0 m",
            ),
            (
                MoteusSettings {
                    radius_m: f64::NAN,
                    ..default
                },
                "radius NaN",
            ),
            (
                MoteusSettings {
                    torque_limit_nm: f64::INFINITY,
                    ..default
                },
                "torque limit inf",
            ),
            (
                MoteusSettings {
                    watchdog_s: 5.0,
                    ..default
                },
                "watchdog of the servo 5 s",
            ),
            (
                MoteusSettings {
                    lost_most: 1,
                    ..default
                },
                "number of lost answers 1",
            ),
        ];
        for (settings, words) in bad {
            let error = settings.check().expect_err(words).to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
