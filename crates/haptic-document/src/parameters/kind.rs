//! Kinds of parameters: values, and what stands of each.

use super::range::{Range, in_degrees};
use fracdiff::parameter::Shown;
use haptic_loop::Limit;
use haptic_quantity::{Key, WrittenUnit};
use std::{fmt, path::Path};

/// The kind of value that a parameter takes, and its default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A number in a range; the default is in SI units, `None` if the parameter may be left out and is off then.
    Number(Option<f64>, Range),
    /// A whole number of at least 0; its range is judged where it is used.
    Count(u64),
    /// Off unless it is given, as is any option without a value.
    Flag(bool),
    /// A text, or one of several names.
    Text(&'static str),
    /// A list of numbers in a range, or of lists of them.
    List(Range),
}

/// Texts of a parameter that are paths to a file or a folder of files; any other is a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paths {
    /// No text is a path.
    None,
    /// Those that end in `.toml`.
    Toml,
    /// Any text is a path but this one.
    AllBut(&'static str),
    /// Any text that is not empty is a path.
    All,
}

/// A parameter of an experiment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its name in experiment files, with the unit.
    pub key: &'static str,
    /// The kind of value and its default, from which options and the reference are made.
    pub value: Value,
    /// The default as a person writes it; empty if it has none.
    pub shown: &'static str,
    /// One line for people, the same in `--help`, the reference and the page.
    pub help: &'static str,
    paths: Paths,
    /// Entry of a log with the text of the file.
    pub in_log: Option<&'static str>,
}

impl Parameter {
    const fn new(key: &'static str, value: Value, shown: &'static str, help: &'static str) -> Self {
        Self {
            key,
            value,
            shown,
            help,
            paths: Paths::None,
            in_log: None,
        }
    }

    /// A number with a default, in SI units and as a person writes it.
    pub const fn number(
        key: &'static str,
        default: f64,
        shown: &'static str,
        range: Range,
        help: &'static str,
    ) -> Self {
        Self::new(key, Value::Number(Some(default), range), shown, help)
    }

    /// A number that is off, or asked of something else, unless it is given.
    pub const fn optional(key: &'static str, range: Range, help: &'static str) -> Self {
        Self::new(key, Value::Number(None, range), "", help)
    }

    /// A limit of the safety chain, off or as the device has it unless it is given.
    pub const fn limit(limit: Limit) -> Self {
        Self::optional(limit.key(), Range::of(limit), limit.help())
    }

    /// A text with a default.
    pub const fn text(key: &'static str, default: &'static str, help: &'static str) -> Self {
        Self::new(key, Value::Text(default), default, help)
    }

    /// A text that names a file or a folder of files: its path is from the folder of the document.
    pub const fn file(
        key: &'static str,
        default: &'static str,
        paths: Paths,
        in_log: Option<&'static str>,
        help: &'static str,
    ) -> Self {
        Self {
            paths,
            in_log,
            ..Self::text(key, default, help)
        }
    }

    /// A whole number with a default.
    pub const fn count(
        key: &'static str,
        default: u64,
        shown: &'static str,
        help: &'static str,
    ) -> Self {
        Self::new(key, Value::Count(default), shown, help)
    }

    /// A list of numbers without a default.
    pub const fn list(key: &'static str, range: Range, help: &'static str) -> Self {
        Self::new(key, Value::List(range), "", help)
    }

    /// A list of numbers with a default, which is written with commas between them.
    pub const fn list_of(
        key: &'static str,
        shown: &'static str,
        range: Range,
        help: &'static str,
    ) -> Self {
        Self::new(key, Value::List(range), shown, help)
    }

    /// Removes the default of a number or a text; other kinds are not changed.
    #[must_use]
    pub const fn without_default(self) -> Self {
        let value = match self.value {
            Value::Number(_, range) => Value::Number(None, range),
            Value::Text(_) => Value::Text(""),
            Value::Count(_) | Value::Flag(_) | Value::List(_) => self.value,
        };
        Self {
            value,
            shown: "",
            ..self
        }
    }

    /// One that is off unless it is given.
    pub const fn flag(key: &'static str, help: &'static str) -> Self {
        Self::new(key, Value::Flag(false), "", help)
    }

    /// True if some text of it is a path.
    #[must_use]
    pub fn may_be_path(&self) -> bool {
        self.paths != Paths::None
    }

