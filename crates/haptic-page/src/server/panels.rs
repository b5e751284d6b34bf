//! The questions of a page's panels: of each panel the newest counts.
//!
//! One is worked on at a time, beside the reactor. A newer one gives up the one before it: one that waits is refused at
//! once, and a running identification is stopped. So a slider that is dragged never queues.

use super::hub::blocking;
use crate::runs::FILES;
use haptic_answer::form::Asker;
use haptic_answer::question::PanelQuestion;
use haptic_answer::request::Panel;
use haptic_answer::surface::TissueSurface;
use haptic_experiment::Failure;
use haptic_experiment::live::locked;
use haptic_log::record::StartTime;
use serde_json::Value;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::SystemTime;
use tokio::sync::Notify;

/// A question in its panel.
#[derive(Debug, Default)]
pub(super) struct Turn {
    given_up: AtomicBool,
    given_up_notice: Notify,
}

impl Turn {
    fn give_up(&self) {
        self.given_up.store(true, Ordering::Relaxed);
        self.given_up_notice.notify_one();
    }
}

#[derive(Debug, Default)]
struct Queue {
    newest: Mutex<Arc<Turn>>,
    work: tokio::sync::Mutex<()>,
}

/// The panels of a page, and the tissue that it draws.
#[derive(Debug, Default)]
pub(super) struct Panels {
    queues: [Queue; Panel::ALL.len()],
    gone: AtomicBool,
    pub(super) surface: Mutex<Option<TissueSurface>>,
}

impl Panels {
    /// The newest turn of a panel, which gives up the one before it.
    pub(super) fn take_turn(&self, panel: Panel) -> Arc<Turn> {
        let turn = Arc::<Turn>::default();
        let newest = &mut *locked(&self.queues[panel as usize].newest);
        std::mem::replace(newest, Arc::clone(&turn)).give_up();
        turn
    }

    /// The answer to a question whose turn was taken.
    pub(super) async fn ask(
        &self,
        panel: Panel,
        question: PanelQuestion,
        turn: Arc<Turn>,
        program: Option<String>,
    ) -> Result<Value, Failure> {
        let queue = &self.queues[panel as usize];
        // Asked after `give_up` has seen the one before it: this one is not awaited either.
        if self.gone.load(Ordering::Relaxed) {
            turn.give_up();
        }
        let _work = tokio::select! {
            biased;
            () = turn.given_up_notice.notified() => {
                return Err(Failure::bad_input("a newer question from this panel has replaced this one"));
            }
            work = queue.work.lock() => work,
        };
        blocking(move || {
            question.answer(&Asker {
                program: program.as_deref().unwrap_or_default(),
                day: StartTime::at(SystemTime::now()).day(),
                files: &FILES,
                given_up: &turn.given_up,
            })
        })
        .await
    }

    /// The page is gone: its questions are given up.
    pub(super) fn give_up(&self) {
        self.gone.store(true, Ordering::Relaxed);
        for queue in &self.queues {
            locked(&queue.newest).give_up();
        }
    }
}
