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

/// A key in words, without its unit: of `peak_force_n` `peak force`. The name of a topic, as `/peak_force`, stays as it is.
#[must_use]
pub fn label(key: &str) -> String {
    if key.starts_with('/') {
        key.to_owned()
    } else {
        parts_of_key(key).0.replace('_', " ")
    }
}

/// The unit in which the numbers of a key are written.
#[derive(Clone, Debug, PartialEq)]
pub struct WrittenUnit {
    /// Its symbol, as `kN/m`; empty for a pure number.
    pub symbol: String,
    per_number: f64,
    toward: Toward,
}

/// Numbers are rounded to the nearest. One that its name calls the largest or the required is rounded to the safe side, so that who takes the number that is written is within the limit.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Toward {
    Nearest,
    Up,
    Down,
}

/// Beginnings of keys of what is required.
const REQUIRED: [&str; 4] = [
    "required_",
    "llewellyn_damping",
    "corollary_",
    "sampled_damping",
];
/// Beginnings of keys of the largest that is allowed, or proved.
const LARGEST: [&str; 6] = [
    "largest_",
    "alpha_max",
    "beta_max",
    "stiffness_max",
    "proved_",
    "pulling_contact_margin",
];

impl Toward {
    fn of_key(key: &str) -> Self {
        match parts_of_key(key).0 {
            stem if REQUIRED.iter().any(|required| stem.starts_with(required)) => Self::Up,
            stem if LARGEST.iter().any(|largest| stem.starts_with(largest)) => Self::Down,
            _ => Self::Nearest,
        }
    }
}

impl WrittenUnit {
    /// Unit for numbers of a key of about this size: `kN/m` for `stiffness_n_per_m` and 7625.
    #[must_use]
    pub fn of_key(key: &str, size: f64) -> Self {
        let end = parts_of_key(key).1;
        let size = (size * end.per_unit).abs();
        let (least, most) = end.powers;
        let mut allowed = LETTERS
            .iter()
            .filter(|(power, _)| (least..=most).contains(power));
        // 999.96 is written as 1000 in four digits.
        let fits = |power: i32| size >= 0.999_95 * libm::exp10(f64::from(power));
        let &(power, letter) = if size > 0.0 && size.is_finite() {
            allowed.find(|(power, _)| fits(*power))
        } else {
            None
        }
        .unwrap_or(&(0, ""));
        Self {
            symbol: format!("{letter}{}", end.unit),
            per_number: end.per_unit / libm::exp10(f64::from(power)),
            toward: Toward::of_key(key),
        }
    }

    /// A number of the key in this unit, without its symbol.
    #[must_use]
    pub fn number(&self, value: f64) -> String {
        let plain = self.symbol.is_empty();
        match (value - 1.0).abs() {
            // Near 1, the digits that count are those of the distance from 1.
            off if plain && off > 0.0 && off < 1e-2 => {
                let decimals = (1.0 - libm::log10(off)).ceil().min(15.0) as usize;
                // Of 0.99 the first decimal is the first digit.
                let most = decimals + usize::from(value >= 1.0);
                rounded(value, most, self.toward)
            }
            _ => rounded(value * self.per_number, 4, self.toward),
        }
    }
}

/// A number and the ends of its interval, with enough digits to distinguish them: `65 g, low 64.997
/// g, high 65.004 g`.
#[must_use]
pub fn written_between(key: &str, [value, low, high]: [f64; 3]) -> [String; 3] {
    let share = (high - low) / high.abs().max(low.abs());
    let most = match share {
        share if share > 0.0 => (3.0 - libm::log10(share)).ceil().clamp(3.0, 8.0) as usize,
        _ => 4,
    };
    let unit = WrittenUnit::of_key(key, value);
    let write = |value: f64, toward| {
        let number = rounded(value * unit.per_number, most, toward);
        format!("{number} {}", unit.symbol).trim_end().to_owned()
    };
    [
        write(value, Toward::Nearest),
        write(low, Toward::Down),
        write(high, Toward::Up),
    ]
}

