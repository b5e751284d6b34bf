//! A name as quantity and unit: `Time [s]`, `G' (Pa)`, `Storage Modulus / kPa`, `stress_pa`, or with its unit in the line below.

use super::column::Column;
use super::keys::UNITS;
use super::lines::brief;
use super::unit::{is_per_second, of_suffix, refused};
use std::f64::consts::E;

/// The quantity that a name means.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Meaning {
    pub(super) column: Column,
    pub(super) unit: Unit,
    /// Rank, of which among several names of one quantity the lowest counts: a clock that begins with the step, or an angular frequency; a plain
    /// name; one with a remark; a clock of the whole test.
    pub(super) rank: u8,
}

/// The unit of a column.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Unit {
    /// Size of one in SI units.
    Factor(f64),
    /// Size as in `Factor`, of a mass that stands for its weight.
    Weight(f64),
    /// Neither the name nor the line below says one.
    Untold,
    /// Hz or rad/s: 1/s can be either, and so can a plain frequency.
    Either,
    /// Unknown, or a unit of another quantity.
    Foreign(String),
}

/// Name and unit, in brackets or behind a slash, a comma or the word *in*.
pub(super) fn split(header: &str) -> (String, Option<String>) {
    let header = header.trim();
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}')] {
        if let Some(inside) = header.strip_suffix(close)
            && let Some((name, unit)) = inside.rsplit_once(open)
            // G(t) and tan(delta) are names.
            && !matches!(unit.trim().to_lowercase().as_str(), "t" | "f" | "delta" | "δ" | "ω")
            && !name.trim().is_empty()
        {
            return (name.trim().to_owned(), Some(unit.trim().to_owned()));
        }
    }
    // The first mark counts: in `J in 1/Pa` the slash is one of the unit.
    let marks = [" in ", ", ", "/"].into_iter();
    let first = marks
        .filter_map(|mark| Some((header.find(mark)?, mark.len())))
        .min();
    if let Some((at, length)) = first.filter(|first| first.0 > 0) {
        let (name, unit) = (&header[..at], &header[at + length..]);
        return (name.trim().to_owned(), Some(unit.trim().to_owned()));
    }
    (header.to_owned(), None)
}

/// Normalised primes, spaces and capitals.
pub(super) fn plain(name: &str) -> String {
    let primes = name
        .replace(['′', '’', '´', '`'], "'")
        .replace(['″', '”', '"'], "''")
        .replace(['_', '-'], " ");
    let words: Vec<&str> = primes.split_whitespace().collect();
    // A capital İ becomes an i and a dot.
    words.join(" ").to_lowercase().replace('\u{307}', "")
}

/// Words of a name without its unit, in lower case.
///
/// ```
/// assert_eq!(measured_table::words("Shear-Stress [kPa]"), ["shear", "stress"]);
/// ```
#[must_use]
pub fn words(header: &str) -> Vec<String> {
    let name = plain(&split(header).0);
    name.split(' ').map(str::to_owned).collect()
}

impl Unit {
    fn of(column: Column, unit: &str) -> Option<Self> {
        let size = column.dimension().size(unit)?;
        Some(if size.is_weight {
            Self::Weight(size.si)
        } else {
            Self::Factor(size.si)
        })
    }

    /// That of a suffix as in `modulus_kpa`.
    pub(super) fn of_suffix(column: Column, suffix: &str) -> Option<Self> {
        Self::of(column, &of_suffix(suffix)).filter(|_| !suffix.is_empty())
    }

    /// The unit behind the last underscore of a name, in words.
    pub(super) fn behind(column: Column, name: &str) -> Option<String> {
        let (_, suffix) = name.rsplit_once('_')?;
        Self::of_suffix(column, suffix).map(|_| of_suffix(suffix))
    }

    pub(super) fn factor(&self) -> Option<f64> {
        match self {
            Self::Factor(factor) | Self::Weight(factor) => Some(*factor),
            Self::Untold | Self::Either | Self::Foreign(_) => None,
        }
    }
}

/// The base of the logarithms in the cells below a name such as `log10 G' (Pa)` or `ln(t/s)`, and the name without it: `G' (Pa)`, `t/s`. As
/// people write it, *log* is decimal.
pub(super) fn logarithm(header: &str) -> Option<(f64, String)> {
    const MARKS: [&str; 6] = ["ln", "log10", "log_10", "log₁₀", "log", "lg"];
    let header = header.trim();
    let (mark, rest) = MARKS.iter().find_map(|mark| {
        let head = header.get(..mark.len())?;
        let rest = &header[mark.len()..];
        head.eq_ignore_ascii_case(mark).then_some((mark, rest))
    })?;
    let base = if *mark == "ln" { E } else { 10.0 };
    let name = rest.trim_start_matches(['_', ' ']);
    let is_apart = name.len() < rest.len() || name.starts_with(['(', '[', '{', '|']);
    let mut depth = 0;
    let end = name.find(|sign| {
        depth += i32::from("([{".contains(sign)) - i32::from(")]}".contains(sign));
        depth == 0
    });
    let name = match end {
        Some(end) if end > 0 => format!("{}{}", &name[1..end], &name[end + 1..]),
        _ => name.to_owned(),
    };
    (!name.is_empty() && (is_apart || understand(&name, "").is_some())).then_some((base, name))
}

