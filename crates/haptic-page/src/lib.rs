#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod dropped;
mod feel;
mod folder;
mod runs;
mod server;

pub use haptic_answer::feel::DeviceNumbers;
pub use server::{PageServer, ServerOptions};

use haptic_experiment::named;
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use tokio::sync::broadcast::Sender;

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
