#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod key;
mod number;
mod written;

pub use key::{Key, did_you_mean, nearest, renamed, short};
pub use number::{DecimalSign, number, number_with, sign_of};
pub use written::{WrittenUnit, digits, in_five_digits, label, written, written_between};

use std::{f64::consts::PI, fmt};

const TURN: f64 = 2.0 * PI;
const DEGREE: f64 = PI / 180.0;

/// A unit and its factor to SI.
type Unit = (&'static str, f64);
/// Kind of quantity, as a sentence names it, and its units, the SI unit first.
type Quantity = (&'static str, &'static [Unit]);

#[rustfmt::skip]
const TIME: Quantity = ("a time",
    &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("µs", 1e-6), ("min", 60.0), ("h", 3600.0)]);
#[rustfmt::skip]
const LENGTH: Quantity = ("a length",
    &[("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("um", 1e-6), ("µm", 1e-6), ("nm", 1e-9)]);
#[rustfmt::skip]
const AREA: Quantity = ("an area",
    &[("m2", 1.0), ("cm2", 1e-4), ("mm2", 1e-6), ("m²", 1.0), ("cm²", 1e-4), ("mm²", 1e-6)]);
const FORCE: Quantity = ("a force", &[("N", 1.0), ("mN", 1e-3), ("kN", 1e3)]);
const FORCE_RATE: Quantity = (
    "a rate of force",
    &[("N/s", 1.0), ("N/ms", 1e3), ("kN/s", 1e3)],
);
const STRESS: Quantity = ("a stress", &[("Pa", 1.0), ("kPa", 1e3), ("MPa", 1e6)]);
const MASS: Quantity = ("a mass", &[("kg", 1.0), ("g", 1e-3)]);
const STIFFNESS: Quantity = ("a stiffness", &[("N/m", 1.0), ("N/mm", 1e3), ("kN/m", 1e3)]);
#[rustfmt::skip]
const DAMPING: Quantity = ("a damping",
    &[("N.s/m", 1.0), ("N·s/m", 1.0), ("Ns/m", 1.0), ("N.s/mm", 1e3), ("N·s/mm", 1e3), ("Ns/mm", 1e3)]);
const FREQUENCY: Quantity = ("a frequency", &[("Hz", 1.0), ("kHz", 1e3)]);
#[rustfmt::skip]
const ANGULAR_FREQUENCY: Quantity = ("an angular frequency",
    &[("rad/s", 1.0), ("mrad/s", 1e-3), ("krad/s", 1e3), ("Hz", TURN), ("mHz", 1e-3 * TURN), ("kHz", 1e3 * TURN)]);
const ANGLE: Quantity = ("an angle", &[("rad", 1.0), ("deg", DEGREE), ("°", DEGREE)]);
#[rustfmt::skip]
const DEGREES: Quantity = ("an angle", &[("deg", 1.0), ("°", 1.0), ("rad", 1.0 / DEGREE)]);
const SPEED: Quantity = ("a speed", &[("m/s", 1.0), ("cm/s", 1e-2), ("mm/s", 1e-3)]);
const ACCELERATION: Quantity = (
    "an acceleration",
    &[
        ("m/s²", 1.0),
        ("m/s^2", 1.0),
        ("m/s2", 1.0),
        ("mm/s²", 1e-3),
        ("mm/s^2", 1e-3),
    ],
);
#[rustfmt::skip]
const SIZE: Quantity = ("a size",
    &[("B", 1.0), ("kB", 1e3), ("MB", 1e6), ("GB", 1e9), ("TB", 1e12), ("MiB", 1_048_576.0), ("GiB", 1_073_741_824.0)]);
/// A number whose unit follows from an order, or that has none.
const NUMBER: Quantity = ("a number", &[("", 1.0), ("%", 1e-2)]);
const DISSIPATION: Quantity = (
    "a plain number, whose unit N·s^μ/m follows from the order μ",
    &[("", 1.0)],
);
const GAIN: Quantity = ("a gain as a plain number", &[("", 1.0)]);

/// Suffix of a key, as in `stiffness_n_per_m`, and its meaning.
struct End {
    /// The end; empty for a key that says no unit.
    end: &'static str,
    /// Kind of the number, in a word.
    kind: &'static str,
    /// Quantity of a text for it.
    quantity: &'static Quantity,
    /// The unit that is written, and how many of it the number is.
    unit: &'static str,
    per_unit: f64,
    /// Powers of ten that may stand before the unit, as 3 for k; 0 to 0 for no prefix.
    powers: (i32, i32),
}

const fn end(
    end: &'static str,
    kind: &'static str,
    quantity: &'static Quantity,
    unit: &'static str,
    powers: (i32, i32),
) -> End {
    End {
        end,
        kind,
        quantity,
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
        quantity: &NUMBER,
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
        &DISSIPATION,
        "N·s^(1−μ)/m",
        (0, 0),
    ),
    end("_n_s_mu_per_m", "NUMBER", &DISSIPATION, "N·s^μ/m", (0, 0)),
    end("_per_s_lambda", "NUMBER", &GAIN, "s^−λ", (0, 0)),
    end("_per_s_1_over_n", "NUMBER", &GAIN, "s^(−1/n)", (0, 0)),
    end("_s_mu", "NUMBER", &GAIN, "s^μ", (0, 0)),
    end("_n_s_per_m", "DAMPING", &DAMPING, "N·s/m", (0, 0)),
    end("_n_per_m", "STIFFNESS", &STIFFNESS, "N/m", (0, 6)),
    end("_n_per_s", "RATE", &FORCE_RATE, "N/s", (0, 6)),
    end("_m_per_s2", "ACCELERATION", &ACCELERATION, "m/s²", (-3, 0)),
    end("_m_per_s", "SPEED", &SPEED, "m/s", (-6, 0)),
    end("_per_s", "NUMBER", &GAIN, "1/s", (0, 0)),
    end("_rad_s", "FREQUENCY", &ANGULAR_FREQUENCY, "rad/s", (0, 0)),
    end("_rad", "ANGLE", &ANGLE, "rad", (0, 0)),
    end("_hz", "FREQUENCY", &FREQUENCY, "Hz", (-3, 6)),
    written_end("_per_pa", "Pa⁻¹", 1.0, (0, 0)),
    end("_pa", "STRESS", &STRESS, "Pa", (0, 9)),
    End {
        per_unit: 1e3,
        ..end("_kg", "MASS", &MASS, "g", (-3, 3))
    },
    end("_m2", "AREA", &AREA, "m²", (0, 0)),
    end("_m", "LENGTH", &LENGTH, "m", (-9, 0)),
    end("_n", "FORCE", &FORCE, "N", (-9, 3)),
    end("_s", "TIME", &TIME, "s", (-9, 0)),
    written_end("_ms", "s", 1e-3, (-9, 0)),
    written_end("_us", "s", 1e-6, (-9, 0)),
    written_end("_ns", "s", 1e-9, (-9, 0)),
    written_end("_j", "J", 1.0, (-9, 3)),
    written_end("_db", "dB", 1.0, (0, 0)),
    end("_deg", "ANGLE", &DEGREES, "°", (0, 0)),
    written_end("_degrees", "°", 1.0, (0, 0)),
    end("_bytes", "SIZE", &SIZE, "B", (0, 9)),
    written_end("", "", 1.0, (0, 0)),
];

/// A body's m in m·D^α v: its end is that of a dissipation, its unit one power of time more.
const INERTANCE: &str = "body_inertance";
static OF_INERTANCE: End = end("", "NUMBER", &DISSIPATION, "N·s^(1+α)/m", (0, 0));

/// A key without its unit, and what its end says; that of a topic, as `/grip_n`, says nothing: somebody else named it.
fn parts_of_key(key: &str) -> (&str, &'static End) {
    let mut ends = ENDS.iter();
    let found = ends.find_map(|end| Some((key.strip_suffix(end.end)?, end)));
    let found = found.filter(|_| !key.starts_with('/'));
    match found {
        Some((INERTANCE, _)) => (INERTANCE, &OF_INERTANCE),
        found => found.unwrap_or((key, &ENDS[ENDS.len() - 1])),
    }
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

/// Kind of a key's number, in a word: of `sample_time_s` `TIME`; `NUMBER` for a key without unit.
#[must_use]
pub fn kind_of_key(key: &str) -> &'static str {
    parts_of_key(key).1.kind
}

/// Longest text of a quantity, characters. To guess what is meant takes as long as the square of its length.
const LONGEST: usize = 64;

/// Reads a number for a key, in the SI unit that the key says: `5kN/m` for `stiffness_n_per_m` is 5000. A space may stand
/// between number and unit; the unit is what no number contains at its end: `1e-3m` is a millimetre.
///
/// # Errors
/// Text that is not a finite number, has another unit, or more than 64 characters.
pub fn parse_for_key(key: &str, text: &str) -> Result<f64, QuantityError> {
    let &(what, units) = parts_of_key(key).1.quantity;
    let text = text.trim();
    let refused = |text: String, meant, units| QuantityError {
        text,
        meant,
        what,
        units,
    };
    if text.chars().nth(LONGEST).is_some() {
        return Err(refused(text.chars().take(20).collect(), None, None));
    }
    read(units, text).ok_or_else(|| refused(text.to_owned(), meant(units, text), Some(units)))
}

/// Kinds of keys or their names, numbers above which nobody means the SI unit who writes none, that unit, and the one that may be
/// meant.
const DOUBTFUL: [(&str, f64, &str, &str); 8] = [
    ("MASS", 5.0, "kg", "g"),
    ("ANGLE", 6.3, "rad", "deg"),
    ("AREA", 1.0, "m2", "mm2"),
    ("LENGTH", 1.0, "m", "mm"),
    ("sample_time", 0.1, "s", "ms"),
    // As 1000 Hz.
    ("sample_time", 0.1, "s", "us"),
    ("delay", 1.0, "s", "ms"),
    ("strain", 1.0, "", "%"),
];

/// No wall is softer: a bare number below is doubted.
const SOFTEST_N_PER_M: f64 = 10.0;

/// Refuses a number without a unit that no device has in the SI unit, but in another.
///
/// ```
/// use haptic_quantity::doubt;
///
/// let asked = "65 has no unit: write 65g, or 65kg if it is that";
/// assert_eq!(doubt("mass_kg", "65"), Err(asked.to_owned()));
/// assert_eq!(doubt("mass_kg", "0.065"), Ok(()));
/// ```
///
/// # Errors
/// Both readings, in a sentence.
pub fn doubt(key: &str, text: &str) -> Result<(), String> {
    let text = text.trim();
    let in_unit = |unit: &str| parse_for_key(key, &format!("{text}{unit}")).ok();
    let names = [kind_of_key(key), without_unit(key)];
    let is_soft = |number: f64| number > 0.0 && number < SOFTEST_N_PER_M;
    if without_unit(key) == "stiffness" && is_bare(text) && in_unit("").is_some_and(is_soft) {
        return Err(format!(
            "{text} has no unit: write {text}N/mm, or {text}N/m if it is that"
        ));
    }
    let mut doubtful = DOUBTFUL.iter().filter(|_| is_bare(text));
    let found = doubtful.find(|(name, most, si, other)| {
        let is_it = names.iter().any(|known| known.ends_with(name));
        let is_most = |unit: &str| in_unit(unit).is_some_and(|number| number.abs() <= *most);
        is_it && !is_most(si) && is_most(other)
    });
    match found {
        Some((.., "", other)) => Err(format!("{text} has no unit: write {text}{other}")),
        Some((.., si, other)) => Err(format!(
            "{text} has no unit: write {text}{other}, or {text}{si} if it is that"
        )),
        None => Ok(()),
    }
}

/// A number with one of these units, or with none for SI.
fn read(units: &[Unit], text: &str) -> Option<f64> {
    let text = text.trim().replace('*', "·").replace('μ', "µ");
    // "5" is a number with the unit "" or none; a suffix must leave a number behind.
    let mut all = units.iter().chain(&[("", 1.0)]);
    all.find_map(|(unit, factor)| {
        let number = text.strip_suffix(unit)?.trim_end();
        // A comma separates the values of a list, as it does in TOML; it never groups thousands.
        let value = number_with(number, DecimalSign::Point).filter(|_| !number.contains(','))?;
        Some(scale(value, *factor)).filter(|value| value.is_finite())
    })
}

/// Right spelling of a text that is not read: `2mins → 2min`, `4cm^2 → 4cm2`, `1/2 → 0.5`, `6dB → 1.995`, and
/// `1kHz → 1ms` where a time is asked.
fn meant(units: &[Unit], text: &str) -> Option<String> {
    otherwise_spelt(units, text).or_else(|| of_another_kind(units, text))
}

/// Spelling with a point for the comma, and the unit as it is read; of 1,234 both numbers that it may be.
fn otherwise_spelt(units: &[Unit], text: &str) -> Option<String> {
    let mut ends = (0..=text.len()).rev();
    let end = ends.find(|&end| text.get(..end).is_some_and(|text| number(text).is_some()))?;
    let (figures, unit) = (&text[..end], text[end..].trim());
    let unit = known_unit(units, unit).or(Some("").filter(|_| end == text.len()))?;
    let spelt = |sign| Some(format!("{}{unit}", number_with(figures, sign)?));
    let signs = match sign_of(figures) {
        Some(sign) => vec![sign],
        None if figures.contains(',') => vec![DecimalSign::Comma, DecimalSign::Point],
        None => vec![DecimalSign::Point],
    };
    let readings: Vec<String> = signs.into_iter().filter_map(spelt).collect();
    let comma = Some(", without a comma").filter(|_| figures.contains(','));
    let is_read = |text: &String| read(units, text).is_some();
    let all = readings.iter().all(is_read);
    all.then(|| format!("{}{}", readings.join(" or "), comma.unwrap_or_default()))
}

fn known_unit(units: &[Unit], written: &str) -> Option<&'static str> {
    let plain = written.to_lowercase().replace('^', "");
    let single = plain.strip_suffix('s').unwrap_or(&plain);
    let alike = |unit: &str| unit.eq_ignore_ascii_case(&plain) || unit.eq_ignore_ascii_case(single);
    let mut known = units.iter().map(|(unit, _)| *unit);
    known.find(|unit| !unit.is_empty() && alike(unit))
}

/// A quotient or decibels where a number is asked, a rate where a time is.
fn of_another_kind(units: &[Unit], text: &str) -> Option<String> {
    if units == TIME.1 {
        let rate_hz = read(FREQUENCY.1, text).filter(|rate| *rate > 0.0)?;
        return Some(format!("{}ms", rounded(1e3 / rate_hz)));
    }
    let value = match text.split_once('/') {
        Some((above, below)) => number(above)? / number(below)?,
        None => libm::exp10(number(text.trim().strip_suffix("dB")?)? / 20.0),
    };
    let is_one = units == NUMBER.1 && value.is_finite();
    is_one.then(|| rounded(value).to_string())
}

/// Value in four digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// True of a number that has no unit.
#[must_use]
pub fn is_bare(text: &str) -> bool {
    number_with(text, DecimalSign::Point).is_some()
}

/// True of a unit of anything that a key is of.
#[must_use]
pub fn is_unit(text: &str) -> bool {
    let mut units = ENDS.iter().flat_map(|end| end.quantity.1);
    units.any(|(unit, _)| !unit.is_empty() && *unit == text)
}

/// Text that is not a quantity of the required kind.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityError {
    text: String,
    /// The right spelling, if it can be guessed.
    meant: Option<String>,
    what: &'static str,
    /// `None` of a text that is too long.
    units: Option<&'static [Unit]>,
}

impl fmt::Display for QuantityError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { text, what, .. } = self;
        let Some(units) = self.units else {
            return write!(
                f,
                "\"{text}…\" is not {what}: give at most {LONGEST} characters"
            );
        };
        let named = units.iter().map(|(unit, _)| *unit);
        let units: Vec<&str> = named.filter(|unit| !unit.is_empty()).collect();
        let others = ENDS.iter().map(|end| end.quantity);
        let others = others.filter(|other| **other != NUMBER && !is_bare(text));
        let mut others = others.filter(|other| read(other.1, text).is_some());
        match others.next() {
            Some((other, _)) => write!(f, "\"{text}\" is {other}, not {what}: ")?,
            None => write!(f, "\"{text}\" is not {what}: ")?,
        }
        match &self.meant {
            Some(meant) => write!(f, "write {meant}"),
            None if units.is_empty() => f.write_str("give a finite number alone"),
            None => write!(
                f,
                "give a finite number, with one of the units {} or none for SI",
                units.join(", ")
            ),
        }
    }
}

