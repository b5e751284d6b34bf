//! Time of a session, and what whoever waits for its loop sees of it.

use super::{keeper::Watch, orders::locked, ticking::Ticked};
use haptic_judge::felt::{Certifying, Forces, Tally};
use std::{
    collections::VecDeque,
    sync::{
        Arc, Condvar, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

/// Longest wait before somebody looks whether to stop.
pub(super) const LOOK: Duration = Duration::from_millis(5);

/// Positions that a law hears which is changed to while the old one is touched: 17 minutes at 1 kHz.
const PAST: usize = 1 << 20;

/// Virtual time: a loop goes on as far as somebody lets it.
#[derive(Debug, Default)]
pub(super) struct Gate {
    until: Mutex<u64>,
    moved: Condvar,
}

impl Gate {
    /// Waits until this tick may be made, or is to be the beginning of the end.
    pub(super) fn pass(&self, tick: u64, stop: &AtomicBool) {
        let mut until = locked(&self.until);
        while *until <= tick && !stop.load(Ordering::Relaxed) {
            let waited = self.moved.wait_timeout(until, LOOK);
            until = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Lets time go on until before this tick.
    pub(super) fn open(&self, until: u64) {
        *locked(&self.until) = until;
        self.moved.notify_all();
    }
}

/// Facts that are kept of the loop.
#[derive(Debug, Default)]
pub(super) struct Kept {
    /// The number of the next tick, one beyond the newest that is kept.
    pub made: u64,
    pub position_m: f64,
    /// The law of the newest of them.
    pub stimulus: u64,
    /// No other law fades.
    pub settled: bool,
    /// Sums over the ticks of the stimulus that is felt.
    pub tally: Tally,
    pub certifying: Certifying,
    /// Positions that the law has heard, m, and the number of the first.
    pub past_m: VecDeque<f64>,
    pub past_from: u64,
    /// Position before them, where the law began, m.
    pub start_m: f64,
    /// The loop has ended, and all is kept.
    pub is_over: bool,
}

impl Kept {
    fn take(&mut self, ticked: &Ticked) {
        self.made = ticked.number + 1;
        let before_m = std::mem::replace(&mut self.position_m, f64::NAN);
        self.position_m = ticked.sample.reading.position_m[0];
        self.stimulus = ticked.stimulus;
        self.settled = ticked.settled;
        let (reading, force) = (&ticked.sample.reading, ticked.sample.force.newtons());
        let at = (reading.tick, reading.time_s);
        let counted = self.tally.ticks;
        (self.tally).see(ticked.stimulus, at, self.position_m, force[0]);
        if self.tally.ticks > counted {
            let reduced_n = ticked.sample.environment_force_n[0];
            self.certifying.see(&Forces {
                asked_n: ticked.asked.map_or(reduced_n, |asked| asked.new_n),
                mixed_n: ticked.asked.map_or(reduced_n, |asked| asked.mixed_n),
                reduced_n,
                sent_n: force[0],
            });
        }
        if ticked.fresh || ticked.stimulus == 0 {
            self.past_m.clear();
            self.start_m = before_m;
        } else if self.past_m.len() == PAST
            && let Some(forgotten_m) = self.past_m.pop_front()
        {
            self.start_m = forgotten_m;
        }
        self.past_m.push_back(self.position_m);
        self.past_from = self.made - self.past_m.len() as u64;
    }
}

/// It, for the keeper and whoever waits.
#[derive(Debug, Default)]
pub(super) struct Shared {
    pub kept: Mutex<Kept>,
    pub moved: Condvar,
}

pub(super) struct Watching {
    pub shared: Arc<Shared>,
    pub batch: Vec<Ticked>,
}

impl Watch for Watching {
    type Task = std::convert::Infallible;

    fn task(&mut self, task: Self::Task) {
        match task {}
    }

    /// They are counted by the loop; its log has them all.
    fn lost(&mut self, _: u64) {}

    fn take(&mut self, ticked: &Ticked) {
        self.batch.push(*ticked);
    }

    fn keep(&mut self) {
        if self.batch.is_empty() {
            return;
        }
        let mut kept = locked(&self.shared.kept);
        self.batch.drain(..).for_each(|ticked| kept.take(&ticked));
        drop(kept);
        self.shared.moved.notify_all();
    }

    fn end(&mut self) {
        locked(&self.shared.kept).is_over = true;
        self.shared.moved.notify_all();
    }
}
