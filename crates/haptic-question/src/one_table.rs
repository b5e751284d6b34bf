//! One table of a text, for tests.

use haptic_document::parameters::Parameter;
use haptic_document::{Document, Table};
use haptic_trial::device_table::with_devices;
use std::path::Path;

/// Reads the one table of a text, with these keys.
pub(crate) fn read<T, E: std::fmt::Debug>(
    text: &str,
    (kind, keys): (&str, &[(&str, &[Parameter])]),
    of: impl FnOnce(&Table<'_>) -> Result<T, E>,
) -> T {
    let document = Document::of_text(Path::new("form"), text);
    let document = document.parse().expect("TOML");
    let found = document.one_of(&[kind], &[], "question", "one table");
    let (_, table, _) = found.expect("its table");
    let table = with_devices(table.with_keys(keys).expect("known keys")).expect("its device");
    of(&table).expect("good values")
}
