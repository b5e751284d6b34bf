//! News for all pages, and sentences for the terminal too.

use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use tokio::sync::broadcast::Sender;

/// Says something to all pages; to none if there is none. May be called in any thread, and never waits.
#[derive(Clone, Debug)]
pub(crate) struct Announce {
    pub(crate) pages: Sender<Arc<str>>,
    pub(crate) terminal: SyncSender<String>,
}

impl Announce {
    /// To the pages.
    pub(crate) fn say(&self, value: &Value) {
        // Nobody there is no error.
        let _ = self.pages.send(value.to_string().into());
    }

    /// A sentence for people, at a page or at the terminal.
    pub(crate) fn notice(&self, text: String) {
        self.say(&json!({"notice": text}));
        // A terminal that nobody reads is no error either.
        let _ = self.terminal.try_send(text);
    }
}