impl std::error::Error for QuantityError {}

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
mod tests {
    use super::*;

    #[test]
    fn units_scale_to_si_and_none_means_si() {
        for (key, text, si) in [
            ("_s", "200s", 200.0),
            ("_s", "1ms", 1e-3),
            ("_s", "0.001", 1e-3),
            ("_s", " 2 min ", 120.0),
            ("_s", "100us", 1e-4),
            ("_m", "20mm", 0.02),
            ("_m", "1e-3m", 1e-3),
            ("_m2", "4cm2", 4e-4),
            ("_m2", "4 cm²", 4e-4),
            ("strain", "5%", 0.05),
            ("strain", "0.05", 0.05),
            ("_n", "250 mN", 0.25),
            ("_n_per_s", "1N/ms", 1000.0),
            ("_pa", "0.1kPa", 100.0),
            ("_rad", "1deg", 1_f64.to_radians()),
            ("_rad", "65 °", 65_f64.to_radians()),
            ("_rad", "1.2", 1.2),
            ("_rad_s", "10Hz", 10.0 * TURN),
            ("_rad_s", "5mrad/s", 0.005),
            ("_bytes", "1GB", 1e9),
        ] {
            assert_eq!(parse_for_key(key, text), Ok(si), "{key} {text}");
        }
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
        let inertance = WrittenUnit::of_key("body_inertance_n_s_mu_per_m", 1.0);
        assert_eq!(inertance.symbol, "N·s^(1+α)/m");
        assert!(
            doubt("stiffness_n_per_m", "3").is_err() && doubt("stiffness_n_per_m", "30").is_ok()
        );
        let error = parse_for_key("mass_kg", "3m")
            .expect_err("a length")
            .to_string();
        assert!(error.contains("\"3m\" is a length, not a mass"), "{error}");
    }

