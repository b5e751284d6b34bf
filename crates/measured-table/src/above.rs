//! Names, units and preamble that stand above a block of numbers.
//! ```text
//! names    the nearest line with a name above at least half of the columns of numbers, of those that a choice takes
//! units    the line between names and numbers that holds units
//! preamble all other lines; the last that names a step, an interval or a test is the block's own name
//! ```

use super::error::TableError;
use super::find::Block;
use super::heading::{Heading, UNIT_LENGTH, are_units};
use super::lines::{brief, wrong};
use csv::StringRecord;

/// Lines in which names are looked for.
const LINES: usize = 12;

fn filled(row: &StringRecord) -> impl Iterator<Item = (usize, &str)> + Clone {
    row.iter().enumerate().filter(|cell| !cell.1.is_empty())
}

/// True of `s`, `[Pa]`, `-` and such, in most cells.
fn is_units(row: &StringRecord) -> bool {
    are_units(filled(row).map(|cell| cell.1))
}

impl Block {
    /// Candidate headings above the columns, the nearest first.
    pub(super) fn headings(&self) -> Vec<Heading> {
        let mut headings = Vec::from_iter(self.signals());
        let mut between: Vec<&StringRecord> = Vec::new();
        let above = self.above.iter().rev();
        let above = above.filter(|(_, row)| filled(row).next().is_some());
        let mut lines = above.take(LINES).peekable();
        while let Some((line, row)) = lines.next() {
            let is_named_above = lines.peek().is_some_and(|(_, above)| {
                self.has_names(above) && self.names_above(above) >= self.names_above(row)
            });
            // Names that are fewer than the columns stand right above them, or are those of something else.
            let is_near = row.len() >= self.columns() || between.iter().all(|row| is_units(row));
            if self.has_names(row) && is_near && !(is_units(row) && is_named_above) {
                // A label in front of the names shifts them.
                let is_label = row.get(0).is_some_and(|label| label.ends_with(':'));
                let shift = usize::from(is_label && row.len() == self.columns() + 1);
                let cells = |row: &StringRecord| row.iter().skip(shift).map(brief).collect();
                let is_short =
                    |row: &&&StringRecord| filled(row).all(|cell| cell.1.len() <= UNIT_LENGTH);
                let units = between.iter().find(|row| is_units(row));
                let units = units.or_else(|| between.iter().find(is_short));
                headings.push(Heading {
                    line: *line,
                    names: cells(row),
                    units: units.map(|row| cells(row)).unwrap_or_default(),
                });
            }
            between.push(row);
        }
        headings
    }

    /// Names that stand below each other, one a column: `Sig2⇥Temperature (°C)`, as TA's Q series writes them.
    fn signals(&self) -> Option<Heading> {
        let signals = self.above.iter().filter_map(|(line, row)| {
            let number: usize = row.get(0)?.strip_prefix("Sig")?.parse().ok()?;
            Some((*line, number, brief(row.get(1)?)))
        });
        let signals: Vec<(u64, usize, String)> = signals.collect();
        let mut numbers = signals.iter().map(|signal| signal.1);
        let is_each = numbers.by_ref().eq(1..=self.columns());
        is_each.then(|| Heading {
            line: signals[0].0,
            names: signals.into_iter().map(|signal| signal.2).collect(),
            units: Vec::new(),
        })
    }

    /// The first of these lines of names that a choice takes, and the choice; else why the one with the most names is not taken, if there is one.
    pub(super) fn headed<T>(
        &self,
        headings: Vec<Heading>,
        mut choose: impl FnMut(&Heading) -> Result<T, String>,
    ) -> Result<(Heading, T), Option<(usize, TableError)>> {
        let mut refused: Option<(usize, TableError)> = None;
        for heading in headings {
            let names = heading.names.len();
            match choose(&heading) {
                Ok(taken) => return Ok((heading, taken)),
                Err(why) if refused.as_ref().is_none_or(|(most, _)| names > *most) => {
                    refused = Some((names, wrong(heading.line, &why)));
                }
                Err(_) => {}
            }
        }
        Err(refused)
    }

    /// Cells above columns of numbers, with a label in front or without.
    fn names_above(&self, row: &StringRecord) -> usize {
        let shift = row.len().saturating_sub(self.columns()).min(1);
        let is_named = |place: &usize| {
            let has = |place: usize| row.get(place).is_some_and(|name| !name.is_empty());
            has(*place) || has(place + shift)
        };
        self.numeric.iter().filter(|place| is_named(place)).count()
    }

    /// True of a line that may name the columns: mostly words, no dates and no numbers.
    fn has_names(&self, row: &StringRecord) -> bool {
        let is_word = |cell: &(usize, &str)| !cell.1.starts_with(|c: char| c.is_ascii_digit());
        let least = self.width().div_ceil(2);
        self.names_above(row) >= least
            && 2 * filled(row).filter(is_word).count() >= filled(row).count().max(2 * least)
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
        if let Some(label) = &self.label {
            return Some(brief(label));
        }
        const WORDS: &str = "step, interval, segment, sweep, set, cycle, abschnitt, temperature, test, result, specimen, sheet";
        let above = self.above.iter().rev();
        let lines = above.filter(|(line, _)| *line < heading.line);
        let mut texts = lines.take(LINES).map(|(_, row)| {
            let cells: Vec<&str> = filled(row).map(|cell| cell.1).collect();
            match cells[..] {
                // `Step name: Frequency sweep` is the name behind its key.
                [key, value] if key.to_lowercase().contains("name") => brief(value),
                _ => brief(&cells.join(" ")),
            }
        });
        texts.find(|text| {
            let text = text.to_lowercase();
            !text.starts_with('[') && WORDS.split(", ").any(|word| text.contains(word))
        })
    }
}
