//! A column of numbers out of a CSV file that nobody has checked.

use csv::{Reader, StringRecord};
use haptic_experiment::Failure;
use haptic_experiment::document::{Rows, short};
use std::io::Read;

/// All samples are in memory, input and output.
const SAMPLES_MOST: usize = 100_000_000;

/// A column that was found in a header.
struct Column<'a> {
    /// Of the source, for messages.
    source: &'a str,
    name: &'a str,
    place: usize,
    /// Cells of the header.
    width: usize,
}

/// The numbers of a column, at least one; `source_name` is for messages.
///
/// # Errors
/// A missing column, a missing or non-numeric cell, with its line.
pub fn read(source: impl Read, source_name: &str, wanted: &str) -> Result<Vec<f64>, Failure> {
    read_named(source, source_name, wanted, "give --column one of them")
}

/// The same; `remedy` is what to do about a missing column.
///
/// # Errors
/// As [`read`].
pub fn read_named(
    source: impl Read,
    source_name: &str,
    wanted: &str,
    remedy: &str,
) -> Result<Vec<f64>, Failure> {
    let bad = |text: String| Failure::bad_input(format_args!("{source_name}: {text}"));
    let (rows, length) = Rows::new(source);
    let mut table = csv::ReaderBuilder::new()
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(rows);
    let header = table.headers().map_err(|error| bad(error.to_string()))?;
    let column = Column::find(header, source_name, wanted, remedy)?;
    let mut x = Vec::new();
    let mut row = StringRecord::new();
    while table
        .read_record(&mut row)
        .map_err(|error| bad(error.to_string()))?
    {
        length.next_row();
        if x.len() == SAMPLES_MOST {
            return Err(bad(format!(
                "more than {SAMPLES_MOST} rows below the header; cut the input into pieces"
            )));
        }
        x.push(column.value(&row, &table)?);
    }
    if x.is_empty() {
        return Err(bad(
            "no rows below the header; there is nothing to do".to_owned()
        ));
    }
    Ok(x)
}

impl<'a> Column<'a> {
    fn find(
        header: &StringRecord,
        source: &'a str,
        name: &'a str,
        remedy: &str,
    ) -> Result<Self, Failure> {
        let shown = short(name);
        let bad = |text: String| Failure::bad_input(format_args!("{source}: {text}"));
        if header.is_empty() {
            return Err(bad(format!(
                "the input is empty; give a header with a column {shown} and a number in each row"
            )));
        }
        let mut places = (0..header.len()).filter(|&place| &header[place] == name);
        let place = places.next().ok_or_else(|| {
            let names: Vec<&str> = header.iter().collect();
            bad(format!(
                "line 1: no column {shown} in the header {:?}; {remedy}",
                short(&names.join(","))
            ))
        })?;
        if places.next().is_some() {
            return Err(bad(format!(
                "line 1: more than one column is named {shown}; rename all but the one to take"
            )));
        }
        Ok(Self {
            source,
            name,
            place,
            width: header.len(),
        })
    }

    /// The number in a row; `table` has just read it.
    fn value<R: Read>(&self, row: &StringRecord, table: &Reader<R>) -> Result<f64, Failure> {
        let (shown, width) = (short(self.name), self.width);
        let line = row.position().map_or(0, csv::Position::line);
        let bad =
            |text: String| Failure::bad_input(format_args!("{}: line {line}: {text}", self.source));
        // The reader skips empty lines before a row; a row's own lines are one and those in its cells.
        let breaks: usize = row.iter().map(|cell| cell.matches('\n').count()).sum();
        let skipped = table.position().line() > line + 1 + breaks as u64;
        if row.len() > width {
            return Err(bad(format!(
                "{} cells under a header of {width}; is a comma meant as a decimal point?",
                row.len()
            )));
        }
        let cell = row.get(self.place).unwrap_or("");
        if cell.is_empty() || skipped {
            return Err(bad(format!(
                "no value in column {shown}; give a number in every row"
            )));
        }
        let value: Option<f64> = cell.parse().ok();
        value.filter(|value| value.is_finite()).ok_or_else(|| {
            bad(format!(
                "{:?} in column {shown} is not a finite number",
                short(cell)
            ))
        })
    }
}
