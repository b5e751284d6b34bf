//! The quantities that a column can hold.

use super::unit::{Dimension, rows};

fracdiff::enumerated! {
    /// A quantity of a record.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[non_exhaustive]
    pub enum Column {
        /// Time, s; of any origin.
        Time,
        /// Relaxation modulus, Pa.
        Modulus,
        /// Creep compliance, 1/Pa.
        Compliance,
        /// Strain, 1.
        Strain,
        /// Nominal stress, Pa: force over the area at rest.
        Stress,
        /// Force on the specimen, N.
        Force,
        /// Position into the specimen, m: its depth.
        Position,
        /// Angular frequency, rad/s; a column in Hz is converted.
        Omega,
        /// Storage modulus, Pa.
        Storage,
        /// Loss modulus, Pa.
        Loss,
        /// Magnitude of the complex modulus, Pa.
        Complex,
        /// Phase angle between strain and stress, rad.
        Phase,
        /// Loss over storage modulus, 1.
        LossTangent,
        /// Temperature, °C: it tells segments apart, and is no number of a record.
        Temperature,
    }
}

/// The place of a column that a user named.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Number of the column, from 1.
    Number(usize),
    /// Header of the column, or the header without the unit.
    Name(String),
}

impl Column {
    /// Its name where a user chooses columns or units.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.row(0)
    }

    /// The column of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|column| column.name() == name)
    }

    /// The quantity and the place of `modulus=3` or `modulus=G' (Pa)`.
    ///
    /// # Errors
    /// Another form, or another quantity, with those that there are.
    pub fn chosen(text: &str) -> Result<(Self, Choice), String> {
        let (column, place) = Self::with_unit(text)?;
        Ok((
            column,
            place.parse().map_or(Choice::Name(place), Choice::Number),
        ))
    }

    /// The quantity and the unit of `stress=kPa`.
    ///
    /// # Errors
    /// As [`chosen`](Self::chosen).
    pub fn with_unit(text: &str) -> Result<(Self, String), String> {
        let split = text
            .split_once('=')
            .and_then(|(name, value)| Some((Self::named(name.trim())?, value.trim().to_owned())));
        split.ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("is not NAME=VALUE with a name of {names}")
        })
    }

    /// Its header in SI units, as this project writes it.
    #[must_use]
    pub fn header(self) -> &'static str {
        self.row(1)
    }

    pub(super) fn dimension(self) -> Dimension {
        Dimension(self.row(2))
    }

    /// True if machines write it so; in lower case, with plain primes, single spaces, without unit.
    pub(super) fn is_spelt(self, name: &str) -> bool {
        let is_spelt = |name: &str| self.row(3).split(", ").any(|spelling| spelling == name);
        // `kreisfrequenz ω`: a word and its symbol.
        let parts = name.rsplit_once(' ');
        is_spelt(name) || parts.is_some_and(|(word, symbol)| is_spelt(word) && is_spelt(symbol))
    }

    fn row(self, cell: usize) -> &'static str {
        rows(include_str!("columns.txt"))
            .nth(self as usize)
            .and_then(|row| row.split(" | ").nth(cell))
            .unwrap_or_default()
    }
}
