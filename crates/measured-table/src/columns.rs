//! Columns of numbers in SI units, out of one segment of a table.

use super::column::Column;

/// Columns of numbers in SI units, all of one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// Lines of the samples, for messages.
    pub lines: Vec<u64>,
    /// The columns with their names.
    pub values: Vec<(Column, String, Vec<f64>)>,
    /// Errors beside columns of `values`: the measured column, the name of that of the errors, and its numbers in the same unit.
    pub errors: Vec<(Column, String, Vec<f64>)>,
    /// Those that a user named: they come first, and each must have an effect.
    pub chosen: Vec<Column>,
    /// One sentence for each thing guessed, converted or left out, for the user to check.
    pub notes: Vec<String>,
    /// Quantities that more than one header could be, and the sentence that asks which: an error of a record that uses one.
    pub unclear: Vec<(Column, String)>,
    /// The name of the segment, of a file with several.
    pub segment: Option<String>,
    /// Its temperature, °C, if a column or its name says it.
    pub temperature_c: Option<f64>,
    /// Lines of rows that are left out because of a cell that is not a number; `None` unless such rows are to be left out.
    pub bad: Option<Vec<u64>>,
}

impl Columns {
    /// Joins segments of a motion whose clock continues over them, as creep and its recovery.
    #[must_use]
    pub fn joined(all: Vec<Self>) -> Vec<Self> {
        let mut joined: Vec<Self> = Vec::new();
        for one in all {
            match joined.last_mut().filter(|before| before.goes_on_in(&one)) {
                Some(before) => before.extend(one),
                None => joined.push(one),
            }
        }
        joined
    }

    fn goes_on_in(&self, next: &Self) -> bool {
        let clock = |columns: &Self, at: fn(&[f64]) -> Option<&f64>| {
            let time = columns
                .values
                .iter()
                .find(|value| value.0 == Column::Time)?;
            at(&time.2).copied()
        };
        let ends = clock(self, <[f64]>::last).zip(clock(next, <[f64]>::first));
        let has = |a, b| self.has(a) || self.has(b);
        let is_motion = has(Column::Strain, Column::Position) && has(Column::Stress, Column::Force);
        let headings = |all: &Self| {
            let columns = all.values.iter().chain(&all.errors);
            columns.map(|value| value.0).collect::<Vec<_>>()
        };
        is_motion
            && headings(self) == headings(next)
            && ends.is_some_and(|(end, begin)| begin > end)
    }

    fn extend(&mut self, next: Self) {
        let columns = self.values.iter_mut().chain(&mut self.errors);
        for (value, (_, _, values)) in columns.zip(next.values.into_iter().chain(next.errors)) {
            value.2.extend(values);
        }
        self.lines.extend(next.lines);
        let names = [&self.segment, &next.segment].map(|name| name.clone().unwrap_or_default());
        self.notes.push(format!(
            "segment {} goes on on the clock of {}: both are one motion",
            names[1], names[0]
        ));
        self.segment = Some(names.join(" + "));
        self.temperature_c = self
            .temperature_c
            .filter(|_| self.temperature_c == next.temperature_c);
    }

    /// True if there is a column of this quantity.
    #[must_use]
    pub fn has(&self, column: Column) -> bool {
        self.values.iter().any(|value| value.0 == column)
    }
}
