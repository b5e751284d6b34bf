//! Kinds of parameters: ranges, values, and what stands of each.

use fracdiff::Seconds;
use std::fmt;

/// Range of a number. All ranges are of finite numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// x > low.
    Above(f64),
    /// x ≥ low.
    AtLeast(f64),
    /// low ≤ x ≤ high.
    Within(f64, f64),
    /// low < x ≤ high.
    AboveUpTo(f64, f64),
}

impl Range {
    /// True if a number is in it. A number that is not finite never is.
    #[must_use]
    pub fn contains(self, x: f64) -> bool {
        x.is_finite()
            && match self {
                Self::Above(low) => x > low,
                Self::AtLeast(low) => x >= low,
                Self::Within(low, high) => (low..=high).contains(&x),
                Self::AboveUpTo(low, high) => x > low && x <= high,
            }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Above(low) => write!(f, "above {low}"),
            Self::AtLeast(low) => write!(f, "at least {low}"),
            Self::Within(low, high) if high >= 1e6 => write!(f, "in [{low:e}, {high:e}]"),
            Self::Within(low, high) => write!(f, "in [{low}, {high}]"),
            Self::AboveUpTo(low, high) => write!(f, "in ({low}, {high}]"),
        }
    }
}

/// The kind of value that a parameter takes, and its default.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Value {
    /// A number in a range; the default is in SI units, `None` if the parameter may be left out and is off then.
    Number(Option<f64>, Range),
    /// A whole number.
    Count(u64),
    /// Yes or no.
    Flag(bool),
    /// A text, or one of several names.
    Text(&'static str),
    /// A list of numbers, or of lists of numbers.
    List,
}

/// A parameter of an experiment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its name in experiment files, with the unit.
    pub key: &'static str,
    /// Kind and default.
    pub value: Value,
    /// The default as a person writes it; empty if there is none.
    pub shown: &'static str,
    /// One line for people.
    pub help: &'static str,
}

impl Parameter {
    pub(super) const fn number(
        key: &'static str,
        default: f64,
        shown: &'static str,
        range: Range,
        help: &'static str,
    ) -> Self {
        let value = Value::Number(Some(default), range);
        Self {
            key,
            value,
            shown,
            help,
        }
    }

    pub(super) const fn optional(key: &'static str, range: Range, help: &'static str) -> Self {
        let value = Value::Number(None, range);
        Self {
            key,
            value,
            shown: "",
            help,
        }
    }

    pub(super) const fn text(key: &'static str, default: &'static str, help: &'static str) -> Self {
        Self {
            key,
            value: Value::Text(default),
            shown: default,
            help,
        }
    }

    pub(super) const fn count(
        key: &'static str,
        default: u64,
        shown: &'static str,
        help: &'static str,
    ) -> Self {
        let value = Value::Count(default);
        Self {
            key,
            value,
            shown,
            help,
        }
    }

    pub(super) const fn list(key: &'static str, help: &'static str) -> Self {
        Self {
            key,
            value: Value::List,
            shown: "",
            help,
        }
    }

    /// A list of numbers with a default, which is written with commas between them.
    pub(super) const fn list_of(
        key: &'static str,
        shown: &'static str,
        help: &'static str,
    ) -> Self {
        Self {
            shown,
            ..Self::list(key, help)
        }
    }

    /// One that is off unless it is given.
    pub(super) const fn flag(key: &'static str, help: &'static str) -> Self {
        Self {
            key,
            value: Value::Flag(false),
            shown: "",
            help,
        }
    }

    /// The default of a number; NaN if it has none.
    #[must_use]
    pub const fn default_number(&self) -> f64 {
        match self.value {
            Value::Number(Some(default), _) => default,
            _ => f64::NAN,
        }
    }

    /// The default of a list of numbers; empty if it has none.
    #[must_use]
    pub fn default_numbers(&self) -> Vec<f64> {
        let numbers = self.shown.split(',');
        numbers.filter_map(|number| number.parse().ok()).collect()
    }

    /// The range of a number; empty for anything else.
    #[must_use]
    pub const fn range(&self) -> Range {
        match self.value {
            Value::Number(_, range) => range,
            _ => Range::Above(f64::INFINITY),
        }
    }
}

pub(super) const ABOVE_0: Range = Range::Above(0.0);
pub(super) const AT_LEAST_0: Range = Range::AtLeast(0.0);
pub(super) const SAMPLE_TIMES: Range =
    Range::Within(Seconds::MIN_SAMPLE_TIME, Seconds::MAX_SAMPLE_TIME);

/// Parameters as constants: documentation, name, kind, and what it is made of.
macro_rules! parameters {
    ($($(#[$meta:meta])* $name:ident = $kind:ident($($part:expr),* $(,)?);)*) => {
        $($(#[$meta])* pub const $name: $crate::parameters::Parameter =
            $crate::parameters::Parameter::$kind($($part),*);)*
    };
}
pub(super) use parameters;
