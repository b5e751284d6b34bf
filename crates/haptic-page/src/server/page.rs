//! A page as the server knows it: its number, and the way to the task that writes to it.

use super::panels::Panels;
use haptic_answer::live::LiveView;
use haptic_answer::words::within;
use haptic_experiment::Failure;
use serde_json::{Value, json};
use std::sync::Arc;
use tokio::sync::{mpsc, watch};
use tokio_tungstenite::tungstenite::Message;

/// Answers that wait for a page to read them.
pub(super) const QUEUE: usize = 256;
/// Longest refusal, characters: what a page has sent may be in it.
const SENTENCE: usize = 1000;

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
    /// Set to the reason when the server closes its socket.
    pub(super) closing: Arc<watch::Sender<Option<&'static str>>>,
    pub(super) panels: Arc<Panels>,
}

impl Page {
    pub(super) fn new(number: u64, out: mpsc::Sender<Outgoing>) -> Self {
        Self {
            number,
            out,
            closing: Arc::default(),
            panels: Arc::default(),
        }
    }

    pub(super) fn close(&self, reason: &'static str) {
        self.closing.send_replace(Some(reason));
    }

    pub(super) fn refuse(&self, id: &Value, error: &str) {
        self.say(Message::text(refusal(id, error).to_string()));
    }

    /// Puts something into the queue; a full one closes the socket.
    pub(super) fn send(&self, outgoing: Outgoing) {
        if let Err(mpsc::error::TrySendError::Full(_)) = self.out.try_send(outgoing) {
            self.close("the page does not read its answers");
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

fn refusal(id: &Value, error: &str) -> Value {
    json!({"id": id, "ok": false, "error": within(error, SENTENCE)})
}
