//! Tables of numbers from files and standard input: one reader for every command.

use crate::mcap;
use haptic_experiment::Failure;
use haptic_quantity::written;
use measured_table::{RecordColumns, TABLE_MOST, read_bytes};
use std::fmt::Display;
use std::io::{self, Read};
use std::path::Path;

/// The bytes of a table, `-` for those of standard input; no more than a table may have.
pub(crate) fn bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    let read = if path.as_os_str() == "-" {
        let mut bytes = Vec::new();
        let input = io::stdin()
            .lock()
            .take(TABLE_MOST + 1)
            .read_to_end(&mut bytes);
        input.map(|_| bytes)
    } else {
        read_bytes(path, TABLE_MOST)
    };
    let name = path.display();
    read.map_err(|error| {
        Failure::bad_input(format_args!(
            "cannot read `{name}`: {error}; give the path of a table"
        ))
    })
}

/// The bytes of a table or a log; names of the log's columns become those of the table.
pub(crate) fn bytes_with(path: &Path, names: Vec<&mut String>) -> Result<Vec<u8>, Failure> {
    match mcap::table(path, names)? {
        Some(table) => Ok(table),
        None => bytes(path),
    }
}

/// The row whose step is off the most, if that is more than a millionth and more than the rounding to the last digit explains.
///
/// Refused: times that do not rise; even steps other than this sample time, by half a step over all rows, as far as rounding goes, and 1 %, as far as a clock may be off.
pub(crate) fn uneven_row(
    path: &Path,
    record: &RecordColumns<2>,
    sample_time_s: f64,
) -> Result<Option<usize>, Failure> {
    let time_s = &record.columns[0];
    if time_s.len() < 2 {
        return Ok(None);
    }
    let after = |row: usize| time_s[row] - time_s[row - 1];
    let rows = 1..time_s.len();
    if let Some(row) = rows.clone().find(|&row| after(row) <= 0.0) {
        let [before, now] = [row - 1, row].map(|row| written("time_s", time_s[row]));
        let line = record.lines[row];
        let what = format_args!(
            "line {line}: {now} does not come after {before}: sort the rows by time, and keep one row per time"
        );
        return Err(wrong(path, what));
    }
    let (first, last) = (time_s[0], time_s[time_s.len() - 1]);
    let steps = rows.len() as f64;
    let step = (last - first) / steps;
    // Even times that were rounded to a digit have steps less than that digit away from their mean.
    let coarsest = libm::log10(0.5 * step).floor() as i32;
    let is_multiple = |time: &f64, digit: f64| (time / digit - (time / digit).round()).abs() < 1e-6;
    let digit = (coarsest - 6..=coarsest)
        .rev()
        .map(|power| libm::exp10(f64::from(power)))
        .find(|&digit| time_s.iter().all(|time| is_multiple(time, digit)));
    let allowed = (0.999 * digit.unwrap_or(0.0))
        .max(1e-6 * step)
        .max(4.0 * f64::EPSILON * last.abs().max(first.abs()));
    let off = |row: &usize| (after(*row) - step).abs();
    let worst = rows.max_by(|a, b| off(a).total_cmp(&off(b)));
    let uneven = worst.filter(|row| off(row) > allowed);
    if uneven.is_some()
        || (step - sample_time_s).abs() * steps <= (0.5 + 0.01 * steps) * sample_time_s
    {
        return Ok(uneven);
    }
    let [table, given] = [step, sample_time_s].map(|time| written("sample_time_s", time));
    Err(wrong(
        path,
        format_args!(
            "time runs in steps of {table}, not of --sample-time {given}: change --sample-time, or correct the column of time"
        ),
    ))
}

/// Reads a table or a log with columns of these names; an error has the name of the file.
pub(crate) fn read<T, E: Display, const N: usize>(
    path: &Path,
    mut columns: [String; N],
    read: impl FnOnce(&[String; N], &[u8]) -> Result<T, E>,
) -> Result<T, Failure> {
    let bytes = bytes_with(path, columns.iter_mut().collect())?;
    read(&columns, &bytes).map_err(|error| wrong(path, error))
}

/// An error in a table, behind its name.
pub(crate) fn wrong(path: &Path, what: impl Display) -> Failure {
    Failure::bad_input(if path.as_os_str() == "-" {
        format!("standard input: {what}")
    } else {
        format!("{}: {what}", path.display())
    })
}
