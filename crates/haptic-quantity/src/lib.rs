#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod key;
mod written;

pub use key::{Key, name_keys};
pub use written::{WrittenUnit, digits, label, written, written_between};

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

/// A turn, rad.
const TURN: f64 = 2.0 * PI;
/// A degree, rad.
const DEGREE: f64 = PI / 180.0;

/// A unit and how many SI units it is.
type Unit = (&'static str, f64);

/// A number with a unit, or without.
pub trait Quantity: Clone + Send + Sync + 'static {
    /// The SI unit; empty for a pure number.
    const UNIT: &'static str;

    /// The number in that unit.
    fn si(&self) -> f64;
}

impl Quantity for f64 {
    const UNIT: &'static str = "";

    fn si(&self) -> f64 {
        *self
    }
}

/// Reads a plain number.
///
/// # Errors
/// If it is none, or not finite.
pub fn parse_number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err("not a finite number".to_owned()),
    }
}

/// Declares a quantity, its SI unit first.
macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident, $what:literal, $units:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
        pub struct $name(pub f64);

        impl std::str::FromStr for $name {
            type Err = QuantityError;

            fn from_str(text: &str) -> Result<Self, QuantityError> {
                parse(text, $what, &$units).map(Self)
            }
        }

        impl Quantity for $name {
            const UNIT: &'static str = $units[0].0;

            fn si(&self) -> f64 {
                self.0
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{}{}", self.0, $units[0].0)
            }
        }
    };
}

