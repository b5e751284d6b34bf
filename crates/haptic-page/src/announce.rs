//! Sentences and news for all pages.

use serde_json::Value;
use std::sync::Arc;
use tokio::sync::broadcast::Sender;

/// Says something to all pages; to none if there is none. May be called in any thread.
#[derive(Clone, Debug)]
pub(crate) struct Announce(pub(crate) Sender<Arc<str>>);

impl Announce {
    pub(crate) fn say(&self, value: &Value) {
        // Nobody there is no error.
        let _ = self.0.send(value.to_string().into());
    }
}
