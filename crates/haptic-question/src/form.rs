//! Forms of questions: each key with its table, range and value stands in one row.

use haptic_document::Failure;
use haptic_document::parameters::Parameter;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use serde_json::Value;
use std::ops::Deref;

/// A text, or a number as one; empty if nothing is given.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Text(String);

impl Deref for Text {
    type Target = str;

    fn deref(&self) -> &str {
        &self.0
    }
}

impl<'de> Deserialize<'de> for Text {
    fn deserialize<D: Deserializer<'de>>(value: D) -> Result<Self, D::Error> {
        Ok(Self(match Value::deserialize(value)? {
            Value::Null => String::new(),
            Value::String(text) => text,
            Value::Number(number) => number.to_string(),
            other @ (Value::Bool(_) | Value::Array(_) | Value::Object(_)) => {
                return Err(D::Error::custom(format_args!("{other} is no text")));
            }
        }))
    }
}

/// Refuses a number outside its range.
pub(crate) fn check(parameter: Parameter, number: Option<f64>) -> Result<(), Failure> {
    let refused = |reason| Failure::bad_input(parameter.set_to::<String>(reason));
    parameter
        .outside(number)
        .map_or(Ok(()), |reason| Err(refused(reason)))
}

/// A form, its tables under headings, and a constant for each key: `NAME = key: kind(parts of the parameter);`.
macro_rules! form {
    (@type flag) => { bool };
    (@type text) => { $crate::form::Text };
    (@type file) => { $crate::form::Text };
    (@type count) => { Option<u64> };
    (@type $number:ident) => { Option<f64> };
    (@number optional $value:expr) => { $value };
    (@number number $value:expr) => { $value };
    (@number $other:ident $value:expr) => { None };
    ($(#[$meta:meta])* $form:ident, $tables:ident:
     $($heading:literal $($name:ident = $key:ident: $kind:ident($($part:expr),*);)*)*) => {
        haptic_document::parameters! {
            $($($name = $kind(stringify!($key), $($part),*);)*)*
        }

        /// The keys of the form, under headings.
        pub const $tables: &[haptic_document::parameters::KeyTable] = &[$(($heading, &[$($name),*])),*];

        $(#[$meta])*
        #[derive(Clone, Debug, Default, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        #[expect(missing_docs, reason = "each field is the value of the key of its name")]
        pub struct $form {
            $($(pub $key: form!(@type $kind),)*)*
        }

        impl $form {
            /// Refuses numbers outside their ranges.
            pub(crate) fn check(&self) -> Result<(), haptic_document::Failure> {
                $($($crate::form::check($name, form!(@number $kind self.$key))?;)*)*
                Ok(())
            }
        }
    };
}
pub(crate) use form;
