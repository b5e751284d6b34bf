//! A table of text as columns of numbers in SI units.

use super::super::error::IdentifyError;
use super::assemble::Columns;
use super::column::{Choice, Column};
use super::header::{Heading, remedy, split, understand};
use super::text::{TextTable, is_gap, number, passed, too_many, wrong};
use crate::identify::keys::{COLUMNS, UNITS};

/// The user's instructions for a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reader {
    /// Columns by place or name.
    pub columns: Vec<(Column, Choice)>,
    /// Units that headers omit or get wrong.
    pub units: Vec<(Column, String)>,
    /// First time (or angular frequency).
    pub from: Option<f64>,
    /// Last time (or angular frequency).
    pub to: Option<f64>,
}

struct Found {
    column: Column,
    place: usize,
    name: String,
    /// SI units per unit; `None` until known.
    factor: Option<f64>,
}

impl Reader {
    /// Columns with quantities of a record.
    ///
    /// # Errors
    /// Two columns of one quantity, a wrong unit, a cell that is not a number, with line and column.
    pub fn read(&self, mut table: TextTable) -> Result<Columns, IdentifyError> {
        let mut notes = Vec::new();
        if table.header.iter().all(|cell| number(cell).is_some()) {
            self.without_header(&mut table)?;
        }
        let mut found = self.find(&table)?;
        self.units(&mut table, &mut found, &mut notes)?;
        let mut columns = Columns {
            values: found
                .iter()
                .map(|f| (f.column, f.name.clone(), Vec::new()))
                .collect(),
            chosen: self.columns.iter().map(|(column, _)| *column).collect(),
            ..Columns::default()
        };
        let (mut empty, mut outside) = (Vec::new(), Vec::new());
        for (line, row) in &table.rows {
            let Some(values) = self.row(&table, *line, row, &found)? else {
                empty.push(*line);
                continue;
            };
            let clock = found
                .iter()
                .position(|f| matches!(f.column, Column::Time | Column::Omega));
            let at = clock.map_or(0.0, |column| values[column]);
            if self.from.is_some_and(|from| at < from) || self.to.is_some_and(|to| at > to) {
                outside.push(*line);
                continue;
            }
            columns.lines.push(*line);
            for (column, value) in columns.values.iter_mut().zip(values) {
                column.2.push(value);
            }
        }
        notes.extend(passed(&empty, "a cell without a number"));
        notes.extend(passed(&outside, "outside the range asked for"));
        if columns.lines.is_empty() {
            return Err(IdentifyError::Record(
                "no row with numbers is left: give at least one more than the model has parameters"
                    .to_owned(),
            ));
        }
        columns.notes = notes;
        Ok(columns)
    }

    /// A table without a header: columns must be named by number.
    fn without_header(&self, table: &mut TextTable) -> Result<(), IdentifyError> {
        let numbered = self
            .columns
            .iter()
            .any(|choice| matches!(choice.1, Choice::Number(_)));
        if !numbered {
            return Err(wrong(
                table.header_line,
                &format!("there is no header: add one, or give {COLUMNS}, as in time=1,modulus=2"),
            ));
        }
        let names = (1..=table.header.len())
            .map(|n| format!("column {n}"))
            .collect();
        let first = std::mem::replace(&mut table.header, names);
        table
            .rows
            .insert(0, (table.header_line, first.into_iter().collect()));
        Ok(())
    }

    /// Columns that a user named, then those with a known header.
    fn find(&self, table: &TextTable) -> Result<Vec<Found>, IdentifyError> {
        let mut found: Vec<Found> = Vec::new();
        for (column, choice) in &self.columns {
            let place = place(table, choice)?;
            let heading = understand(&table.header[place]).and_then(Result::ok);
            let unit = split(&table.header[place])
                .1
                .and_then(|unit| column.dimension().factor(&unit));
            found.push(Found {
                column: *column,
                place,
                name: table.header[place].clone(),
                factor: unit.or_else(|| {
                    heading
                        .filter(|h| h.column == *column)
                        .and_then(|h| h.factor)
                }),
            });
        }
        let given = found.len();
        for (place, name) in table.header.iter().enumerate() {
            if found.iter().any(|f| f.place == place) {
                continue;
            }
            let Some(Heading { column, factor }) = self.heading(table, name)? else {
                continue;
            };
            match found.iter().position(|f| f.column == column) {
                Some(other) if other < given => {}
                Some(other) => {
                    return Err(wrong(
                        table.header_line,
                        &format!(
                            "the columns {} and {name} both look like {}: give {COLUMNS} {}=NAME",
                            found[other].name,
                            column.name(),
                            column.name()
                        ),
                    ));
                }
                None => found.push(Found {
                    column,
                    place,
                    name: name.clone(),
                    factor,
                }),
            }
        }
        Ok(found)
    }

