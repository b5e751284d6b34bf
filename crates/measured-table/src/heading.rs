//! The line of names and the line of units that belong to a block of numbers.

use super::column::Column;
use super::header::{Unit, logarithm, split, understand, unit_in};
use super::lines::brief;
use super::unit::Dimension;

/// Letters of a unit, at most.
pub(super) const UNIT_LENGTH: usize = 12;

/// True of cells of which half and more are units, and none is long.
pub(super) fn are_units<'a>(cells: impl Iterator<Item = &'a str> + Clone) -> bool {
    let is_unit = |cell: &&str| *cell == "-" || bare(cell) != *cell || Dimension::knows(cell);
    let units = cells.clone().filter(is_unit).count();
    let mut lengths = cells.clone().map(str::len);
    units > 0 && 2 * units >= cells.count() && lengths.all(|length| length <= 2 * UNIT_LENGTH)
}

/// Names and units above the columns of a block.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Heading {
    /// The line of the names; of the first row without any.
    pub(super) line: u64,
    pub(super) names: Vec<String>,
    /// The cells of a line of units; fewer than names if it is shorter.
    pub(super) units: Vec<String>,
}

impl Heading {
    /// The one column of this name, with its unit or without, or of this number, from 1.
    pub(super) fn place(&self, name: &str) -> Result<Option<usize>, String> {
        let wanted = brief(name);
        let is_alike = |name: &str| name.eq_ignore_ascii_case(&wanted);
        let found = match self.one(name, |place| self.names[place] == wanted)? {
            None => self.one(name, |place| {
                let header = &self.names[place];
                is_alike(header) || is_alike(&split(header).0)
            })?,
            exact => exact,
        };
        let numbers = 1..=self.names.len();
        let number = wanted
            .parse()
            .ok()
            .filter(|number| numbers.contains(number));
        Ok(found.or(number.map(|number: usize| number - 1)))
    }

    /// The one column of which this is true.
    pub(super) fn one(
        &self,
        name: &str,
        is_it: impl Fn(usize) -> bool,
    ) -> Result<Option<usize>, String> {
        let mut places = (0..self.names.len()).filter(|place| is_it(*place));
        match (places.next(), places.next()) {
            (found, None) => Ok(found),
            (_, Some(_)) => Err(format!(
                "more than one column is named {name}: give its number, or rename all but one"
            )),
        }
    }

    /// The unit in the line of units; empty without such a line.
    pub(super) fn below(&self, place: usize) -> &str {
        bare(self.units.get(place).map_or("", String::as_str))
    }

    /// The unit of a column that was chosen for a quantity, whatever its name is.
    pub(super) fn unit_as(&self, column: Column, place: usize) -> Unit {
        let name = &self.names[place];
        let meaning =
            understand(name, self.below(place)).filter(|meaning| meaning.column == column);
        let (_, suffix) = name.rsplit_once('_').unwrap_or_default();
        let suffix = || Unit::of_suffix(column, suffix);
        match (meaning, self.unit(place)) {
            (Some(meaning), _) => meaning.unit,
            (None, None) => suffix().unwrap_or(Unit::Untold),
            (None, unit) => unit_in(column, name, unit.as_deref()),
        }
    }

    /// The unit below a name, or the one in it.
    pub(super) fn unit(&self, place: usize) -> Option<String> {
        let name = &self.names[place];
        match self.below(place) {
            "" => split(&logarithm(name).map_or_else(|| name.clone(), |of| of.1)).1,
            unit => Some(unit.to_owned()),
        }
    }
}

/// A unit without its brackets.
pub(super) fn bare(unit: &str) -> &str {
    let inside = [('[', ']'), ('(', ')'), ('{', '}')].into_iter();
    let mut inside =
        inside.filter_map(|(open, close)| unit.strip_prefix(open)?.strip_suffix(close));
    inside.next().unwrap_or(unit).trim()
}
