//! Keys in sentences.

use crate::without_unit;
use std::fmt;
use strsim::levenshtein;

/// A key of a document or an argument of a function, as a sentence names it: `` `sample_time_s` ``. A program that calls it
/// otherwise has it [`renamed`].
///
/// ```
/// use haptic_quantity::{Key, renamed};
///
/// let sentence = format!("give {}, or omit {}", Key("loop").set_to("host"), Key("strain"));
/// assert_eq!(sentence, "give `loop` = host, or omit `strain`");
/// let options = |key: &str| (key == "loop").then(|| "--loop".to_owned());
/// assert_eq!(renamed(&sentence, options), "give --loop host, or omit `strain`");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key(pub &'static str);

impl Key {
    /// A key and the value that it is to have.
    #[must_use]
    pub fn set_to<V: fmt::Display>(self, value: V) -> String {
        format!("{self}{SET_TO}{value}")
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}`", self.0)
    }
}

/// What stands between a key and the value that it is to have.
const SET_TO: &str = " = ";

/// A sentence with its keys as `names` calls them: `--sample-time` for `` `sample_time_s` ``, and
/// `--loop host` for `` `loop` = host``. Unknown keys and anything else between backticks stay
/// unchanged.
pub fn renamed(sentence: &str, names: impl Fn(&str) -> Option<String>) -> String {
    let mut rest = sentence;
    let mut said = String::with_capacity(sentence.len());
    while let Some((before, behind)) = rest.split_once('`') {
        said += before;
        rest = behind;
        let Some((key, behind)) = behind.split_once('`') else {
            said.push('`');
            break;
        };
        match names(key) {
            Some(name) => {
                said += &name;
                let value = behind.strip_prefix(SET_TO);
                said += value.map_or("", |_| " ");
                rest = value.unwrap_or(behind);
            }
            // Its second backtick may be the first of a key, where somebody gave a text with one.
            None => said.push('`'),
        }
    }
    said + rest
}

/// Advice to somebody who wrote a name that is none of these: the one that was meant, or all. Keys are compared without their
/// units, all without capitals.
///
/// ```
/// use haptic_quantity::did_you_mean;
///
/// let keys = ["mass_kg", "stiffness_n_per_m"];
/// assert_eq!(did_you_mean("stifness", keys), "did you mean `stiffness_n_per_m`?");
/// assert_eq!(did_you_mean("Mass", keys), "did you mean `mass_kg`?");
/// assert_eq!(did_you_mean("foo", ["loop", "order"]), "known are loop, order");
/// ```
pub fn did_you_mean<'n>(written: &str, names: impl IntoIterator<Item = &'n str>) -> String {
    let plain = |name: &str| without_unit(name).to_lowercase().replace(['-', ' '], "_");
    let wanted = plain(written);
    let far = |name: &str| levenshtein(&plain(name), &wanted);
    let names: Vec<&str> = names.into_iter().collect();
    // Half of the letters may be wrong, and three at most.
    let most = wanted.chars().count() / 2;
    let near = names.iter().filter(|name| far(name) <= most.min(3));
    match near.min_by_key(|name| far(name)) {
        Some(nearest) => format!("did you mean `{nearest}`?"),
        None => format!("known are {}", names.join(", ")),
    }
}