    /// A known header; a wrong unit is refused unless another is given.
    fn heading(&self, table: &TextTable, name: &str) -> Result<Option<Heading>, IdentifyError> {
        match understand(name) {
            None => Ok(None),
            Some(Ok(heading)) => Ok(Some(heading)),
            Some(Err(foreign)) if self.unit_of(foreign.column).is_some() => Ok(Some(Heading {
                column: foreign.column,
                factor: None,
            })),
            Some(Err(foreign)) => Err(IdentifyError::Line {
                line: table.header_line,
                column: Some(name.to_owned()),
                reason: format!(
                    "unit {:?} is not a unit of {}: {}",
                    foreign.unit,
                    foreign.column.name(),
                    remedy(foreign.column.dimension(), foreign.column)
                ),
            }),
        }
    }

    fn unit_of(&self, column: Column) -> Option<&str> {
        let unit = self.units.iter().find(|unit| unit.0 == column);
        unit.map(|unit| unit.1.as_str())
    }

    /// Units: the user's, a row of units below the header, else SI with a note.
    fn units(
        &self,
        table: &mut TextTable,
        found: &mut [Found],
        notes: &mut Vec<String>,
    ) -> Result<(), IdentifyError> {
        let factor = |column: Column, unit: &str| {
            column.dimension().factor(unit).ok_or_else(|| {
                IdentifyError::Record(format!(
                    "unit {unit:?} is not a unit of {}: {}",
                    column.name(),
                    remedy(column.dimension(), column)
                ))
            })
        };
        let row = table.rows.first().filter(|(_, row)| {
            let mut cells = found.iter().map(|f| row.get(f.place).unwrap_or(""));
            !found.is_empty() && cells.all(|cell| number(cell).is_none())
        });
        let below = row.map(|(_, row)| row.clone());
        if below.is_some() {
            table.rows.remove(0);
        }
        for f in found {
            let cell = below.as_ref().and_then(|row| row.get(f.place));
            let cell = cell.map(|cell| cell.trim_matches(['[', ']', '(', ')']).trim());
            if let Some(unit) = self.unit_of(f.column) {
                let given = factor(f.column, unit)?;
                let unit_below = match cell.filter(|cell| !cell.is_empty()) {
                    Some(unit_below) => Some(factor(f.column, unit_below)?),
                    None => f.factor,
                };
                if unit_below.is_some_and(|unit_below| (unit_below / given - 1.0).abs() > 1e-9) {
                    return Err(IdentifyError::Record(format!(
                        "column {} names its own unit: omit {}={unit} of {UNITS}",
                        f.name,
                        f.column.name()
                    )));
                }
                f.factor = Some(given);
            } else if let Some(unit) = cell.filter(|cell| !cell.is_empty()) {
                f.factor = Some(factor(f.column, unit)?);
            } else if f.factor.is_none() {
                f.factor = Some(1.0);
                if f.column != Column::Strain {
                    notes.push(format!(
                        "column {} names no unit: taken as {}",
                        f.name,
                        f.column.dimension().si()
                    ));
                }
            }
        }
        Ok(())
    }

    /// The numbers of a row in SI; `None` if a cell is empty.
    fn row(
        &self,
        table: &TextTable,
        line: u64,
        row: &csv::StringRecord,
        found: &[Found],
    ) -> Result<Option<Vec<f64>>, IdentifyError> {
        let mut values = Vec::with_capacity(found.len());
        if row.len() > table.header.len() {
            return Err(wrong(line, &too_many(row, table.header.len())));
        }
        for f in found {
            let cell = row.get(f.place).unwrap_or("");
            if is_gap(cell) {
                return Ok(None);
            }
            let value = number(cell).ok_or_else(|| IdentifyError::Line {
                line,
                column: Some(f.name.clone()),
                reason: format!("{cell:?} is not a finite number: correct it, or omit the row"),
            })?;
            values.push(value * f.factor.unwrap_or(1.0));
        }
        Ok(Some(values))
    }
}

fn place(table: &TextTable, choice: &Choice) -> Result<usize, IdentifyError> {
    let found = match choice {
        Choice::Number(n) => (1..=table.header.len()).contains(n).then(|| n - 1),
        Choice::Name(name) => {
            let same =
                |header: &String| header == name || split(header).0.eq_ignore_ascii_case(name);
            table.header.iter().position(same)
        }
    };
    found.ok_or_else(|| {
        let wanted = match choice {
            Choice::Number(n) => n.to_string(),
            Choice::Name(name) => format!("\"{name}\""),
        };
        wrong(
            table.header_line,
            &format!(
                "there is no column {wanted}: give {COLUMNS} one of 1 to {} or of {}",
                table.header.len(),
                table.header.join(", ")
            ),
        )
    })
}
