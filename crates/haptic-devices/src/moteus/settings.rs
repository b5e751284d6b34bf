//! A servo by name: its settings in one table, with their ranges.

use crate::name::{NameError, Settings, quantity};
use std::fmt;

/// A servo that turns a capstan or a lever, as one axis in metres and newtons.
///
/// ```text
/// x = 2π·r·(p − p₀),   τ = r·f        p in revolutions, p₀ the place at which it was opened
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MoteusSettings {
    /// Number of the servo on its bus, 1 to 126.
    pub id: u8,
    /// r, m, in [0.001, 1] in size. A negative r reverses the direction.
    pub radius_m: f64,
    /// Largest torque that is ever asked of the servo, N·m, in [0.0001, 20].
    pub torque_limit_nm: f64,
    /// Silence of this program after which the servo lets go on its own, s, in [0.01, 1].
    pub watchdog_s: f64,
    /// Number of ticks in a row without an answer that causes a fault in a run, 2 to 1000; at rest 2 s do.
    pub lost_most: u32,
}

/// A setting: its key in a name, its unit, and its range.
struct Setting {
    key: &'static str,
    unit: &'static str,
    least: f64,
    most: f64,
}

/// Settings in the order of [`MoteusSettings::values`].
const SETTINGS: [Setting; 5] = [
    setting("id", "", 1.0, 126.0),
    setting("radius", "m", 1e-3, 1.0),
    setting("torque_limit", "", 1e-4, 20.0),
    setting("watchdog", "s", 0.01, 1.0),
    setting("lost", "", 2.0, 1000.0),
];

const fn setting(key: &'static str, unit: &'static str, least: f64, most: f64) -> Setting {
    Setting {
        key,
        unit,
        least,
        most,
    }
}

impl Setting {
    /// True of a value in its range; a length may be the negative of it, a number of servos or answers is whole.
    fn fits(&self, value: f64) -> bool {
        let either_way = if self.unit == "m" { value.abs() } else { value };
        let is_whole = !["id", "lost"].contains(&self.key) || value.fract() == 0.0;
        (self.least..=self.most).contains(&either_way) && is_whole
    }

    fn refused(&self, value: &str) -> NameError {
        NameError::Number {
            key: self.key,
            value: value.to_owned(),
            least: self.least,
            most: self.most,
            unit: match self.unit {
                "m" => " m, or the negative of it",
                "s" => " s",
                _ => "",
            },
        }
    }
}

impl MoteusSettings {
    /// A servo as delivered, with a capstan of 20 mm; 0.1 N·m are 5 N there, which is harmless to a
    /// hand.
    pub const DEFAULT: Self = Self {
        id: 1,
        radius_m: 0.02,
        torque_limit_nm: 0.1,
        watchdog_s: 0.1,
        lost_most: 4,
    };

    /// Metres per revolution; negative if the direction is reversed.
    #[must_use]
    pub fn metres_per_revolution(&self) -> f64 {
        core::f64::consts::TAU * self.radius_m
    }

    fn values(&self) -> [f64; 5] {
        let (id, lost_most) = (self.id.into(), self.lost_most.into());
        [
            id,
            self.radius_m,
            self.torque_limit_nm,
            self.watchdog_s,
            lost_most,
        ]
    }

    const fn of([id, radius_m, torque_limit_nm, watchdog_s, lost_most]: [f64; 5]) -> Self {
        Self {
            id: id as u8,
            radius_m,
            torque_limit_nm,
            watchdog_s,
            lost_most: lost_most as u32,
        }
    }

    pub(super) fn check(&self) -> Result<(), NameError> {
        let mut values = SETTINGS.iter().zip(self.values());
        let bad = values.find(|(setting, value)| !setting.fits(*value));
        bad.map_or(Ok(()), |(setting, value)| {
            Err(setting.refused(&value.to_string()))
        })
    }
}

/// A servo by name: `moteus:PATH[,key=value]…`, with the keys of [`MoteusSettings`].
#[derive(Clone, Debug, PartialEq)]
pub struct MoteusName {
    pub(super) path: String,
    pub(crate) settings: MoteusSettings,
}

