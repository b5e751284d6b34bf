//! Numbers as people read them: four digits, and a unit that suits.

use crate::parts_of_key;

/// Powers of ten that have a letter.
const LETTERS: [(i32, &str); 7] = [
    (9, "G"),
    (6, "M"),
    (3, "k"),
    (0, ""),
    (-3, "m"),
    (-6, "µ"),
    (-9, "n"),
];

/// A key in words, without its unit: of `peak_force_n` `peak force`.
#[must_use]
pub fn label(key: &str) -> String {
    parts_of_key(key).0.replace('_', " ")
}

/// The unit in which the numbers of a key are written.
#[derive(Clone, Debug, PartialEq)]
pub struct WrittenUnit {
    /// Its symbol, as `kN/m`; empty for a pure number.
    pub symbol: String,
    per_number: f64,
}

impl WrittenUnit {
    /// For numbers of a key of about this size: `kN/m` for `stiffness_n_per_m` and 7625.
    #[must_use]
    pub fn of_key(key: &str, size: f64) -> Self {
        let end = parts_of_key(key).1;
        let size = (size * end.per_unit).abs();
        let (least, most) = end.powers;
        let mut allowed = LETTERS
            .iter()
            .filter(|(power, _)| (least..=most).contains(power));
        // 999.96 is written as 1000 in four digits.
        let fits = |power: i32| size >= 0.999_95 * 10_f64.powi(power);
        let &(power, letter) = match size > 0.0 && size.is_finite() {
            true => allowed.find(|(power, _)| fits(*power)),
            false => None,
        }
        .unwrap_or(&(0, ""));
        Self {
            symbol: format!("{letter}{}", end.unit),
            per_number: end.per_unit / 10_f64.powi(power),
        }
    }

    /// A number of the key in this unit, without its symbol.
    #[must_use]
    pub fn number(&self, value: f64) -> String {
        let plain = self.symbol.is_empty() && (self.per_number - 1.0).abs() < f64::EPSILON;
        match (value - 1.0).abs() {
            // How far a ratio is from 1 is what it says.
            off if plain && off > 0.0 && off < 1e-2 => {
                let decimals = (1.0 - off.log10()).ceil().min(15.0) as usize;
                digits(format!("{value:.decimals$}").parse().unwrap_or(value), 17)
            }
            _ => digits(value * self.per_number, 4),
        }
    }
}

/// A number of a key with its unit: `7.625 kN/m` of `stiffness_n_per_m` and 7624.95.
///
/// ```
/// use haptic_quantity::written;
///
/// assert_eq!(written("stiffness_n_per_m", 7624.952_274), "7.625 kN/m");
/// assert_eq!(written("sample_time_s", 0.001), "1 ms");
/// assert_eq!(written("p99_ns", 1322.0), "1.322 µs");
/// assert_eq!(written("order", 0.2247), "0.2247");
/// ```
#[must_use]
pub fn written(key: &str, value: f64) -> String {
    let unit = WrittenUnit::of_key(key, value);
    let number = unit.number(value);
    match unit.symbol.is_empty() {
        true => number,
        false => format!("{number} {}", unit.symbol),
    }
}

/// A number in so many significant digits at most, without zeros that say nothing; with an exponent where it would be long.
#[must_use]
pub fn digits(value: f64, most: usize) -> String {
    let decimals = most.clamp(1, 17) - 1;
    let rounded: f64 = format!("{value:.decimals$e}").parse().unwrap_or(value);
    match rounded.abs() {
        // −0 is 0.
        0.0 => "0".to_owned(),
        size if (1e-4..1e6).contains(&size) || !size.is_finite() => format!("{rounded}"),
        _ => format!("{rounded:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_has_four_digits_and_a_unit_that_suits() {
        for (key, value, text) in [
            ("mass_kg", 0.065, "65 g"),
            ("mass_kg", 2.0, "2 kg"),
            ("force_n", 0.186_676, "186.7 mN"),
            ("force_n", 0.999_96, "1 N"),
            ("force_n", -3.5, "-3.5 N"),
            ("force_n", -0.0, "0 N"),
            ("force_n", 1e-14, "1e-14 N"),
            ("duration_s", 5000.0, "5000 s"),
            ("position_m", 3.2e-6, "3.2 µm"),
            ("latency_us", 1500.0, "1.5 ms"),
            ("dissipation_n_s_mu_per_m", 59.999_99, "60 N·s^μ/m"),
            ("area_m2", 0.001_256_6, "0.001257 m²"),
            ("size_bytes", 2.5e6, "2.5 MB"),
            ("error", 3.242_556e-7, "3.243e-7"),
            ("ratio", 0.999_236_38, "0.99924"),
            ("ratio", 1.000_000_12, "1.00000012"),
            ("ratio", 1.0, "1"),
            ("ratio", f64::INFINITY, "inf"),
        ] {
            assert_eq!(written(key, value), text, "{key} {value}");
        }
    }

    #[test]
    fn a_column_has_one_unit() {
        let unit = WrittenUnit::of_key("stiffness_n_per_m", 12_000.0);
        assert_eq!(unit.symbol, "kN/m");
        assert_eq!([12_000.0, 50.0].map(|k| unit.number(k)), ["12", "0.05"]);
    }
}
