//! Units of columns: those of a table, and those that are made of them, such as forces over areas.

use std::collections::HashSet;

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

/// A unit in SI units, and whether it is one of mass that stands for the weight of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Size {
    pub(super) si: f64,
    pub(super) is_weight: bool,
}

const PRESSURE: Dimension = Dimension("pressure");
const FORCE: Dimension = Dimension("force");
const LENGTH: Dimension = Dimension("length");

impl Dimension {
    fn units(self) -> impl Iterator<Item = (&'static str, f64)> {
        let spellings = units().filter(move |unit| unit.0 == self.0);
        spellings.map(|unit| (unit.1, unit.2))
    }

    /// True of a unit of anything that machines measure, in its own capitals.
    pub(super) fn knows(unit: &str) -> bool {
        let plain = plain(unit);
        let made = ["pressure", "compliance", "ratio"].map(Self);
        let mut made = made.iter().map(|one| one.made(&plain, str::eq));
        !plain.is_empty()
            && (units().any(|known| known.1 == plain) || made.any(|one| one.is_some()))
    }

    pub(super) fn si(self) -> &'static str {
        self.units().next().map_or("", |unit| unit.0)
    }

    /// The first spelling of each size.
    pub(super) fn names(self) -> String {
        let mut sizes = HashSet::new();
        let named = self.units().filter(|unit| !unit.0.is_empty());
        let named = named.filter(|unit| sizes.insert(unit.1.to_bits()));
        named.map(|unit| unit.0).collect::<Vec<_>>().join(", ")
    }

    /// A unit in SI units; capitals count only where they must, as in `MPa` and `mPa`.
    pub(super) fn size(self, unit: &str) -> Option<Size> {
        let plain = plain(unit);
        let exact = self.read(&plain, str::eq);
        exact.or_else(|| self.read(&plain, str::eq_ignore_ascii_case))
    }

    /// A unit of the table, or one that is made of them.
    fn read(self, unit: &str, is_alike: Alike) -> Option<Size> {
        let listed = |dimension: Self| {
            let mut units = dimension.units();
            units.find(|known| is_alike(known.0, unit))
        };
        let size = |is_weight: bool| move |(_, si): (&str, f64)| Size { si, is_weight };
        let weight = || listed(Self("weight")).filter(|_| self == FORCE);
        let listed = listed(self).map(size(false));
        listed
            .or_else(|| weight().map(size(true)))
            .or_else(|| self.made(unit, is_alike))
    }

    /// `kN/m2` and `N mm-2` of force and length, `1/psi`, `MPa-1` and `cm2/dyne` of pressures, `mm/m` of lengths.
    fn made(self, unit: &str, is_alike: Alike) -> Option<Size> {
        let read = |dimension: Self, unit: &str| dimension.read(unit.trim(), is_alike);
        let square = |length: &str| read(LENGTH, length).map(|length| length.si * length.si);
        let area = |unit: &str| square(unit.trim().strip_suffix('2')?);
        let ratio = unit.split_once('/');
        match self.0 {
            "pressure" => {
                let power = || {
                    let (force, length) = unit.strip_suffix("-2")?.rsplit_once([' ', '.'])?;
                    Some((read(FORCE, force)?, square(length)?))
                };
                let (force, area) = match ratio {
                    Some((force, of)) => (read(FORCE, force)?, area(of)?),
                    None => power()?,
                };
                Some(Size {
                    si: force.si / area,
                    ..force
                })
            }
            "compliance" => {
                let (over, under) = match (ratio, unit.strip_suffix("-1")) {
                    (Some(("1" | "", pressure)), _) | (None, Some(pressure)) => {
                        match pressure.split_once(' ').filter(|_| ratio.is_none()) {
                            Some((over, force)) => (area(over)?, read(FORCE, force)?),
                            None => (1.0, read(PRESSURE, pressure)?),
                        }
                    }
                    (Some((over, force)), _) => (area(over)?, read(FORCE, force)?),
                    (None, None) => return None,
                };
                Some(Size {
                    si: over / under.si,
                    ..under
                })
            }
            "ratio" => {
                let (over, under) = ratio?;
                let over = read(LENGTH, over)?;
                Some(Size {
                    si: over.si / read(LENGTH, under)?.si,
                    ..over
                })
            }
            _ => None,
        }
    }
}

type Alike = fn(&str, &str) -> bool;

/// The unit of a suffix as in `modulus_kpa`, where all is lower case.
pub(super) fn of_suffix(suffix: &str) -> String {
    match suffix {
        "rad_s" => "rad/s".to_owned(),
        _ => match suffix.strip_prefix("per_") {
            Some(unit) => format!("1/{unit}"),
            None => suffix.replace("_per_", "/"),
        },
    }
}

/// Reason for which a unit has no size.
pub(super) fn refused(unit: &str) -> Option<&'static str> {
    let plain = plain(unit).to_lowercase();
    let rows = rows(include_str!("units-refused.txt")).filter_map(|row| row.split_once(" | "));
    let mut rows = rows.filter(|row| row.0.split(", ").any(|unit| unit == plain));
    rows.next().map(|row| row.1)
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

/// One spelling for `sec` and `sec.`, `Pa⁻¹`, `Pa^-1` and `Pa**-1`, `µm` and `μm`, `mm²` and `mm^2`, `N / m2` and `N per m2`.
fn plain(unit: &str) -> String {
    const FROM: &str = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻−µμϵ·⋅×";
    const TO: &str = "0123456789--uuε  x";
    let plain = |letter: char| {
        let mut pairs = FROM.chars().zip(TO.chars());
        pairs
            .find(|pair| pair.0 == letter)
            .map_or(letter, |pair| pair.1)
    };
    let unit = unit.trim().trim_end_matches('.');
    let unit = unit.replace(" per ", "/").replace(['^', '*'], "");
    let unit: String = unit.chars().map(plain).collect();
    unit.replace(" /", "/").replace("/ ", "/")
}
