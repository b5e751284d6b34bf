//! The program's clock as the loop takes it: always forward, one tick a sample time.
//!
//! ```text
//! a call is a tick if  now + T/2 ≥ due;   due ← (due, no further than T/2 from now) + T
//! ```
//! - *Called more often* than the sample time T, the calls between two ticks hold the last force: a law is made for its T.
//!   *Called at T*, each call is a tick, whatever the jitter below T/2 and whichever clock is the faster.
//! - *A pause of more than 1.5·T between two calls* ends in a tick and skips as many ticks as are nearest to it, less one: they count as time and have
//!   no samples, and the law takes them in on the line to the next.
//! - *A clock that stands still* is a trouble; the loop's own time then advances by T, so that its watchdog never waits for
//!   a clock that was set back.
//! - *Units*: µs. *Cost*: a few comparisons.

/// Longest step that is believed, µs: a watchdog is long over, and sums stay far from their end.
const STEP_MOST_US: u64 = 3_600_000_000;

#[derive(Debug)]
pub(crate) struct ProgramClock {
    pub period_us: u64,
    told_us: Option<u64>,
    now_us: u64,
    ticked_us: u64,
    due_us: u64,
}

/// A call in the loop's time.
#[derive(Debug)]
pub(crate) struct Call {
    pub now_us: u64,
    pub is_tick: bool,
    /// Time since the tick before, µs.
    pub stood_us: u64,
    /// Ticks before it that had no call.
    pub skipped: u32,
    /// The time given is later than that of the call before.
    pub goes_on: bool,
}

impl ProgramClock {
    pub(crate) const fn new(period_us: u64) -> Self {
        Self {
            period_us,
            told_us: None,
            now_us: 0,
            ticked_us: 0,
            due_us: 0,
        }
    }

    pub(crate) fn call(&mut self, time_us: u64) -> Call {
        let before = self.told_us.replace(time_us);
        let goes_on = before.is_none_or(|before| time_us > before);
        let step_us = match before {
            None => 0,
            Some(before) if goes_on => (time_us - before).min(STEP_MOST_US),
            Some(_) => self.period_us,
        };
        self.now_us += step_us;
        let half_us = self.period_us / 2;
        let stood_us = self.now_us - self.ticked_us;
        let pauses = step_us > self.period_us + half_us;
        let is_tick = pauses || self.now_us + half_us >= self.due_us;
        let mut skipped = 0;
        if is_tick {
            // A division takes as long as a force, and is seldom needed.
            if pauses {
                skipped = (stood_us + half_us - 1) / self.period_us - 1;
                self.due_us += skipped * self.period_us;
            }
            self.ticked_us = self.now_us;
            let earliest_us = self.now_us.saturating_sub(half_us);
            self.due_us = self.due_us.clamp(earliest_us, self.now_us + half_us) + self.period_us;
        }
        Call {
            now_us: self.now_us,
            is_tick,
            stood_us,
            skipped: skipped as u32,
            goes_on,
        }
    }
}
