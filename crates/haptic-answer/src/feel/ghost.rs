//! Company of a loop: other operators on the same motion, energy, and the newest of its state.

use super::state::{CHANNELS, FeelState, POSITION};
use crate::pyramid::Pyramid;
use fracdiff::Seconds;
use haptic_loop::Environment;
use haptic_trial::in_hand::fading::{FadingHistory, Law};
use haptic_trial::in_hand::law::{Felt, fading};
use haptic_trial::in_hand::ticking::{FadingFelt, Ticked};
use nalgebra::Vector1;

/// The force that another operator would have made of the same motion. It acts on nothing.
#[derive(Debug)]
struct Ghosting {
    law: FadingFelt,
    history: FadingHistory<<Felt as Environment<f64, 1>>::History>,
    /// Comes when the last change is over.
    pending: Option<Law<Felt>>,
}

impl Ghosting {
    /// Ghost of a law, after what it has missed.
    fn new(mut ready: Law<Felt>, pyramid: &Pyramid, sample_time_s: f64) -> Self {
        let mut law = fading(&ready.environment, Seconds(sample_time_s));
        let mut history = law.at_rest();
        hear_missed(&mut ready, pyramid);
        law.replace(&mut history, &mut ready);
        Self {
            law,
            history,
            pending: None,
        }
    }

    /// The tissue is untouched again.
    fn forget(&mut self) {
        self.history = self.law.at_rest();
        self.pending = None;
    }

    /// Takes the law that waits, if the last change is over.
    fn settle(&mut self, pyramid: &Pyramid) {
        if self.history.is_settled()
            && let Some(mut ready) = self.pending.take()
        {
            hear_missed(&mut ready, pyramid);
            self.law.change(&mut self.history, &mut ready);
        }
    }

    /// Force at a position, N, which it then has heard.
    fn force(&mut self, position_m: f64) -> f64 {
        let x = Vector1::new(position_m);
        let force = self.law.wanted(&self.history, &x);
        self.law.advance(&mut self.history, &x);
        force
    }
}

fn hear_missed(law: &mut Law<Felt>, pyramid: &Pyramid) {
    let mut missed = Vec::new();
    let first = pyramid.samples_from(law.next, POSITION, &mut missed);
    law.hear_from(first, missed.into_iter().map(f64::from));
}

/// Laws of the ghosts, `None` of one that is not drawn.
pub type GhostLaws = [Option<Law<Felt>>; 2];

/// Company of a loop, tick by tick.
#[derive(Debug)]
pub struct Company {
    /// The newest of the loop.
    pub state: FeelState,
    ghosts: [Option<Ghosting>; 2],
    before: Option<(f64, f64)>,
}

impl Company {
    /// Nothing yet of a loop with this period.
    #[must_use]
    pub fn new(sample_time: Seconds) -> Self {
        Self {
            state: FeelState::of(sample_time),
            ghosts: [None, None],
            before: None,
        }
    }

    /// Ghosts of these laws from now on, which hear what they have missed.
    pub fn draw(&mut self, laws: GhostLaws, pyramid: &Pyramid) {
        let t = self.state.sample_time_s;
        for (ghost, ready) in self.ghosts.iter_mut().zip(laws) {
            match (ghost.as_mut(), ready) {
                (Some(ghost), Some(ready)) => ghost.pending = Some(ready),
                (_, ready) => *ghost = ready.map(|ready| Ghosting::new(ready, pyramid, t)),
            }
        }
    }

    /// Laws of ghosts that wait begin, where the change before them is over.
    pub fn settle(&mut self, pyramid: &Pyramid) {
        for ghost in self.ghosts.iter_mut().flatten() {
            ghost.settle(pyramid);
        }
    }

    /// Takes a tick: its row for the pyramid.
    pub fn take(&mut self, ticked: &Ticked) -> [f32; CHANNELS.len()] {
        let (state, sample) = (&mut self.state, &ticked.sample);
        let (position_m, force_n) = (sample.reading.position_m[0], sample.force.newtons()[0]);
        if ticked.fresh {
            self.ghosts.iter_mut().flatten().for_each(Ghosting::forget);
            self.before = None;
            state.energy_j = 0.0;
        }
        if let Some((before_m, before_n)) = self.before {
            state.energy_j += before_n * (position_m - before_m);
        }
        self.before = Some((position_m, force_n));
        let ghosts = self.ghosts.each_mut().map(|ghost| {
            let force = ghost.as_mut().map(|ghost| ghost.force(position_m));
            force.unwrap_or(f64::NAN)
        });
        state.late += u64::from(ticked.around.skipped > 0);
        state.skipped += ticked.around.skipped;
        (state.tick, state.time_s) = (sample.reading.tick, sample.reading.time_s);
        (state.position_m, state.force_n) = (position_m, force_n);
        (state.limiter, state.fault) = (sample.limiters.bits(), sample.fault);
        state.stopping = ticked.stopping;
        let row = [
            position_m,
            ticked.around.hand_m,
            force_n,
            ghosts[0],
            ghosts[1],
            state.energy_j,
            f64::from(state.limiter),
            position_m,
            position_m,
            position_m,
        ];
        row.map(|number| number as f32)
    }
}
