//! `KEY=VALUE`, as `device set` and `device emulate` take it.

use crate::parse::{outside, read_whole};
use haptic_document::short;
use haptic_experiment::Failure;
use haptic_experiment::parameters::Range;
use haptic_quantity::{did_you_mean, doubt, is_meant, parse_for_key, without_unit};
use std::fmt::Display;

/// The key that is meant, with its unit or without, and its value.
///
/// # Errors
/// Not `KEY=VALUE`, or another key.
pub(super) fn key_and_value(
    word: &str,
    keys: impl IntoIterator<Item = &'static str>,
) -> Result<(&'static str, &str), Failure> {
    let (name, text) = word
        .split_once('=')
        .ok_or_else(|| refused(word, "is not KEY=VALUE, as force_limit=0.5N"))?;
    let keys: Vec<&str> = keys.into_iter().collect();
    let key = keys.iter().find(|key| is_meant(key, name));
    let known = keys.iter().map(|key| without_unit(key));
    let why = || format!("does not name a parameter: {}", did_you_mean(name, known));
    let key = key.ok_or_else(|| refused(word, &why()))?;
    Ok((key, text.trim()))
}

pub(super) fn refused(word: &str, why: &str) -> Failure {
    let gap = if why.starts_with(':') { "" } else { " " };
    Failure::bad_input(format_args!("{}{gap}{why}", short(word)))
}

pub(super) fn keys_help(keys: impl IntoIterator<Item = (&'static str, &'static str)>) -> String {
    let lines = keys
        .into_iter()
        .map(|(key, help)| format!("\n  {:<18} {help}", without_unit(key)));
    lines.collect()
}

pub(super) fn in_range(key: &str, range: Range, text: &str) -> Result<f64, String> {
    doubt(key, text).map_err(|why| format!(": {why}"))?;
    let value = parse_for_key(key, text).map_err(|error| format!(": {error}"))?;
    if range.contains(value) {
        Ok(value)
    } else {
        Err(outside(key, range))
    }
}

pub(super) fn count<T: TryFrom<u64> + PartialOrd + Display>(
    text: &str,
    least: T,
    most: T,
) -> Result<T, String> {
    let count = read_whole(text).and_then(|count| T::try_from(count).ok());
    let count = count.filter(|count| (&least..=&most).contains(&count));
    count.ok_or_else(|| format!("is not a whole number from {least} to {most}"))
}
