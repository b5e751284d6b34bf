//! A parameter of a model: name, unit, range.

/// The numbers that a parameter may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ParameterRange {
    /// Above 0 and finite.
    Positive,
    /// At least 0 and finite.
    NotNegative,
    /// From 0 to 1.
    Order,
}

impl ParameterRange {
    /// True for a number within it.
    #[must_use]
    pub fn contains(self, value: f64) -> bool {
        match self {
            Self::Positive => value > 0.0 && value.is_finite(),
            Self::NotNegative => value >= 0.0 && value.is_finite(),
            Self::Order => (0.0..=1.0).contains(&value),
        }
    }

    /// The range in words, to go after "is not".
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Positive => "above 0 and finite",
            Self::NotNegative => "a finite number of at least 0",
            Self::Order => "in [0, 1]",
        }
    }
}

/// A parameter of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Parameter {
    /// Its key in a tissue file; the unit stands in it.
    pub name: &'static str,
    /// Its unit; empty for a pure number.
    pub unit: &'static str,
    /// The numbers that it may be.
    pub range: ParameterRange,
    /// True where there is one for each branch of a Prony series: in a file a list.
    pub for_each_branch: bool,
    /// A few words for people.
    pub help: &'static str,
}