quantity!(
    /// A duration, s.
    Time, "a time",
    [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("µs", 1e-6), ("min", 60.0), ("h", 3600.0)]
);
quantity!(
    /// A length, m.
    Length, "a length",
    [("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("um", 1e-6), ("µm", 1e-6), ("nm", 1e-9)]
);
quantity!(
    /// An area, m².
    Area, "an area",
    [("m2", 1.0), ("cm2", 1e-4), ("mm2", 1e-6), ("m²", 1.0), ("cm²", 1e-4), ("mm²", 1e-6)]
);
quantity!(
    /// A strain, 1.
    Strain, "a strain",
    [("", 1.0), ("%", 1e-2)]
);
quantity!(
    /// A force, N.
    Force, "a force",
    [("N", 1.0), ("mN", 1e-3), ("kN", 1e3)]
);
quantity!(
    /// A rate of change of force, N/s.
    ForceRate, "a rate of force",
    [("N/s", 1.0), ("N/ms", 1e3), ("kN/s", 1e3)]
);
quantity!(
    /// A stress, Pa.
    Stress, "a stress",
    [("Pa", 1.0), ("kPa", 1e3), ("MPa", 1e6)]
);

quantity!(
    /// A mass, kg.
    Mass, "a mass",
    [("kg", 1.0), ("g", 1e-3)]
);
quantity!(
    /// A stiffness, N/m.
    Stiffness, "a stiffness",
    [("N/m", 1.0), ("N/mm", 1e3), ("kN/m", 1e3)]
);
quantity!(
    /// A viscous damping, N·s/m.
    Damping, "a damping",
    [("N.s/m", 1.0), ("N·s/m", 1.0), ("Ns/m", 1.0), ("N.s/mm", 1e3), ("N·s/mm", 1e3), ("Ns/mm", 1e3)]
);
quantity!(
    /// A frequency, Hz.
    Frequency, "a frequency",
    [("Hz", 1.0), ("kHz", 1e3)]
);
quantity!(
    /// An angular frequency, rad/s.
    AngularFrequency, "an angular frequency",
    [("rad/s", 1.0), ("mrad/s", 1e-3), ("krad/s", 1e3), ("Hz", TURN), ("mHz", 1e-3 * TURN), ("kHz", 1e3 * TURN)]
);
quantity!(
    /// An angle, rad.
    Angle, "an angle",
    [("rad", 1.0), ("deg", DEGREE), ("°", DEGREE)]
);
quantity!(
    /// A speed, m/s.
    Speed, "a speed",
    [("m/s", 1.0), ("cm/s", 1e-2), ("mm/s", 1e-3)]
);

quantity!(
    /// A size of a file, bytes.
    Bytes, "a size",
    [("B", 1.0), ("kB", 1e3), ("MB", 1e6), ("GB", 1e9), ("TB", 1e12), ("MiB", 1_048_576.0), ("GiB", 1_073_741_824.0)]
);

quantity!(
    /// A number whose unit follows from an order, or that has none.
    Plain, "a number",
    [("", 1.0), ("%", 1e-2)]
);

quantity!(
    /// A dissipation: its unit follows from its order.
    Dissipation, "a plain number, whose unit N·s^μ/m follows from the order μ", [("", 1.0)]
);

/// Reads a text into SI units.
type Read = fn(&str) -> Result<f64, QuantityError>;

/// What the end of a key says, as in `stiffness_n_per_m`.
struct End {
    /// The end; empty for a key that says no unit.
    end: &'static str,
    /// What it is of, in a word.
    kind: &'static str,
    /// Reads a text for it.
    read: Read,
    /// The unit that is written, and how many of it the number is.
    unit: &'static str,
    per_unit: f64,
    /// Powers of ten that may stand before the unit, as 3 for k; none for 0 to 0.
    powers: (i32, i32),
}

const fn end(
    end: &'static str,
    kind: &'static str,
    read: Read,
    unit: &'static str,
    powers: (i32, i32),
) -> End {
    End {
        end,
        kind,
        read,
        unit,
        per_unit: 1.0,
        powers,
    }
}

const fn written_end(
    end: &'static str,
    unit: &'static str,
    per_unit: f64,
    powers: (i32, i32),
) -> End {
    End {
        end,
        kind: "NUMBER",
        read: si::<Plain>,
        unit,
        per_unit,
        powers,
    }
}

/// All ends of keys; one that ends another stands after it.
const ENDS: &[End] = &[
    end(
        "_n_s_1_minus_mu_per_m",
        "NUMBER",
        si::<Dissipation>,
        "N·s^(1−μ)/m",
        (0, 0),
    ),
    end(
        "_n_s_mu_per_m",
        "NUMBER",
        si::<Dissipation>,
        "N·s^μ/m",
        (0, 0),
    ),
    end("_n_s_per_m", "DAMPING", si::<Damping>, "N·s/m", (0, 0)),
    end("_n_per_m", "STIFFNESS", si::<Stiffness>, "N/m", (0, 6)),
    end("_n_per_s", "RATE", si::<ForceRate>, "N/s", (0, 6)),
    end("_m_per_s", "SPEED", si::<Speed>, "m/s", (-6, 0)),
    end(
        "_rad_s",
        "FREQUENCY",
        si::<AngularFrequency>,
        "rad/s",
        (0, 0),
    ),
    end("_rad", "ANGLE", si::<Angle>, "rad", (0, 0)),
    end("_hz", "FREQUENCY", si::<Frequency>, "Hz", (-3, 6)),
    end("_pa", "STRESS", si::<Stress>, "Pa", (0, 9)),
    End {
        per_unit: 1e3,
        ..end("_kg", "MASS", si::<Mass>, "g", (-3, 3))
    },
    end("_m2", "AREA", si::<Area>, "m²", (0, 0)),
    end("_m", "LENGTH", si::<Length>, "m", (-9, 0)),
    end("_n", "FORCE", si::<Force>, "N", (-9, 3)),
    end("_s", "TIME", si::<Time>, "s", (-9, 0)),
    written_end("_ms", "s", 1e-3, (-9, 0)),
    written_end("_us", "s", 1e-6, (-9, 0)),
    written_end("_ns", "s", 1e-9, (-9, 0)),
    written_end("_j", "J", 1.0, (-9, 3)),
    written_end("_db", "dB", 1.0, (0, 0)),
    written_end("_deg", "°", 1.0, (0, 0)),
    written_end("_degrees", "°", 1.0, (0, 0)),
    written_end("_bytes", "B", 1.0, (0, 9)),
    written_end("", "", 1.0, (0, 0)),
];

fn si<Q: Quantity + FromStr<Err = QuantityError>>(text: &str) -> Result<f64, QuantityError> {
    text.parse().map(|quantity: Q| quantity.si())
}

/// A key without its unit, and what its end says.
fn parts_of_key(key: &str) -> (&str, &'static End) {
    let mut ends = ENDS.iter();
    let found = ends.find_map(|end| Some((key.strip_suffix(end.end)?, end)));
    found.unwrap_or((key, &ENDS[ENDS.len() - 1]))
}

/// A key without its unit: of `stiffness_n_per_m` `stiffness`.
#[must_use]
pub fn without_unit(key: &str) -> &str {
    parts_of_key(key).0
}

/// True if a person means this key: with its unit or without, with `-` or `_`.
#[must_use]
pub fn is_meant(key: &str, written: &str) -> bool {
    let written = written.trim().replace('-', "_");
    key == written || without_unit(key) == written
}

/// What a key is of, in a word: of `sample_time_s` `TIME`; `NUMBER` where it says no unit.
#[must_use]
pub fn kind_of_key(key: &str) -> &'static str {
    parts_of_key(key).1.kind
}

/// Reads a number for a key, in the SI unit that the key says: `5kN/m` for `stiffness_n_per_m` is 5000.
///
/// # Errors
/// Text that is no finite number, or has another unit.
pub fn parse_for_key(key: &str, text: &str) -> Result<f64, QuantityError> {
    (parts_of_key(key).1.read)(text)
}

/// Text that is no quantity of the kind asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct QuantityError {
    text: String,
    what: &'static str,
    units: Vec<&'static str>,
}

impl fmt::Display for QuantityError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = self.units.iter().filter(|unit| !unit.is_empty());
        let units: Vec<&str> = named.copied().collect();
        write!(
            f,
            "\"{}\" is not {}: give a finite number",
            self.text, self.what
        )?;
        match units.is_empty() {
            true => f.write_str(" alone"),
            false => write!(
                f,
                ", with one of the units {} or none for SI",
                units.join(", ")
            ),
        }
    }
}

impl std::error::Error for QuantityError {}

