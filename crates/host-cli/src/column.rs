//! A column of numbers out of a CSV file that nobody has checked.

use csv::StringRecord;
use haptic_experiment::Failure;
use haptic_experiment::document::{Rows, short};
use std::io::Read;

/// All samples are in memory, input and output.
const SAMPLES_MOST: usize = 100_000_000;

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
    let shown = short(wanted);
    let (rows, length) = Rows::new(source);
    let mut table = csv::ReaderBuilder::new()
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(rows);
    let header = table.headers().map_err(|error| bad(error.to_string()))?;
    if header.is_empty() {
        return Err(bad(format!(
            "the input is empty; give a header with a column {shown} and a number in each row"
        )));
    }
    let width = header.len();
    let mut places = (0..width).filter(|&place| &header[place] == wanted);
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
        let line = row.position().map_or(0, csv::Position::line);
        let bad = |text: String| bad(format!("line {line}: {text}"));
        // The reader skips empty lines before a row; a row's own lines are one and those in its cells.
        let breaks: usize = row.iter().map(|cell| cell.matches('\n').count()).sum();
        let skipped = table.position().line() > line + 1 + breaks as u64;
        if row.len() > width {
            return Err(bad(format!(
                "{} cells under a header of {width}; is a comma meant as a decimal point?",
                row.len()
            )));
        }
        let cell = row.get(place).unwrap_or("");
        if cell.is_empty() || skipped {
            return Err(bad(format!(
                "no value in column {shown}; give a number in every row"
            )));
        }
        let value: Option<f64> = cell.parse().ok();
        x.push(value.filter(|value| value.is_finite()).ok_or_else(|| {
            bad(format!(
                "{:?} in column {shown} is not a finite number",
                short(cell)
            ))
        })?);
    }
    if x.is_empty() {
        return Err(bad(
            "no rows below the header; there is nothing to do".to_owned()
        ));
    }
    Ok(x)
}
