//! Choices by name, as files, options and JSON have them.

/// A choice that has a name in experiment files; [`named!`](crate::named) makes it of an enumeration.
pub trait Named: Copy + PartialEq + 'static {
    /// All of them: value, name, and a few words for people.
    const CHOICES: &'static [(Self, &'static str, &'static str)];

    /// Its name in experiment files.
    fn name(self) -> &'static str;

    /// The choice of this name.
    fn named(name: &str) -> Option<Self> {
        let found = Self::CHOICES.iter().find(|choice| choice.1 == name);
        found.map(|choice| choice.0)
    }
}

/// Names the variants of an enumeration, `VARIANT = NAME, WORDS;` each; one that is left out does not compile.
#[macro_export]
macro_rules! named {
    ($choice:ident: $($variant:ident = $name:expr, $words:literal;)+) => {
        impl $crate::Named for $choice {
            const CHOICES: &'static [(Self, &'static str, &'static str)] =
                &[$((Self::$variant, $name, $words)),+];

            fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }
        }
    };
}
