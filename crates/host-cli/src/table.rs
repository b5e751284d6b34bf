//! Tables of numbers from files and standard input: one reader for every command.

use haptic_experiment::Failure;
use haptic_experiment::document::short;
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
    names: [&str; N],
    remedy: &str,
) -> Result<(Vec<u64>, [Vec<f64>; N]), Failure> {
    let found = read_columns(&bytes(path)?, names);
    found.map_err(|error| {
        let error = error.to_string();
        wrong(path, format_args!("{}; {remedy}", short(&error)))
    })
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
