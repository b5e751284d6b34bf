//! Names of keys in sentences: the options of the command that was typed.

use haptic_quantity::without_unit;
use std::collections::BTreeSet;
use std::sync::LazyLock;

/// The name of the option of a key.
pub(crate) fn option_of(key: &str) -> String {
    without_unit(key).replace('_', "-")
}

/// Names of keys whose option is called otherwise.
const OTHERWISE: [(&str, &str); 4] = [
    ("branches", "prony"),
    ("iso_damping", "not-flat"),
    ("output_high", "output-limits"),
    ("output_low", "output-limits"),
];

/// The options of a command, by which its sentences name keys: `--sample-time`. A key without one is named by itself, `` `seed` ``, as
/// `KEY=VALUE` and files have it.
#[derive(Debug)]
pub(crate) struct Names(LazyLock<BTreeSet<String>>);

impl Names {
    /// `command` is asked when the first sentence names a key, so that a start without one builds no second parser.
    pub(crate) const fn of(command: fn() -> BTreeSet<String>) -> Self {
        Self(LazyLock::new(command))
    }

    /// The option of a key, with its hyphens.
    pub(crate) fn of_key(&self, key: &str) -> Option<String> {
        let otherwise = OTHERWISE.iter().find(|(known, _)| *known == key);
        let option = otherwise.map_or_else(|| option_of(key), |(_, option)| (*option).to_owned());
        self.0.contains(&option).then(|| format!("--{option}"))
    }
}
