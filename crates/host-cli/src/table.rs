//! Tables of numbers from files and standard input: one reader for every command.

use haptic_experiment::Failure;
use haptic_experiment::document::short;
use haptic_quantity::written;
use haptic_tissue::identify::table::{RecordColumns, TABLE_MOST, read_columns, read_record};
use haptic_tissue::read_bytes;
use std::io::{self, Read};
use std::path::Path;

/// The bytes of a table, `-` for those of standard input; no more than a table may have.
pub(crate) fn bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    let read = match path.as_os_str() == "-" {
        true => {
            let mut bytes = Vec::new();
            let input = io::stdin()
                .lock()
                .take(TABLE_MOST + 1)
                .read_to_end(&mut bytes);
            input.map(|_| bytes)
        }
        false => read_bytes(path, TABLE_MOST),
    };
    let name = path.display();
    read.map_err(|error| {
        Failure::bad_input(format_args!(
            "cannot read `{name}`: {error}; give the path of a table"
        ))
    })
}

/// The line of each row and the columns of these names; `remedy` says how to name others.
pub(crate) fn read<const N: usize>(
    path: &Path,
    bytes: &[u8],
    names: [&str; N],
    remedy: &str,
) -> Result<(Vec<u64>, [Vec<f64>; N]), Failure> {
    let found = read_columns(bytes, names);
    found.map_err(|error| {
        let error = error.to_string();
        wrong(path, format_args!("{}; {remedy}", short(&error)))
    })
}

/// Refuses a sample time other than the steps of the table's time, if it has one beside this column: by half a step over all rows, as far
/// as rounding goes, and 1 %, as far as a clock may be off.
pub(crate) fn check_steps(
    path: &Path,
    bytes: &[u8],
    column: &str,
    sample_time_s: f64,
) -> Result<(), Failure> {
    let Ok(RecordColumns { columns, .. }) = read_record(bytes, ["time_s", column]) else {
        return Ok(());
    };
    let (time_s, steps) = (&columns[0], columns[0].len() as f64 - 1.0);
    let span_s = time_s[time_s.len() - 1] - time_s[0];
    let off_s = (span_s - steps * sample_time_s).abs();
    if off_s <= (0.5 + 0.01 * steps) * sample_time_s {
        return Ok(());
    }
    let [table, given] = [span_s / steps, sample_time_s].map(|time| written("sample_time_s", time));
    Err(wrong(
        path,
        format_args!(
            "time runs in steps of {table}, not of --sample-time {given}: change --sample-time, or correct the column of time"
        ),
    ))
}

/// Time and signals of a record, whose gaps are NaN.
pub(crate) fn record<const N: usize>(
    path: &Path,
    names: [&str; N],
    remedy: &str,
) -> Result<RecordColumns<N>, Failure> {
    let found = read_record(&bytes(path)?, names);
    found.map_err(|error| {
        let error = error.to_string();
        wrong(path, format_args!("{}; {remedy}", short(&error)))
    })
}

/// What is wrong with a table, behind its name.
pub(crate) fn wrong(path: &Path, what: impl std::fmt::Display) -> Failure {
    Failure::bad_input(match path.as_os_str() == "-" {
        true => format!("standard input: {what}"),
        false => format!("{}: {what}", path.display()),
    })
}
