//! The questions of a page's panels: of each panel the newest counts.
//!
//! One is worked on at a time, beside the reactor. A newer one gives up the one before it: one that waits is refused at
//! once, and a running identification is stopped. So a slider that is dragged never queues.

use super::hub::blocking;
use super::request::{Panel, Question, Turn};
use crate::control::designed;
use crate::identify::{explained, identified, plant};
use crate::surface::Surface;
use haptic_experiment::Failure;
use haptic_experiment::live::locked;
use serde_json::Value;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

impl Question {
    fn answer(&self, program: &str, given_up: &AtomicBool) -> Result<Value, Failure> {
        match self {
            Self::Wall(wall) => wall.answer(),
            Self::Control(plant) => designed(plant),
            Self::Analyze(asked) => asked.analysed(),
            Self::Simulate(asked) => asked.simulated(),
            Self::Record(record) => identified(record, program, given_up),
            Self::ExplainRecord(record) => explained(record),
            Self::PlantRecord(record) => plant(record, program, given_up),
        }
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
    pub(super) surface: Mutex<Option<Surface>>,
}

impl Panels {
    /// Makes this the newest turn of its panel, which gives up the one before it.
    pub(super) fn take_turn(&self, panel: Panel, turn: &Arc<Turn>) {
        let newest = &mut *locked(&self.queues[panel as usize].newest);
        std::mem::replace(newest, Arc::clone(turn)).give_up();
    }

    /// The answer to a question whose turn was taken.
    pub(super) async fn ask(
        &self,
        panel: Panel,
        question: Question,
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
        blocking(move || question.answer(program.as_deref().unwrap_or_default(), &turn.given_up))
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