    /// True if it names a file or a folder of files, and this text of it is no other name.
    #[must_use]
    pub fn is_path(&self, text: &str) -> bool {
        match self.paths {
            Paths::None => false,
            Paths::Toml => Path::new(text).extension().is_some_and(|e| e == "toml"),
            Paths::AllBut(name) => !text.is_empty() && text != name,
            Paths::All => !text.is_empty(),
        }
    }

    /// A number outside the range, with the range, its unit and the remedy; an omitted number passes.
    #[must_use]
    pub fn outside(&self, number: Option<f64>) -> Option<String> {
        let range = self.range();
        let number = number.filter(|number| !range.contains(*number))?;
        let within = format!("{range} {}", self.unit());
        Some(format!(
            "{} is not {}{}: change it",
            Shown(number),
            within.trim_end(),
            in_degrees(self.key, range)
        ))
    }

    /// The SI unit of its numbers; empty for a pure number.
    #[must_use]
    pub fn unit(&self) -> String {
        WrittenUnit::of_key(self.key, 1.0).symbol
    }

    /// It and the value that it is to have, in a sentence.
    pub fn set_to<V: fmt::Display>(&self, value: V) -> String {
        Key(self.key).set_to(value)
    }

    /// The default of a number; NaN if it has none.
    #[must_use]
    pub const fn default_number(&self) -> f64 {
        if let Value::Number(Some(default), _) = self.value {
            return default;
        }
        f64::NAN
    }

    /// The default of a count; 0 for anything else.
    #[must_use]
    pub const fn default_count(&self) -> u64 {
        if let Value::Count(default) = self.value {
            return default;
        }
        0
    }

    /// The default of a list of numbers; empty if it has none.
    pub fn default_numbers(&self) -> Vec<f64> {
        let numbers = self.shown.split(',');
        numbers.filter_map(|number| number.parse().ok()).collect()
    }

    /// The range of a number, or of each number in a list; empty for anything else.
    #[must_use]
    pub const fn range(&self) -> Range {
        if let Value::Number(_, range) | Value::List(range) = self.value {
            return range;
        }
        Range::EMPTY
    }
}

/// Shows a parameter as a sentence names it, see [`Key`].
impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Key(self.key).fmt(f)
    }
}

/// A table of keys: its heading, and its parameters.
pub type KeyTable = (&'static str, &'static [Parameter]);

/// Several lists in one.
///
/// # Panics
/// If they have not `N` in all: then it does not compile.
pub const fn joined<const N: usize>(lists: &[&[Parameter]]) -> [Parameter; N] {
    let mut all = [Parameter::flag("", ""); N];
    let (mut list, mut to) = (0, 0);
    while list < lists.len() {
        let mut from = 0;
        while from < lists[list].len() {
            all[to] = lists[list][from];
            (from, to) = (from + 1, to + 1);
        }
        list += 1;
    }
    assert!(to == N, "the lists have another number of parameters");
    all
}

/// Parameters as constants: name, kind, and what it is made of; each is documented by its key, and its help says the rest.
/// Behind `crate;` stand those that nobody outside names. Behind `pub(crate) mod keys;` they are a module too, for whoever hands all of them on.
#[macro_export]
macro_rules! parameters {
    (crate; $($(#[$meta:meta])* $name:ident = $kind:ident($key:expr $(, $part:expr)* $(,)?);)*) => {
        $($(#[$meta])* pub(crate) const $name: $crate::parameters::Parameter =
            $crate::parameters::Parameter::$kind($key $(, $part)*);)*
    };
    ($seen:vis mod $keys:ident; $($rows:tt)*) => {
        #[doc = "All of these keys."]
        $seen mod $keys {
            use super::*;

            $crate::parameters! { $($rows)* }
        }
        pub use $keys::*;
    };
    (all $all:ident; $($(#[$doc:meta])* $name:ident = $kind:ident $parts:tt;)*) => {
        $crate::parameters! { $($(#[$doc])* $name = $kind $parts;)* }
        /// All of these keys, in the order of their rows.
        pub const $all: &[$crate::parameters::Parameter] = &[$($name),*];
    };
    ($($(#[$meta:meta])* $name:ident = $kind:ident($key:expr $(, $part:expr)* $(,)?);)*) => {
        $(#[doc = concat!("The parameter ", stringify!($key), ".")] #[doc = ""] $(#[$meta])* pub const $name: $crate::parameters::Parameter =
            $crate::parameters::Parameter::$kind($key $(, $part)*);)*
    };
}
