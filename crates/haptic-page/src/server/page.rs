//! A page as the server knows it: its number, and the way to the task that writes to it.

use super::panels::Panels;
use haptic_answer::live::LiveView;
use haptic_answer::words::{answered, refusal};
use haptic_experiment::Failure;
use serde_json::Value;
use std::sync::Arc;
use tokio::sync::{mpsc, watch};
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
        self.say(Message::text(answered(id, result).to_string()));
    }
}