/// Reads a number and a unit, with or without a space between. The unit is what no number contains
/// at its end: `1e-3m` is a millimetre.
fn parse(text: &str, what: &'static str, units: &[Unit]) -> Result<f64, QuantityError> {
    let trimmed = text.trim();
    let value = units
        .iter()
        // "5" is a number with the unit "" or none; a suffix must leave a number behind.
        .chain(&[("", 1.0)])
        .filter_map(|(unit, factor)| {
            let number = trimmed.strip_suffix(unit)?.trim_end();
            // Rust also reads "inf" and "nan".
            let value: f64 = number.parse().ok()?;
            Some(scale(value, *factor)).filter(|value| value.is_finite())
        })
        .next();
    value.ok_or_else(|| QuantityError {
        text: text.to_owned(),
        what,
        units: units.iter().map(|(unit, _)| *unit).collect(),
    })
}

/// value·factor, by division where one SI unit is a whole number of these: 20 mm is 20/1000 m, the double nearest to 0.02.
fn scale(value: f64, factor: f64) -> f64 {
    let inverse = (1.0 / factor).round();
    if factor < 1.0 && (inverse * factor - 1.0).abs() < 1e-12 {
        value / inverse
    } else {
        value * factor
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "decimal input has one nearest double")]
mod tests {
    use super::*;

    fn read<Q: std::str::FromStr<Err = QuantityError>>(text: &str) -> Result<Q, QuantityError> {
        text.parse()
    }

    #[test]
    fn units_scale_to_si_and_none_means_si() {
        assert_eq!(read::<Time>("200s").expect("valid").0, 200.0);
        assert_eq!(read::<Time>("1ms").expect("valid").0, 1e-3);
        assert_eq!(read::<Time>("0.001").expect("valid").0, 1e-3);
        assert_eq!(read::<Time>(" 2 min ").expect("valid").0, 120.0);
        assert_eq!(read::<Time>("100us").expect("valid").0, 1e-4);
        assert_eq!(read::<Length>("20mm").expect("valid").0, 0.02);
        assert_eq!(read::<Length>("1e-3m").expect("valid").0, 1e-3);
        assert_eq!(read::<Area>("4cm2").expect("valid").0, 4e-4);
        assert_eq!(read::<Area>("4 cm²").expect("valid").0, 4e-4);
        assert_eq!(read::<Strain>("5%").expect("valid").0, 0.05);
        assert_eq!(read::<Strain>("0.05").expect("valid").0, 0.05);
        assert_eq!(read::<Force>("250 mN").expect("valid").0, 0.25);
        assert_eq!(read::<ForceRate>("1N/ms").expect("valid").0, 1000.0);
        assert_eq!(read::<Stress>("0.1kPa").expect("valid").0, 100.0);
        assert_eq!(read::<Angle>("1deg").expect("valid").0, 1_f64.to_radians());
        assert_eq!(read::<Angle>("65 °").expect("valid").0, 65_f64.to_radians());
        assert_eq!(read::<Angle>("1.2").expect("valid").0, 1.2);
        assert_eq!(
            read::<AngularFrequency>("10Hz").expect("valid").0,
            10.0 * TURN
        );
        assert_eq!(read::<AngularFrequency>("5mrad/s").expect("valid").0, 0.005);
    }

    #[test]
    fn a_key_says_its_unit() {
        for (key, stem, kind, text, si) in [
            ("stiffness_n_per_m", "stiffness", "STIFFNESS", "5kN/m", 5e3),
            ("damping_n_s_per_m", "damping", "DAMPING", "2N.s/m", 2.0),
            (
                "dissipation_n_s_mu_per_m",
                "dissipation",
                "NUMBER",
                "60",
                60.0,
            ),
            (
                "force_rate_limit_n_per_s",
                "force_rate_limit",
                "RATE",
                "1N/ms",
                1e3,
            ),
            ("area_m2", "area", "AREA", "4cm2", 4e-4),
            ("low_rad_s", "low", "FREQUENCY", "3", 3.0),
            ("sample_time_s", "sample_time", "TIME", "1ms", 1e-3),
            ("strain", "strain", "NUMBER", "5%", 0.05),
        ] {
            assert_eq!((without_unit(key), kind_of_key(key)), (stem, kind), "{key}");
            assert_eq!(parse_for_key(key, text), Ok(si), "{key} = {text}");
            let dashed = stem.replace('_', "-");
            let meant = [key, stem, dashed.as_str(), "other"].map(|name| is_meant(key, name));
            assert_eq!(meant, [true, true, true, false], "{key}");
        }
        let error = parse_for_key("mass_kg", "3m")
            .expect_err("a length")
            .to_string();
        assert!(error.contains("is not a mass"), "{error}");
    }

    #[test]
    fn what_is_no_finite_number_or_has_another_unit_is_refused() {
        for bad in [
            "", "s", "NaN", "inf", "-infs", "1e999", "5 %", "5m", "1 2s", "1,5s", "--",
        ] {
            let error = read::<Time>(bad).expect_err(bad).to_string();
            assert!(
                error.contains("is not a time") && error.contains("ms"),
                "{error}"
            );
        }
    }
}