/// A number of a key with its unit: `7.625 kN/m` of `stiffness_n_per_m` and 7624.95.
///
/// ```
/// use haptic_quantity::written;
///
/// assert_eq!(written("hand_stiffness_n_per_m", 7624.952_274), "7.625 kN/m");
/// assert_eq!(written("sample_time_s", 0.001), "1 ms");
/// assert_eq!(written("p99_ns", 1322.0), "1.322 µs");
/// assert_eq!(written("order", 0.2247), "0.2247");
/// ```
#[must_use]
pub fn written(key: &str, value: f64) -> String {
    let unit = WrittenUnit::of_key(key, value);
    let number = unit.number(value);
    if unit.symbol.is_empty() {
        number
    } else {
        format!("{number} {}", unit.symbol)
    }
}

/// A number in at most `most` significant digits, without trailing zeros; with an exponent where it would be long.
#[must_use]
pub fn digits(value: f64, most: usize) -> String {
    rounded(value, most, Toward::Nearest)
}

/// A formula with five digits to its numbers.
/// ```
/// use haptic_quantity::in_five_digits;
///
/// let long = "exp(-0.9999999999999917s)*0.55/(62s^1.25+1.234567891e-12)";
/// let short = "exp(-1s)*0.55/(62s^1.25+1.2346e-12)";
/// assert_eq!(in_five_digits(long), short);
/// assert_eq!(in_five_digits(short), short);
/// ```
#[must_use]
pub fn in_five_digits(formula: &str) -> String {
    let is_number = |letter: char| letter.is_ascii_digit() || letter == '.';
    let letters: Vec<char> = formula.chars().collect();
    let parts = letters.chunk_by(|a, b| is_number(*a) == is_number(*b));
    let shortened = parts.map(|part| {
        let part: String = part.iter().collect();
        let number = part.parse().ok().filter(|_| part.len() > 6);
        number.map_or(part, |number: f64| digits(number, 5))
    });
    shortened.collect()
}

fn rounded(value: f64, most: usize, toward: Toward) -> String {
    let decimals = most.clamp(1, 17) - 1;
    let nearest = |value: f64| -> f64 { format!("{value:.decimals$e}").parse().unwrap_or(value) };
    let mut rounded = nearest(value);
    // A unit of the last digit; a value this near to a number of `most` digits is that number.
    let last = libm::exp10(libm::log10(value.abs()).floor() - decimals as f64);
    let (off, step) = match toward {
        Toward::Nearest => (0.0, 0.0),
        Toward::Up => (value - rounded, last),
        Toward::Down => (rounded - value, -last),
    };
    if off > 1e-9 * last {
        rounded = nearest(rounded + step);
    }
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
            ("required_delta", 0.189_612, "0.1897"),
            ("required_delta", 0.25, "0.25"),
            ("required_damping_n_s_per_m", 0.0, "0 N·s/m"),
            ("largest_stiffness_n_per_m", 9.9999e3, "9.999 kN/m"),
            ("alpha_max", -0.123_41, "-0.1235"),
            ("proved_stiffness_n_per_m", 7058.96, "7.058 kN/m"),
            ("pulling_contact_margin", 0.705_89, "0.7058"),
            ("required_damping_n_s_per_m", 6.254_02, "6.255 N·s/m"),
            ("required_delta", 1.003_41, "1.0035"),
            ("margin", 0.996_59, "0.9966"),
            ("dissipation", 178.558_92, "178.6"),
            ("stiffness_n_per_m", 11_689.8, "11.69 kN/m"),
        ] {
            assert_eq!(written(key, value), text, "{key} {value}");
        }
    }

    #[test]
    fn the_ends_of_an_interval_are_told_apart() {
        let mass = written_between("mass_kg", [0.065, 0.064_997_21, 0.065_003_75]);
        assert_eq!(mass, ["65 g", "64.99721 g", "65.00375 g"]);
        assert_eq!(written_between("friction_n", [0.0; 3]), ["0 N"; 3]);
    }

    #[test]
    fn a_column_has_one_unit() {
        let unit = WrittenUnit::of_key("stiffness_n_per_m", 12_000.0);
        assert_eq!(unit.symbol, "kN/m");
        assert_eq!([12_000.0, 50.0].map(|k| unit.number(k)), ["12", "0.05"]);
    }
}
