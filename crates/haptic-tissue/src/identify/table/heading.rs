//! The line of names and the line of units that belong to a block of numbers.

use super::header::split;

/// What stands above the columns of a block.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Heading {
    /// The line of the names; of the first row without any.
    pub(super) line: u64,
    pub(super) names: Vec<String>,
    /// The cells of a line of units; fewer than names if it is shorter.
    pub(super) units: Vec<String>,
}

impl Heading {
    /// The unit in the line of units; empty if there is none.
    pub(super) fn below(&self, place: usize) -> &str {
        bare(self.units.get(place).map_or("", String::as_str))
    }

    /// The unit below a name, or the one in it.
    pub(super) fn unit(&self, place: usize) -> Option<String> {
        match self.below(place) {
            "" => split(&self.names[place]).1,
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
