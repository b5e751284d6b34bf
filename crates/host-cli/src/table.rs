//! Tables of numbers from files and standard input: one reader for every command.

use haptic_experiment::Failure;
use haptic_experiment::document::short;
use haptic_tissue::identify::table::{TABLE_MOST, read_columns};
use haptic_tissue::read_bytes;
use std::io::{self, Read};
use std::path::Path;

/// Columns of numbers of a table, and the line of each row.
pub(crate) struct Table<const N: usize> {
    pub(crate) lines: Vec<u64>,
    pub(crate) columns: [Vec<f64>; N],
}

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

/// The columns of these names; `remedy` says how to name others.
pub(crate) fn read<const N: usize>(
    path: &Path,
    names: [&str; N],
    remedy: &str,
) -> Result<Table<N>, Failure> {
    let found = read_columns(&bytes(path)?, names);
    let (lines, columns) = found.map_err(|error| {
        wrong(
            path,
            format_args!("{}; {remedy}", short(&error.to_string())),
        )
    })?;
    Ok(Table { lines, columns })
}

/// What is wrong with a table, behind its name.
pub(crate) fn wrong(path: &Path, what: impl std::fmt::Display) -> Failure {
    match path.as_os_str() == "-" {
        true => Failure::bad_input(format_args!("standard input: {what}")),
        false => Failure::bad_input(format_args!("{}: {what}", path.display())),
    }
}