impl MoteusName {
    /// First word of the name.
    pub const KIND: &'static str = "moteus";
    pub(crate) const FORM: &'static str =
        "moteus:PATH[,id=1][,radius=20mm][,torque_limit=0.1][,watchdog=100ms][,lost=4]";

    pub(crate) fn parse(text: &str) -> Result<Self, NameError> {
        let keys = SETTINGS.each_ref().map(|setting| setting.key);
        let given = Settings::parse(Self::KIND, text, &keys)?;
        let mut values = MoteusSettings::DEFAULT.values();
        for (setting, value) in SETTINGS.iter().zip(&mut values) {
            if let Some(text) = given.text(setting.key) {
                *value = quantity(setting.key, &format!("_{}", setting.unit), text)?;
                if !setting.fits(*value) {
                    return Err(setting.refused(text));
                }
            }
        }
        Ok(Self {
            path: given.path.to_owned(),
            settings: MoteusSettings::of(values),
        })
    }
}

impl fmt::Display for MoteusName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", Self::KIND, self.path)?;
        let values = (self.settings.values().into_iter()).zip(MoteusSettings::DEFAULT.values());
        for (Setting { key, unit, .. }, (value, default)) in SETTINGS.iter().zip(values) {
            if value.to_bits() != default.to_bits() {
                write!(f, ",{key}={value}{unit}")?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_says_port_and_settings() {
        let name = MoteusName::parse("/dev/ttyACM0").expect("good");
        assert_eq!(name.settings, MoteusSettings::DEFAULT);
        assert_eq!(name.to_string(), "moteus:/dev/ttyACM0");
        let text = "/dev/x,id=7,radius=-0.015m,torque_limit=0.5,watchdog=0.05s,lost=9";
        let name = MoteusName::parse(text).expect("good");
        let expected = MoteusSettings {
            id: 7,
            radius_m: -0.015,
            torque_limit_nm: 0.5,
            watchdog_s: 0.05,
            lost_most: 9,
        };
        assert_eq!(name.settings, expected);
        assert_eq!(name.to_string(), format!("moteus:{text}"));
        for (bad, message) in [
            (
                "",
                "moteus needs the path of a port, as in moteus:/dev/ttyACM0",
            ),
            (
                "/dev/x,radius=3m",
                "radius = \"3m\" is not in [0.001, 1] m, or the negative of it",
            ),
            (
                "/dev/x,radius=-0.5mm",
                "radius = \"-0.5mm\" is not in [0.001, 1] m, or the negative of it",
            ),
            (
                "/dev/x,radius=0",
                "radius = \"0\" is not in [0.001, 1] m, or the negative of it",
            ),
            ("/dev/x,id=0", "id = \"0\" is not in [1, 126]"),
            ("/dev/x,id=127", "id = \"127\" is not in [1, 126]"),
            ("/dev/x,id=1.5", "id = \"1.5\" is not in [1, 126]"),
            ("/dev/x,lost=1", "lost = \"1\" is not in [2, 1000]"),
            (
                "/dev/x,watchdog=5mm",
                "watchdog: \"5mm\" is a length, not a time: give a finite number, with one of the units s, ms, us, µs, min, h or none for SI",
            ),
            (
                "/dev/x,torque_limit=inf",
                "torque_limit: \"inf\" is not a number: give a finite number, with one of the units % or none for SI",
            ),
            (
                "/dev/x,watchdog=5s",
                "watchdog = \"5s\" is not in [0.01, 1] s",
            ),
        ] {
            let error = MoteusName::parse(bad).expect_err(bad);
            assert_eq!(error.to_string(), message);
        }
        MoteusName::parse("/dev/x,servo=1").expect_err("no such key");
        let centimetres = MoteusName::parse("/dev/x,radius=2cm,watchdog=50 ms").expect("good");
        assert_eq!(centimetres.settings.radius_m.to_bits(), 0.02_f64.to_bits());
        let radius_m = f64::NAN;
        let bad = MoteusSettings {
            radius_m,
            ..expected
        };
        let error = bad.check().expect_err("not a number").to_string();
        assert!(error.starts_with("radius = \"NaN\""), "{error}");
    }
}