/// Quantity and unit of a name, and of the unit in the line below it; `None` if it is not a quantity of a record.
pub(super) fn understand(header: &str, below: &str) -> Option<Meaning> {
    if let Some((_, name)) = logarithm(header) {
        return understand(&name, below);
    }
    let lower = header.trim().to_lowercase();
    let exact = Column::ALL
        .into_iter()
        .find(|column| column.header() == lower);
    let ours = exact
        .map(|column| (column, Unit::Factor(1.0)))
        .or_else(|| with_suffix(&lower));
    if let Some((column, unit)) = ours.filter(|_| below.is_empty()) {
        // `strain` names no unit, as everybody writes it; it may be in per cent.
        let unit = match exact {
            Some(Column::Strain) => Unit::Untold,
            Some(_) | None => unit,
        };
        let rank = PLAIN;
        return Some(Meaning { column, unit, rank });
    }
    let whole = header.trim().to_owned();
    let (name, unit_of_name) = split(header);
    // The unit below belongs to the whole name, as in `Shear modulus (elastic component)`.
    let ways = match (below, unit_of_name) {
        ("", unit) => vec![(name, unit)],
        (below, None) => vec![(whole, Some(below.to_owned()))],
        (below, Some(unit)) => vec![(whole, Some(below.to_owned())), (name, Some(unit))],
    };
    let mut ways = ways.into_iter();
    let found = ways.find_map(|(name, unit)| {
        meaning(&name, unit.clone()).or_else(|| {
            // `Compressive strain (extension)`, `F avg.` and such.
            let remarked = split(&name);
            let remark = remarked.1?;
            let mut meaning = meaning(&remarked.0, unit.or(Some(remark)))?;
            meaning.rank += 1;
            Some(meaning)
        })
    });
    found.or_else(|| {
        // `Modulus kPa`, `Time: s`: words of a unit right behind a name.
        let (name, unit) = header.trim().rsplit_once(' ')?;
        let found = meaning(name.trim_end_matches(':'), Some(unit.to_owned()))?;
        let is_unit = unit.starts_with(char::is_alphabetic) && found.unit.factor().is_some();
        (below.is_empty() && is_unit).then_some(found)
    })
}

const PLAIN: u8 = 1;
/// Clocks that begin with what is measured, and those of the whole test.
const STEP_CLOCKS: &str = "step time, interval time, segment time, t seg, creep time, relaxation time, time (action), intervalle temps";
const TEST_CLOCKS: &str = "total time, run time, running time, test time, global time, timestamp, time stamp, time (sequence), series time, seriestime";
const ANGULAR: &str = "ang, ω, omega, kreis, winkel";

fn meaning(name: &str, unit: Option<String>) -> Option<Meaning> {
    let temperature_or_time = name.trim() == "T";
    let name = plain(name);
    let known: Vec<Column> = if temperature_or_time {
        vec![Column::Temperature, Column::Time]
    } else {
        spelt(&name).collect()
    };
    let is_one_of = |names: &str| names.split(", ").any(|other| other == name);
    let rank = if is_angular(&name) || is_one_of(STEP_CLOCKS) {
        PLAIN - 1
    } else if is_one_of(TEST_CLOCKS) {
        PLAIN + 2
    } else {
        PLAIN
    };
    let fits = |column: &&Column| {
        let unit = unit.as_deref();
        unit.is_some_and(|unit| column.dimension().size(unit).is_some())
    };
    // A name of two quantities without a unit, as f, is ambiguous.
    let column = match (&known[..], &unit) {
        ([column] | [column @ Column::Temperature, _], None) => *column,
        (_, None) => return None,
        (known, Some(_)) => *known.iter().find(fits).or(known.first())?,
    };
    let unit = unit_in(column, &name, unit.as_deref());
    Some(Meaning { column, unit, rank })
}

fn is_angular(name: &str) -> bool {
    ANGULAR.split(", ").any(|word| name.contains(word))
}

/// The unit of a column with this name.
pub(super) fn unit_in(column: Column, name: &str, unit: Option<&str>) -> Unit {
    let is_either = column == Column::Omega && !is_angular(&plain(name));
    match unit {
        None if is_either => Unit::Either,
        None => Unit::Untold,
        Some(unit) if is_either && is_per_second(unit) => Unit::Either,
        Some(unit) => Unit::of(column, unit).unwrap_or_else(|| Unit::Foreign(unit.to_owned())),
    }
}

/// `modulus_kpa`: a unit after an underscore.
fn with_suffix(header: &str) -> Option<(Column, Unit)> {
    let marks = header.match_indices('_').map(|(mark, _)| mark);
    marks.into_iter().find_map(|mark| {
        let (name, suffix) = (plain(&header[..mark]), &header[mark + 1..]);
        spelt(&name).find_map(|column| Some((column, Unit::of_suffix(column, suffix)?)))
    })
}

/// Message for a column whose unit is wrong, with the remedy.
pub(super) fn foreign(unit: &str, column: Column) -> String {
    let (name, dimension) = (column.name(), column.dimension());
    if let Some(why) = refused(unit) {
        return format!("unit {:?} {why}", brief(unit));
    }
    format!(
        "unit {:?} is not a unit of {name}: give one of {} in the header, or {UNITS} {name}={}",
        brief(unit),
        dimension.names(),
        dimension.si()
    )
}

/// The quantities that have this name, or this unit, which may stand below it.
pub(super) fn could_be(header: &str, below: &str) -> Vec<Column> {
    let (name, unit) = split(header);
    let unit = unit
        .filter(|_| below.is_empty())
        .unwrap_or_else(|| below.to_owned());
    let name = plain(&name);
    let fits = |column: &Column| {
        column.is_spelt(&name) || !unit.is_empty() && column.dimension().size(&unit).is_some()
    };
    Column::ALL.into_iter().filter(fits).collect()
}

/// The columns that machines write so.
fn spelt(name: &str) -> impl Iterator<Item = Column> {
    let columns = Column::ALL.into_iter();
    columns.filter(move |column| column.is_spelt(name))
}
