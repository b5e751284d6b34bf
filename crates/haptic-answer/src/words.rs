//! Numbers, files and lines that a page sends or is sent.

use haptic_document::Failure;
use haptic_quantity::short;
use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value, json};

/// A number of a page. JSON has no NaN, and a browser writes null: the check of the number then names it.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(from = "Option<f64>")]
pub struct Number(pub f64);

impl From<Option<f64>> for Number {
    fn from(number: Option<f64>) -> Self {
        Self(number.unwrap_or(f64::NAN))
    }
}

/// A file that a person gave the page: its name is for messages.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TextFile {
    #[serde(deserialize_with = "file_name")]
    /// As the page shows it.
    pub name: String,
    /// All of it.
    pub text: String,
}

/// Longest sentence about a value that has the wrong type, which it shows whole, characters.
const ECHO: usize = 200;

/// The error of a value, in a line that shortens a long one.
pub fn in_a_line(text: &str) -> String {
    within(text, ECHO)
}

/// A line of so many characters at most, its middle left out: what is wrong stands before it, what is right behind it.
pub fn within(text: &str, most: usize) -> String {
    let length = text.chars().count();
    let half = if length <= most {
        length
    } else {
        (most - 1) / 2
    };
    let first = text.chars().take(half);
    let mark = (half < length).then_some('…');
    let last = text.chars().skip(half.max(length - half));
    let all = first.chain(mark).chain(last);
    all.map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// A form of keys, whose mistakes are said in a line.
///
/// # Errors
/// A key or value that the form has not.
pub fn form<F: DeserializeOwned>(keys: &Map<String, Value>) -> Result<F, Failure> {
    let form = serde_json::from_value(Value::Object(keys.clone()));
    form.map_err(|error| Failure::bad_input(in_a_line(&error.to_string())))
}

/// The name of a file, as far as messages show it.
///
/// # Errors
/// A name of more than 200 characters.
pub fn file_name<'de, D: Deserializer<'de>>(from: D) -> Result<String, D::Error> {
    let name = String::deserialize(from)?;
    match name.chars().nth(200) {
        None => Ok(name),
        Some(_) => Err(D::Error::custom(format_args!(
            "the name of a file has more than 200 characters: {}",
            short(&name)
        ))),
    }
}

/// Longest refusal, characters: what a page has sent may be in it.
const SENTENCE: usize = 1000;

/// The answer to the request of this number.
#[must_use]
pub fn answered(id: &Value, result: Result<Value, Failure>) -> Value {
    match result {
        Ok(mut value) => {
            if value.is_null() {
                value = json!({});
            }
            (value["id"], value["ok"]) = (id.clone(), true.into());
            value
        }
        Err(failure) => refusal(id, &failure.to_string()),
    }
}

/// A refusal of the request of this number.
#[must_use]
pub fn refusal(id: &Value, error: &str) -> Value {
    json!({"id": id, "ok": false, "error": within(error, SENTENCE)})
}
