//! A page as the server knows it: its number, and the way to the task that writes to it.

use super::live::LiveView;
use super::panels::Panels;
use haptic_experiment::Failure;
use serde_json::{Value, json};
use std::sync::Arc;
use tokio::sync::{Notify, mpsc};
use tokio_tungstenite::tungstenite::Message;

/// Answers that wait for a page to read them.
pub(super) const QUEUE: usize = 256;

#[derive(Debug)]
pub(super) enum Outgoing {
    Message(Message),
    /// The live view from now on.
    Live(Option<LiveView>),
}

#[derive(Clone, Debug)]
pub(super) struct Page {
    pub(super) number: u64,
    pub(super) out: mpsc::Sender<Outgoing>,
    /// Notified when the page does not read its answers.
    pub(super) full: Arc<Notify>,
    pub(super) panels: Arc<Panels>,
}

impl Page {
    /// Puts something into the queue; a full one closes the socket.
    pub(super) fn send(&self, outgoing: Outgoing) {
        if let Err(mpsc::error::TrySendError::Full(_)) = self.out.try_send(outgoing) {
            self.full.notify_one();
        }
    }

    pub(super) fn say(&self, message: Message) {
        self.send(Outgoing::Message(message));
    }

    pub(super) fn answer(&self, id: &Value, result: Result<Value, Failure>) {
        let text = match result {
            Ok(mut value) => {
                if value.is_null() {
                    value = json!({});
                }
                (value["id"], value["ok"]) = (id.clone(), true.into());
                value
            }
            Err(failure) => refusal(id, &failure.to_string()),
        };
        self.say(Message::text(text.to_string()));
    }
}

pub(super) fn refusal(id: &Value, error: &str) -> Value {
    json!({"id": id, "ok": false, "error": error})
}
