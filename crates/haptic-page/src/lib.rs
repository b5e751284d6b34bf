#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod control;
mod dropped;
mod feel;
mod folder;
mod identify;
mod pyramid;
mod runs;
mod scheme;
mod server;
mod surface;
mod wall;

pub use feel::DeviceNumbers;
pub use server::{PageServer, ServerOptions};

use haptic_experiment::{Failure, named};
use haptic_quantity::short;
use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value, json};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use tokio::sync::broadcast::Sender;

/// A number of a page. JSON has no NaN, and a browser writes null: the check of the number then names it.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(from = "Option<f64>")]
pub(crate) struct Number(pub(crate) f64);

impl From<Option<f64>> for Number {
    fn from(number: Option<f64>) -> Self {
        Self(number.unwrap_or(f64::NAN))
    }
}

/// A file that a person gave the page: its name is for messages.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TextFile {
    #[serde(deserialize_with = "file_name")]
    pub(crate) name: String,
    pub(crate) text: String,
}

/// Longest sentence about a value that has the wrong type, which it shows whole, characters.
const ECHO: usize = 200;

/// The error of a value, in a line that shortens a long one.
pub(crate) fn in_a_line(text: &str) -> String {
    within(text, ECHO)
}

/// A line of so many characters at most, its middle left out: what is wrong stands before it, what is right behind it.
pub(crate) fn within(text: &str, most: usize) -> String {
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
pub(crate) fn form<F: DeserializeOwned>(keys: &Map<String, Value>) -> Result<F, Failure> {
    let form = serde_json::from_value(Value::Object(keys.clone()));
    form.map_err(|error| Failure::bad_input(in_a_line(&error.to_string())))
}

/// The name of a file, as far as messages show it.
pub(crate) fn file_name<'de, D: Deserializer<'de>>(from: D) -> Result<String, D::Error> {
    let name = String::deserialize(from)?;
    match name.chars().nth(200) {
        None => Ok(name),
        Some(_) => Err(D::Error::custom(format_args!(
            "the name of a file has more than 200 characters: {}",
            short(&name)
        ))),
    }
}

/// Sends to all pages, if there are any. May be called in any thread, and never waits.
#[derive(Clone, Debug)]
pub(crate) struct Announce {
    pub(crate) pages: Sender<Arc<str>>,
    pub(crate) terminal: SyncSender<String>,
}

impl Announce {
    pub(crate) fn say(&self, value: &Value) {
        // No listener is not an error.
        let _ = self.pages.send(value.to_string().into());
    }

    /// A sentence for people, at a page or at the terminal.
    pub(crate) fn notice(&self, text: String) {
        self.say(&json!({"notice": text}));
        // Nor is an unread terminal.
        let _ = self.terminal.try_send(text);
    }
}

/// Effect on a loop or a run of closing the page that controls it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnClose {
    /// The force falls to zero and it ends.
    #[default]
    Stop,
    /// It continues; the next page to take control gets it.
    Continue,
}

named! { OnClose:
    Stop = "stop", "The force falls to zero and it ends";
    Continue = "continue", "It goes on; the next page that takes the controls has it";
}
