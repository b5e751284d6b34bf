//! `KEY=VALUE`, as `device set` and `device emulate` take it.

use haptic_experiment::Failure;
use haptic_experiment::document::short;
use haptic_experiment::parameters::Range;
use haptic_quantity::{is_meant, parse_for_key, without_unit, written};

/// The key that is meant, with its unit or without, and its value.
///
/// # Errors
/// Not `KEY=VALUE`, or another key.
pub(super) fn key_and_value<'w>(
    word: &'w str,
    keys: impl IntoIterator<Item = &'static str>,
    command: &str,
) -> Result<(&'static str, &'w str), Failure> {
    let (name, text) = word
        .split_once('=')
        .ok_or_else(|| refused(word, "is not KEY=VALUE"))?;
    let key = keys.into_iter().find(|key| is_meant(key, name));
    let key = key.ok_or_else(|| {
        refused(
            word,
            &format!("does not name a parameter: host-cli device {command} --help lists them"),
        )
    })?;
    Ok((key, text.trim()))
}

/// What is wrong with a word.
pub(super) fn refused(word: &str, why: &str) -> Failure {
    let gap = if why.starts_with(':') { "" } else { " " };
    Failure::bad_input(format_args!("{}{gap}{why}", short(word)))
}

/// The key that is called like an option: of `force-limit` `force_limit`.
pub(super) fn key_like(
    option: &str,
    keys: impl IntoIterator<Item = &'static str>,
) -> Option<&'static str> {
    let name = option.replace('-', "_");
    keys.into_iter().map(without_unit).find(|key| *key == name)
}

/// Keys with their help, a line each.
pub(super) fn keys_help(keys: impl IntoIterator<Item = (&'static str, &'static str)>) -> String {
    let lines = keys
        .into_iter()
        .map(|(key, help)| format!("\n  {:<18} {help}", without_unit(key)));
    lines.collect()
}

/// A number in a range.
pub(super) fn in_range(key: &str, range: Range, text: &str) -> Result<f64, String> {
    let value = parse_for_key(key, text).map_err(|error| format!(": {error}"))?;
    let [low, high] = range.ends().map(|end| match end {
        0.0 => "0".to_owned(),
        end => written(key, end),
    });
    match (range.contains(value), range) {
        (true, _) => Ok(value),
        (false, Range::Within(..)) => Err(format!("is not from {low} to {high}")),
        (false, Range::AboveUpTo(..)) => Err(format!("is not above {low} and at most {high}")),
    }
}
