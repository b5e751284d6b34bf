//! Units of columns.

/// A kind of quantity, by its name in the file of units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Dimension(pub(super) &'static str);

/// The rows of a file of ours, without its remarks.
pub(super) fn rows(file: &'static str) -> impl Iterator<Item = &'static str> {
    file.lines().filter(|row| !row.starts_with('#'))
}

/// Dimensions, their units and what these are in SI, the SI unit first.
fn units() -> impl Iterator<Item = (&'static str, &'static str, f64)> {
    let dimensions = rows(include_str!("units.txt")).filter_map(|row| row.split_once(" | "));
    dimensions.flat_map(|(dimension, units)| {
        units.split(", ").filter_map(move |unit| {
            let (unit, factor) = unit.split_once('=')?;
            Some((dimension, unit, factor.parse().ok()?))
        })
    })
}

impl Dimension {
    fn units(self) -> impl Iterator<Item = (&'static str, f64)> {
        let spellings = units().filter(move |unit| unit.0 == self.0);
        spellings.map(|unit| (unit.1, unit.2))
    }

    /// True of a unit of anything that machines measure, in its own capitals.
    pub(super) fn knows(unit: &str) -> bool {
        let plain = plain(unit);
        !plain.is_empty() && units().any(|known| known.1 == plain)
    }

    pub(super) fn si(self) -> &'static str {
        self.units().next().map_or("", |unit| unit.0)
    }

    pub(super) fn names(self) -> String {
        let units = self.units().map(|unit| unit.0);
        let named: Vec<&str> = units.filter(|unit| !unit.is_empty()).collect();
        named.join(", ")
    }

    /// Factor from a unit to SI; capitals count only where they must, as in `MPa` and `mPa`.
    pub(super) fn factor(self, unit: &str) -> Option<f64> {
        let plain = plain(unit);
        let exact = self.units().find(|known| known.0 == plain);
        let is_alike = |known: &(&str, f64)| known.0.eq_ignore_ascii_case(&plain);
        let alike = || self.units().find(is_alike);
        exact.or_else(alike).map(|known| known.1)
    }

    /// Factor of the suffix of a name like `modulus_kpa`, where all is lower case.
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