    #[test]
    fn a_text_that_is_nearly_a_number_is_answered_with_what_to_write() {
        for (key, text, meant) in [
            ("_s", "1,5s", "write 1.5s, without a comma"),
            ("_s", "1,5", "write 1.5, without a comma"),
            ("_s", "1MS", "write 1ms"),
            ("_rad_s", "10 hz", "write 10Hz"),
            ("_n", "1,234.5 N", "write 1234.5N, without a comma"),
            ("_n", "1.234,5", "write 1234.5, without a comma"),
            ("_n", "1,234", "write 1.234 or 1234, without a comma"),
            ("_m2", "4,5cm2", "write 4.5cm2, without a comma"),
            ("", "0,2", "write 0.2, without a comma"),
            ("_s", "2mins", "write 2min"),
            ("_m2", "4 cm^2", "write 4cm2"),
            ("_kg", "0.065 KGs", "write 0.065kg"),
            ("", "1/2", "write 0.5"),
            ("", "1/5000", "write 0.0002"),
            ("", "6dB", "write 1.995"),
            ("_s", "1kHz", "write 1ms"),
            ("_s", "300Hz", "write 3.333ms"),
            // Neither of these is told.
            ("_s", "1,5kg", "give a finite number"),
            ("_s", "0Hz", "give a finite number"),
            ("_n", "1/2", "give a finite number"),
            ("", "1/0", "give a finite number"),
            ("", "5kg", "give a finite number"),
            ("_s", "1,2,3", "give a finite number"),
        ] {
            let error = parse_for_key(key, text).expect_err(text).to_string();
            let is_meant = error.ends_with(meant) || error.contains(&format!("{meant}, with"));
            assert!(is_meant, "{error}");
        }
        for damping in ["2N*s/m", "2 N·s/m", "2N.s/m", "2Ns/m"] {
            assert_eq!(parse_for_key("_n_s_per_m", damping), Ok(2.0), "{damping}");
        }
        assert!(is_bare(" -1e3 ") && !is_bare("1s") && !is_bare(""));
        assert!(is_unit("ms") && is_unit("%") && !is_unit("") && !is_unit("wall"));
    }

