//! Keys in sentences.

use crate::without_unit;
use std::{borrow::Cow, fmt};
use strsim::osa_distance;

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

/// Text between a key and its value.
const SET_TO: &str = " = ";

/// A sentence with its keys as `names` calls them: `--sample-time` for `` `sample_time_s` ``, and
/// `--loop host` for `` `loop` = host``. Unknown keys and anything else between backticks stay
/// unchanged.
pub fn renamed(sentence: &str, names: impl Fn(&str) -> Option<String>) -> String {
    let mut rest = sentence;
    let mut sentence_of_keys = String::with_capacity(sentence.len());
    while let Some((before, behind)) = rest.split_once('`') {
        sentence_of_keys += before;
        rest = behind;
        let Some((key, behind)) = behind.split_once('`') else {
            sentence_of_keys.push('`');
            break;
        };
        match names(key) {
            Some(name) => {
                sentence_of_keys += &name;
                let value = behind.strip_prefix(SET_TO);
                sentence_of_keys += value.map_or("", |_| " ");
                rest = value.unwrap_or(behind);
            }
            // Its second backtick may be the first of a key, where somebody gave a text with one.
            None => sentence_of_keys.push('`'),
        }
    }
    sentence_of_keys + rest
}

/// The user's text, for a message, cut to its beginning if it exceeds 200 characters.
///
/// ```
/// use haptic_quantity::short;
///
/// assert_eq!(short("5 N"), "5 N");
/// assert_eq!(short(&"é".repeat(1000)), format!("{}… (1000 characters)", "é".repeat(80)));
/// ```
#[must_use]
pub fn short(text: &str) -> Cow<'_, str> {
    // Many a message shows it twice: as an argument, and as what is wrong with it.
    let (most, kept) = (200, 80);
    let length = text.chars().count();
    if length <= most {
        return text.into();
    }
    let kept: String = text.chars().take(kept).collect();
    format!("{kept}… ({length} characters)").into()
}

/// Advice on an unknown name: the known one that was meant, or all. Keys are compared without their
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
    let names: Vec<&str> = names.into_iter().collect();
    let begins = |name: &&&str| written.len() > 2 && name.starts_with(&format!("{written}-"));
    let alike: Vec<String> = (names.iter().filter(begins))
        .map(|name| format!("`{name}`"))
        .collect();
    if alike.len() > 1 {
        return format!("did you mean {}?", alike.join(" or "));
    }
    match nearest(written, &names) {
        Some(nearest) => format!("did you mean `{nearest}`?"),
        None => format!("known are {}", names.join(", ")),
    }
}

/// Names, and words for them in the guide's formulas and in other programs.
const ALSO: [(&str, &[&str]); 11] = [
    ("stiffness", &["K", "k"]),
    ("dissipation", &["B"]),
    ("damping", &["b"]),
    ("mass", &["m"]),
    ("sample_time", &["T", "dt", "fs", "rate"]),
    ("order", &["mu", "μ", "alpha"]),
    ("out", &["o"]),
    ("device", &["port"]),
    ("crossover", &["bandwidth"]),
    ("strain", &["stress"]),
    ("stress", &["strain"]),
];

/// The name that somebody meant who wrote another: one that is called so too, one that is a few letters off, or one with this
/// word in it.
pub fn nearest<'n>(written: &str, names: &[&'n str]) -> Option<&'n str> {
    let plain = |name: &str| {
        let name = name.trim_start_matches('-').trim_end_matches("=VALUE");
        without_unit(name).to_lowercase().replace(['-', ' '], "_")
    };
    // Nobody slips that far, and to compare takes as long as it is.
    if written.chars().nth(64).is_some() {
        return None;
    }
    // The heading of a table stands before a point.
    let written = written.trim_start_matches('-');
    let key = written.rsplit('.').next().filter(|key| !key.is_empty());
    let written = key.unwrap_or(written);
    let also = ALSO.iter().find(|(_, words)| words.contains(&written));
    let wanted = also.map_or_else(|| plain(written), |other| other.0.to_owned());
    let far = |name: &str| osa_distance(&plain(name), &wanted);
    // A third of the letters may be wrong.
    let most = (wanted.chars().count() + 1) / 3;
    let near = names.iter().filter(|name| far(name) <= most.min(3));
    let is_word = |word: &str| wanted.len() > 2 && word.starts_with(&wanted);
    let with_it = |name: &&&str| plain(name).split('_').any(is_word);
    near.min_by_key(|name| far(name))
        .or_else(|| names.iter().find(with_it))
        .copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_letter_of_a_formula_a_part_and_a_slip_are_the_name_and_another_word_is_not() {
        let names = [
            "mass_kg",
            "damping_n_s_per_m",
            "stiffness_n_per_m",
            "order",
            "encoder_resolution_m",
            "--sample-time",
            "design",
        ];
        for (written, meant) in [
            ("K", Some("stiffness_n_per_m")),
            ("b", Some("damping_n_s_per_m")),
            ("mu", Some("order")),
            ("--rate", Some("--sample-time")),
            ("encoder", Some("encoder_resolution_m")),
            ("wal.stiffness", Some("stiffness_n_per_m")),
            ("damipng", Some("damping_n_s_per_m")),
            ("dseign", Some("design")),
            ("version", None),
            ("liver.", None),
            ("", None),
            ("-", None),
        ] {
            assert_eq!(nearest(written, &names), meant, "{written}");
        }
    }
}
