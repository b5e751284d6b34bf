//! The force that another operator would have made of the same motion. It acts on nothing, and is computed off the tick.

use super::fading::{FadingHistory, Law};
use super::law::{FadingFelt, Felt, fading};
use crate::pyramid::Pyramid;
use haptic_loop::Environment;
use nalgebra::Vector1;

/// A ghost that has heard all positions before a tick.
#[derive(Debug)]
pub(super) struct ReadyGhost {
    pub(super) law: Law<Felt>,
    /// The first tick that it has not heard.
    pub(super) next: u64,
}

/// A ghost at work.
#[derive(Debug)]
pub(super) struct Ghosting {
    law: FadingFelt,
    history: FadingHistory<<Felt as Environment<f64, 1>>::History>,
    pending: Option<ReadyGhost>,
}

impl Ghosting {
    /// Of a law that has heard everything before `tick`, after what it has missed.
    pub(super) fn new(mut ready: ReadyGhost, missed: &Missed<'_>) -> Self {
        missed.heard_by(&mut ready);
        let law = fading(&ready.law.environment);
        let mut history = law.at_rest();
        let mut at_work = law;
        at_work.replace(&mut history, &mut ready.law);
        Self {
            law: at_work,
            history,
            pending: None,
        }
    }

    /// Another law, which comes when the last change is over.
    pub(super) fn change(&mut self, ready: ReadyGhost) {
        self.pending = Some(ready);
    }

    /// The tissue has forgotten.
    pub(super) fn forget(&mut self) {
        self.history = self.law.at_rest();
        self.pending = None;
    }

    /// Lets a law that waits come, if it may.
    pub(super) fn settle(&mut self, missed: &Missed<'_>) {
        if self.history.is_settled()
            && let Some(mut ready) = self.pending.take()
        {
            missed.heard_by(&mut ready);
            self.law.change(&mut self.history, &mut ready.law);
        }
    }

    /// Force at a position, N, which it then has heard.
    pub(super) fn force(&mut self, position_m: f64) -> f64 {
        let x = Vector1::new(position_m);
        let force = self.law.force(&self.history, &x)[0];
        self.law.advance(&mut self.history, &x);
        force
    }
}

/// Positions that are in the pyramid.
pub(super) struct Missed<'a> {
    pub(super) pyramid: &'a Pyramid,
    /// Of the positions.
    pub(super) channel: usize,
}

impl Missed<'_> {
    fn heard_by(&self, ready: &mut ReadyGhost) {
        let mut positions = Vec::new();
        (self.pyramid).samples_from(ready.next, self.channel, &mut positions);
        for &position_m in &positions {
            ready.law.hear(f64::from(position_m));
        }
        ready.next = self.pyramid.made();
    }
}