    #[test]
    fn a_text_of_more_than_64_characters_is_refused_by_its_first_20_however_long_it_is() {
        let longest = format!("{}5 s", "0".repeat(61));
        assert_eq!(parse_for_key("_s", &longest), Ok(5.0));
        for (text, shown) in [
            (format!("0{longest}"), "00000000000000000000"),
            ("[".repeat(1 << 24), "[[[[[[[[[[[[[[[[[[[["),
            (
                format!("1{}", " 000".repeat(1 << 20)),
                "1 000 000 000 000 00",
            ),
            ("é".repeat(65), "éééééééééééééééééééé"),
        ] {
            let error = parse_for_key("_s", &text).expect_err(shown).to_string();
            let refusal = format!("\"{shown}…\" is not a time: give at most 64 characters");
            assert_eq!(error, refusal);
            assert_eq!(nearest(&text, &["order"]), None, "{shown}");
        }
    }

    #[test]
    fn what_is_no_finite_number_or_has_another_unit_is_refused() {
        for bad in [
            "", "s", "NaN", "inf", "-infs", "1e999", "5 %", "5m", "1 2s", "--", "1e5000s",
        ] {
            let error = parse_for_key("_s", bad).expect_err(bad).to_string();
            assert!(
                error.contains("not a time") && error.contains("ms"),
                "{error}"
            );
        }
    }
}
