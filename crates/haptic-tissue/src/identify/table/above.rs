//! Names, units and preamble that stand above a block of numbers.
//! ```text
//! names    the nearest line with a name above at least half of the columns of numbers, of those that a choice takes
//! units    the line between names and numbers that holds units
//! preamble all other lines; the last that names a step, an interval or a test is the block's own name
//! ```

use super::find::Block;
use super::lines::brief;
use super::unit::Dimension;
use csv::StringRecord;

/// What stands above the columns of a block.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Heading {
    /// The line of the names; of the first row without any.
    pub(super) line: u64,
    pub(super) names: Vec<String>,
    /// The cells of a line of units; fewer than names if it is shorter.
    pub(super) units: Vec<String>,
}

/// Lines in which names are looked for.
const LINES: usize = 12;
/// Letters of a unit, at most.
const UNIT_LENGTH: usize = 12;

impl Heading {
    /// The unit in the line of units; empty if there is none.
    pub(super) fn unit(&self, place: usize) -> &str {
        let unit = self.units.get(place).map_or("", String::as_str);
        bare(unit)
    }
}

/// A unit without its brackets.
fn bare(unit: &str) -> &str {
    let inside = [('[', ']'), ('(', ')'), ('{', '}')].into_iter();
    let mut inside =
        inside.filter_map(|(open, close)| unit.strip_prefix(open)?.strip_suffix(close));
    inside.next().unwrap_or(unit).trim()
}

fn filled(row: &StringRecord) -> impl Iterator<Item = (usize, &str)> {
    row.iter().enumerate().filter(|cell| !cell.1.is_empty())
}

/// True of `s`, `[Pa]`, `-` and such, in most cells.
fn is_units(row: &StringRecord) -> bool {
    let cells = || filled(row).map(|cell| cell.1);
    let is_unit = |cell: &&str| *cell == "-" || bare(cell) != *cell || Dimension::knows(cell);
    let units = cells().filter(is_unit).count();
    units > 0 && 2 * units >= cells().count() && cells().all(|cell| cell.len() <= 2 * UNIT_LENGTH)
}

impl Block {
    /// What may stand above the columns, the nearest first.
    pub(super) fn headings(&self) -> Vec<Heading> {
        let mut headings = Vec::new();
        let mut between: Vec<&StringRecord> = Vec::new();
        let lines: Vec<_> = self
            .above
            .iter()
            .rev()
            .filter(|(_, row)| filled(row).next().is_some())
            .collect();
        for (n, (line, row)) in lines.iter().enumerate().take(LINES) {
            let is_above_names =
                |above: &&(u64, StringRecord)| self.names_above(&above.1) >= self.names_above(row);
            let is_names = self.has_names(row)
                && !(is_units(row)
                    && lines
                        .get(n + 1)
                        .is_some_and(|above| is_above_names(above) && self.has_names(&above.1)));
            if is_names {
                // A label in front of the names shifts them.
                let shifted = row.len() == self.columns() + 1
                    && row.get(0).is_some_and(|label| label.ends_with(':'));
                let names = |row: &StringRecord| -> Vec<String> {
                    let cells = row.iter().skip(usize::from(shifted));
                    cells.map(brief).collect()
                };
                let is_short = |row: &&&StringRecord| {
                    filled(row).all(|cell| cell.1.chars().count() <= UNIT_LENGTH)
                };
                let units = between.iter().find(|row| is_units(row));
                let units = units.or_else(|| between.iter().find(is_short));
                headings.push(Heading {
                    line: *line,
                    names: names(row),
                    units: units.map(|row| names(row)).unwrap_or_default(),
                });
            }
            between.push(row);
        }
        headings
    }

    /// Cells above columns of numbers.
    fn names_above(&self, row: &StringRecord) -> usize {
        let shift = row.len().saturating_sub(self.columns()).min(1);
        let is_numeric = |place: usize| {
            let at = |place: usize| self.numeric.get(place).copied().unwrap_or(false);
            at(place) || place.checked_sub(shift).is_some_and(at)
        };
        filled(row).filter(|(place, _)| is_numeric(*place)).count()
    }

    /// True of a line that may name the columns: no dates, no numbers.
    fn has_names(&self, row: &StringRecord) -> bool {
        let mut texts =
            filled(row).filter(|cell| !cell.1.starts_with(|c: char| c.is_ascii_digit()));
        let least = self.width().div_ceil(2);
        self.names_above(row) >= least
            && texts.by_ref().count() >= least.max(filled(row).count().div_ceil(2))
    }

    /// Names and units for a table without any: `column 1` and so on.
    pub(super) fn numbered(&self) -> Heading {
        Heading {
            line: self.lines()[0],
            names: (1..=self.columns())
                .map(|n| format!("column {n}"))
                .collect(),
            units: Vec::new(),
        }
    }

    /// The name of the block, from the lines above its heading: that of a step, an interval or a test, or none.
    pub(super) fn name(&self, heading: &Heading) -> Option<String> {
        const WORDS: [&str; 12] = [
            "step",
            "interval",
            "segment",
            "sweep",
            "set",
            "cycle",
            "intervall",
            "abschnitt",
            "temperature",
            "test",
            "result",
            "specimen",
        ];
        let lines = self
            .above
            .iter()
            .rev()
            .filter(|(line, _)| *line < heading.line);
        let texts: Vec<String> = lines
            .take(LINES)
            .map(|(_, row)| {
                let cells: Vec<&str> = filled(row).map(|cell| cell.1).collect();
                match cells[..] {
                    // `Step name: Frequency sweep` is the name behind its key.
                    [key, value] if key.to_lowercase().contains("name") => value.to_owned(),
                    _ => cells.join(" "),
                }
            })
            .filter(|text| text.chars().count() <= 80 && !text.starts_with('['))
            .collect();
        let is_said = |text: &&String| {
            let text = text.to_lowercase();
            WORDS.iter().any(|word| text.contains(word))
        };
        texts.iter().find(is_said).cloned()
    }
}
