//! The exchange with a board behind a line of its own: a frame there in each tick, an answer back by the next.

use haptic_link::{NOT_TAKEN, UNANSWERED};

/// What of such an exchange came through, the same for every maker's board: the hardware tells it as it happens, and the loop counts it.
///
/// ```
/// use haptic_link::{NOT_TAKEN, UNANSWERED};
/// use haptic_remote::Exchange;
///
/// let mut exchange = Exchange::default();
/// assert_eq!(exchange.unanswered(), 1);
/// exchange.sent(false);
/// assert_eq!((exchange.flaws(), exchange.unmeasured()), (UNANSWERED, 1));
/// // The answer comes a tick late; meanwhile no force was sent.
/// exchange.answered();
/// assert_eq!(exchange.flaws(), NOT_TAKEN);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exchange {
    /// Ticks in a row without an answer.
    in_row: u32,
    /// Periods without a tick since the last answer.
    skipped: u32,
    /// Periods without an answer before the last one. A board measures sooner than its answer is read: the motion of a pause may show in
    /// the position after it, or in the next.
    before: u32,
    /// The force of the last tick did not go out.
    withheld: bool,
    flaws: u8,
}

impl Exchange {
    /// The answer of this tick has come.
    pub const fn answered(&mut self) {
        self.before = self.paused();
        (self.in_row, self.skipped) = (0, 0);
        self.flaws = if self.withheld { NOT_TAKEN } else { 0 };
    }

    /// It has not come. How many in a row have not by now.
    pub const fn unanswered(&mut self) -> u32 {
        self.in_row = self.in_row.saturating_add(1);
        self.flaws = UNANSWERED | if self.withheld { NOT_TAKEN } else { 0 };
        self.in_row
    }

    /// The board takes every force that goes out, or answers none: without an answer nothing says that it took the last.
    pub const fn unconfirmed(&mut self) -> u32 {
        self.withheld = true;
        self.unanswered()
    }

    /// The force of this tick went out to the board, or did not.
    pub const fn sent(&mut self, went_out: bool) {
        self.withheld = !went_out;
    }

    /// So many periods have passed without a tick.
    pub(crate) const fn skip(&mut self, periods: u32) {
        self.skipped = self.skipped.saturating_add(periods);
    }

    /// Ticks in a row without an answer.
    #[must_use]
    pub const fn silent_ticks(&self) -> u32 {
        self.in_row
    }

    /// Periods without an answer since the last one.
    const fn paused(&self) -> u32 {
        self.skipped.saturating_add(self.in_row)
    }

    /// Periods beyond one between the moments of the last position and of the next, at most: it may have moved further meanwhile, which is
    /// no jump.
    #[must_use]
    pub const fn unmeasured(&self) -> u32 {
        self.paused().saturating_add(self.before)
    }

    /// Flaws of the last tick, bits as in a [`Sample`](haptic_link::Sample).
    #[must_use]
    pub const fn flaws(&self) -> u8 {
        self.flaws
    }
}
