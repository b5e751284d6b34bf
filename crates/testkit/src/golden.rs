//! The tables of `tests/golden`, made with many digits by the scripts beside them.

use std::path::Path;

/// The cells of each line but the first, which names the columns.
///
/// # Panics
/// Without such a file.
#[must_use]
pub fn cells(name: &str) -> Vec<Vec<String>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden");
    let file = folder.join(name);
    let text = std::fs::read_to_string(&file)
        .unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let lines = text.lines().skip(1);
    lines
        .map(|line| line.split(',').map(str::to_owned).collect())
        .collect()
}

/// Numbers in the cells of each line, read as by [`cells`].
///
/// # Panics
/// If one is not.
#[must_use]
pub fn rows(name: &str) -> Vec<Vec<f64>> {
    let number = |cell: &String| cell.parse().expect("a number");
    let rows = cells(name).into_iter();
    rows.map(|cells| cells.iter().map(number).collect())
        .collect()
}
