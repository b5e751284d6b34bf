//! A header as quantity and unit: `Time [s]`, `G' (Pa)`, `Storage Modulus / kPa`, `stress_pa`.

use super::column::Column;
use super::unit::Dimension;
use crate::MeasuredLoading;
use crate::identify::keys::UNITS;
use haptic_loop::{LoadingKind, Modulus};

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Heading {
    pub(super) column: Column,
    /// SI units per unit of the column; `None` without a unit.
    pub(super) factor: Option<f64>,
}

/// A unit that does not fit the quantity.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ForeignUnit {
    pub(super) column: Column,
    pub(super) unit: String,
}

/// Name and unit, in brackets or behind a slash, a comma or the word *in*.
pub(super) fn split(header: &str) -> (String, Option<String>) {
    let header = header.trim();
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}')] {
        if let Some(inside) = header.strip_suffix(close)
            && let Some((name, unit)) = inside.rsplit_once(open)
            // G(t) is a name.
            && !matches!(unit, "t" | "f")
            && !name.trim().is_empty()
        {
            return (name.trim().to_owned(), Some(unit.trim().to_owned()));
        }
    }
    for between in [" / ", "/", ", ", " in "] {
        if let Some((name, unit)) = header.split_once(between)
            && !name.trim().is_empty()
        {
            return (name.trim().to_owned(), Some(unit.trim().to_owned()));
        }
    }
    (header.to_owned(), None)
}

/// Normalised primes, spaces and capitals.
fn plain(name: &str) -> String {
    let primes = name
        .replace(['′', '’', '´', '`'], "'")
        .replace(['″', '”', '"'], "''")
        .replace(['_', '-'], " ");
    primes
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
        .to_lowercase()
}

/// Words that tell a loading, and symbols that tell a modulus.
const LOADINGS: [(LoadingKind, &[&str]); 3] = [
    (LoadingKind::Shear, &["shear", "γ", "gamma", "τ", "tau"]),
    (LoadingKind::Tension, &["tension", "tensile"]),
    (LoadingKind::Compression, &["compressive"]),
];
const MODULI: [(Modulus, &[&str]); 2] = [
    (Modulus::Shear, &["g", "g(t)", "g'", "g''", "gp", "gpp"]),
    (
        Modulus::Young,
        &[
            "e", "e(t)", "e'", "e''", "ep", "epp", "young", "young's", "youngs",
        ],
    ),
];

/// What a header says of how the specimen was loaded, and which modulus it is of.
pub(super) fn told(header: &str) -> MeasuredLoading {
    let name = plain(&split(header).0);
    let says = |words: &[&str]| name.split(' ').any(|word| words.contains(&word));
    let kind = LOADINGS.iter().find(|known| says(known.1));
    let modulus = MODULI.iter().find(|known| says(known.1));
    MeasuredLoading {
        kind: kind.map(|known| known.0),
        modulus: modulus.map(|known| known.0),
        poisson_ratio: None,
    }
}

/// Quantity and unit of a header; `None` if it is not a quantity of a record.
pub(super) fn understand(header: &str) -> Option<Result<Heading, ForeignUnit>> {
    let lower = header.trim().to_lowercase();
    if let Some(column) = Column::ALL
        .into_iter()
        .find(|column| column.header() == lower)
    {
        let factor = Some(1.0);
        return Some(Ok(Heading { column, factor }));
    }
    if let Some(heading) = with_suffix(&lower) {
        return Some(Ok(heading));
    }
    let (name, unit) = split(header);
    let name = plain(&name);
    let known: Vec<Column> = spelt(&name).collect();
    let Some(unit) = unit else {
        // A name of two quantities, as f, is ambiguous.
        let [column] = known[..] else { return None };
        return Some(Ok(Heading {
            column,
            factor: None,
        }));
    };
    let fits = known
        .iter()
        .find_map(|&column| Some((column, column.dimension().factor(&unit)?)));
    match (fits, known.first()) {
        (Some((column, factor)), _) => Some(Ok(Heading {
            column,
            factor: Some(factor),
        })),
        (None, Some(&column)) => Some(Err(ForeignUnit { column, unit })),
        (None, None) => None,
    }
}

/// `modulus_kpa`: a unit after an underscore.
fn with_suffix(header: &str) -> Option<Heading> {
    let marks = header.match_indices('_').map(|(mark, _)| mark);
    marks.into_iter().find_map(|mark| {
        let (name, suffix) = (plain(&header[..mark]), &header[mark + 1..]);
        spelt(&name).find_map(|column| {
            let factor = column.dimension().factor_of_suffix(suffix)?;
            Some(Heading {
                column,
                factor: Some(factor),
            })
        })
    })
}

/// Remedy for a wrong unit.
pub(super) fn remedy(dimension: Dimension, column: Column) -> String {
    format!(
        "give one of {} in the header, or {UNITS} {}={}",
        dimension.names(),
        column.name(),
        dimension.si()
    )
}

/// The columns that machines write so.
fn spelt(name: &str) -> impl Iterator<Item = Column> {
    let columns = Column::ALL.into_iter();
    columns.filter(move |column| column.is_spelt(name))
}
