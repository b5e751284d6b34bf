//! Choices by name, as files, options and JSON have them.

/// A choice that has a name in experiment files.
pub trait Named: Copy + PartialEq + 'static {
    /// All of them: value, name, and a few words for people.
    const CHOICES: &'static [(Self, &'static str, &'static str)];

    /// The choice of this name.
    fn named(name: &str) -> Option<Self> {
        let found = Self::CHOICES.iter().find(|choice| choice.1 == name);
        found.map(|choice| choice.0)
    }

    /// Its name; empty if it is not in the list, which would be a defect.
    fn name(self) -> &'static str {
        let found = Self::CHOICES.iter().find(|choice| choice.0 == self);
        found.map_or("", |choice| choice.1)
    }
}
