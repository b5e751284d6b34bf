//! Keys in sentences.

use std::fmt;
use std::sync::OnceLock;

type Names = Box<dyn Fn(&str) -> Option<String> + Send + Sync>;

static NAMES: OnceLock<Names> = OnceLock::new();

/// A key of a document or an argument of a function, as a sentence names it: `` `sample_time_s` ``, or as
/// the running program calls it, see [`name_keys`].
///
/// ```
/// use haptic_quantity::Key;
///
/// assert_eq!(format!("give {}", Key("strain")), "give `strain`");
/// assert_eq!(format!("give {}", Key("loop").set_to("host")), "give `loop` = host");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key(pub &'static str);

/// Tells how this program calls its keys, as `--sample-time`; `None` for a key that it calls by its name. Once in
/// a process, at its start: what is told later is not heard.
pub fn name_keys(names: impl Fn(&str) -> Option<String> + Send + Sync + 'static) {
    // The first one counts.
    let _ = NAMES.set(Box::new(names));
}

impl Key {
    /// A key and the value that it is to have.
    #[must_use]
    pub fn set_to<V: fmt::Display>(self, value: V) -> impl fmt::Display {
        KeyAndValue { key: self, value }
    }

    fn name(self) -> Option<String> {
        NAMES.get().and_then(|names| names(self.0))
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => f.write_str(&name),
            None => write!(f, "`{}`", self.0),
        }
    }
}

struct KeyAndValue<V> {
    key: Key,
    value: V,
}

impl<V: fmt::Display> fmt::Display for KeyAndValue<V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.key.name() {
            Some(name) => write!(f, "{name} {}", self.value),
            None => write!(f, "`{}` = {}", self.key.0, self.value),
        }
    }
}
