//! Units of columns.

/// A kind of quantity, by its SI unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dimension {
    Time,
    Pressure,
    PerPressure,
    Ratio,
    Force,
    Length,
    AngularFrequency,
    Angle,
    Temperature,
}

const TURN: f64 = 2.0 * core::f64::consts::PI;
const DEGREE: f64 = core::f64::consts::PI / 180.0;
/// Of a mass that stands for a force, m/s².
const STANDARD_GRAVITY: f64 = 9.806_65;

impl Dimension {
    /// Spellings of units with what they are in SI, the SI unit first.
    fn units(self) -> Units {
        let found = UNITS.iter().find(|known| known.0 == self);
        found.map_or(&[], |known| known.1)
    }

    /// True of a unit of anything that machines measure, in its own capitals.
    pub(super) fn knows(unit: &str) -> bool {
        const OTHERS: [&str; 16] = [
            "N.m", "Nm", "mN.m", "uN.m", "mNm", "uNm", "g.cm", "Pa.s", "mPa.s", "V", "mV", "A",
            "W", "1/K", "N.m/rad", "mm/s",
        ];
        let plain = plain(unit);
        let is_it = |known: &(&str, f64)| !known.0.is_empty() && known.0 == plain;
        OTHERS.contains(&plain.as_str()) || UNITS.iter().any(|units| units.1.iter().any(is_it))
    }

    pub(super) fn si(self) -> &'static str {
        self.units().first().map_or("", |unit| unit.0)
    }

    pub(super) fn names(self) -> String {
        let units = self.units().iter().map(|unit| unit.0);
        units
            .filter(|unit| !unit.is_empty())
            .collect::<Vec<_>>()
            .join(", ")
    }

    /// How many SI units a unit is; capitals count only where they must, as in `MPa` and `mPa`.
    pub(super) fn factor(self, unit: &str) -> Option<f64> {
        let plain = plain(unit);
        let exact = self.units().iter().find(|known| known.0 == plain);
        let alike = || {
            self.units()
                .iter()
                .find(|known| known.0.eq_ignore_ascii_case(&plain))
        };
        exact.or_else(alike).map(|known| known.1)
    }

    /// The same of the end of a name like `modulus_kpa`, where all is lower case.
    pub(super) fn factor_of_suffix(self, suffix: &str) -> Option<f64> {
        let unit = match suffix {
            "rad_s" | "rad_per_s" => "rad/s".to_owned(),
            "mpa" => "MPa".to_owned(),
            "per_mpa" => "1/MPa".to_owned(),
            _ => suffix
                .strip_prefix("per_")
                .map_or_else(|| suffix.to_owned(), |unit| format!("1/{unit}")),
        };
        (!unit.is_empty()).then(|| self.factor(&unit)).flatten()
    }
}

type Units = &'static [(&'static str, f64)];

const UNITS: &[(Dimension, Units)] = &[
    (
        Dimension::Time,
        &[
            ("s", 1.0),
            ("sec", 1.0),
            ("secs", 1.0),
            ("second", 1.0),
            ("seconds", 1.0),
            ("ms", 1e-3),
            ("us", 1e-6),
            ("min", 60.0),
            ("minutes", 60.0),
            ("h", 3600.0),
            ("hours", 3600.0),
        ],
    ),
    (
        Dimension::Pressure,
        &[
            ("Pa", 1.0),
            ("kPa", 1e3),
            ("MPa", 1e6),
            ("GPa", 1e9),
            ("mPa", 1e-3),
            ("N/m2", 1.0),
            ("N/mm2", 1e6),
            ("dyn/cm2", 0.1),
            ("dyne/cm2", 0.1),
            ("psi", 6_894.757_293_168),
        ],
    ),
    (
        Dimension::PerPressure,
        &[
            ("1/Pa", 1.0),
            ("1/kPa", 1e-3),
            ("1/MPa", 1e-6),
            ("1/GPa", 1e-9),
            ("Pa-1", 1.0),
            ("kPa-1", 1e-3),
            ("MPa-1", 1e-6),
            ("GPa-1", 1e-9),
        ],
    ),
    (
        Dimension::Ratio,
        &[
            ("1", 1.0),
            ("%", 1e-2),
            ("", 1.0),
            ("-", 1.0),
            ("m/m", 1.0),
            ("mm/mm", 1.0),
            ("percent", 1e-2),
        ],
    ),
    (
        Dimension::Force,
        &[
            ("N", 1.0),
            ("mN", 1e-3),
            ("kN", 1e3),
            ("uN", 1e-6),
            ("nN", 1e-9),
            ("pN", 1e-12),
            // Scales and texture analysers write the mass that weighs so much.
            ("g", STANDARD_GRAVITY * 1e-3),
            ("gf", STANDARD_GRAVITY * 1e-3),
            ("kg", STANDARD_GRAVITY),
            ("kgf", STANDARD_GRAVITY),
            ("lbf", 4.448_221_615_260_5),
        ],
    ),
    (
        Dimension::Length,
        &[
            ("m", 1.0),
            ("mm", 1e-3),
            ("um", 1e-6),
            ("cm", 1e-2),
            ("nm", 1e-9),
            ("pm", 1e-12),
            ("micron", 1e-6),
            ("in", 25.4e-3),
        ],
    ),
    (
        Dimension::AngularFrequency,
        &[
            ("rad/s", 1.0),
            ("Hz", TURN),
            ("1/s", 1.0),
            ("s-1", 1.0),
            ("rad s-1", 1.0),
            ("rad/sec", 1.0),
            ("mHz", 1e-3 * TURN),
            ("kHz", 1e3 * TURN),
        ],
    ),
    (
        Dimension::Angle,
        &[
            ("rad", 1.0),
            ("°", DEGREE),
            ("deg", DEGREE),
            ("degree", DEGREE),
            ("degrees", DEGREE),
            ("mrad", 1e-3),
        ],
    ),
    (
        Dimension::Temperature,
        &[
            ("°C", 1.0),
            ("C", 1.0),
            ("degC", 1.0),
            ("℃", 1.0),
            ("K", 1.0),
            ("°F", 5.0 / 9.0),
        ],
    ),
];

/// A temperature of this unit in °C, as which it counts without a unit.
pub(super) fn celsius(value: f64, unit: &str) -> f64 {
    match plain(unit).as_str() {
        "K" => value - 273.15,
        "°F" => (value - 32.0) * 5.0 / 9.0,
        _ => value,
    }
}

/// True of 1/s, which is Hz to some and rad/s to others.
pub(super) fn is_per_second(unit: &str) -> bool {
    matches!(plain(unit).as_str(), "1/s" | "s-1")
}

/// One spelling for `Pa⁻¹`, `Pa^-1` and `Pa**-1`, `µm` and `μm`, `mm²` and `mm^2`.
fn plain(unit: &str) -> String {
    unit.trim()
        .replace("⁻¹", "-1")
        .replace('²', "2")
        .replace(['^', '*'], "")
        .replace(['µ', 'μ'], "u")
        .replace('·', " ")
}
