//! Promises that this machine was too late to try: tried again, and at last not judged. A fault or silence because
//! this machine, which runs the host's half, was too busy breaks no promise of the device.

use super::bench::{Bench, Broken};
use super::promise::Check;
use haptic_loop::Fault;
use haptic_remote::LinkError;
use haptic_remote::serial::{SerialError, TroubleCause};

const ATTEMPTS: u32 = 5;

/// Tries promises, up to five times where this machine was late, and appends their rows; what else the trial had to say.
pub(super) fn in_time<T>(
    bench: &mut Bench<'_>,
    checks: &mut Vec<Check>,
    trial: impl Fn(&mut Bench<'_>) -> Result<(Vec<Check>, T), Broken>,
) -> Result<T, Broken> {
    let mut attempt = 1;
    loop {
        let late_before = bench.late_ticks()?;
        let (rows, result) = match trial(bench) {
            Err(Broken::Link(error)) if attempt < ATTEMPTS && bench.answers_again(&error)? => {
                attempt += 1;
                continue;
            }
            tried => tried?,
        };
        let (board, host) = (bench.board_excuse(late_before)?, bench.late.take());
        if board.is_some() {
            // Opened anew, the board knows nothing of the fault.
            let opened = bench.reconnect()?;
            opened.map_err(|_| Broken::Link(LinkError::Gone.into()))?;
        }
        let rows = within_limits(rows, bench.left.take());
        let Some(why) = excuse(&rows, board, host) else {
            checks.extend(rows);
            return Ok(result);
        };
        if attempt == ATTEMPTS {
            checks.extend(rows.into_iter().map(|check| check.too_late(&why)));
            return Ok(result);
        }
        attempt += 1;
    }
}

/// Why rows say nothing of the device: its board failed, or the device let go, because this machine was late. A force beyond its
/// limit has no excuse; rows that were kept although this machine was late need none, but for those of a board that said nothing.
fn excuse(rows: &[Check], board: Option<String>, host: Option<String>) -> Option<String> {
    if rows.iter().any(|check| check.certain) {
        return None;
    }
    let broken = rows.iter().any(|check| check.ok == Some(false));
    board.or_else(|| host.filter(|_| broken))
}

/// Rows of a trial that a limit of the device ended, in these words: what looks broken is not judged.
pub(super) fn within_limits(rows: Vec<Check>, left: Option<String>) -> Vec<Check> {
    let Some(why) = left.filter(|_| rows.iter().all(|check| !check.certain)) else {
        return rows;
    };
    let judged = |check: Check| match check.ok {
        Some(false) => check.spoiled(&why),
        _ => check,
    };
    rows.into_iter().map(judged).collect()
}

impl Bench<'_> {
    /// True if the device answers again after a question that it did not answer, and is without force: it was not heard in time.
    fn answers_again(&mut self, error: &SerialError) -> Result<bool, Broken> {
        if !matches!(error, SerialError::Link(LinkError::NoAnswer { .. })) {
            return Ok(false);
        }
        let held_up = self.answers_on()?;
        if held_up {
            self.calm()?;
            self.late = None;
        }
        Ok(held_up)
    }

    /// Ticks so far that were a period late, on the clock of whoever serves the device.
    fn late_ticks(&self) -> Result<u32, Broken> {
        Ok(self.link()?.statistics()?.overruns)
    }

    /// The lateness of this machine that made the board fail, in words; `None` for a board that failed by itself, or did not.
    fn board_excuse(&self, late_before: u32) -> Result<Option<String>, Broken> {
        // A link that could not be had again has its row already.
        let Ok(link) = self.link() else {
            return Ok(None);
        };
        let Some(trouble) = link.trouble() else {
            return Ok(None);
        };
        if link.status().fault != Fault::BoardFailed.code() {
            return Ok(None);
        }
        let late = self.late_ticks()?.wrapping_sub(late_before);
        match trouble.cause {
            TroubleCause::HostLate => Ok(Some(trouble.words)),
            TroubleCause::Gone if late > 0 => Ok(Some(format!(
                "this machine was late in {late} ticks; {}",
                trouble.words
            ))),
            TroubleCause::Gone => Err(Broken::Link(LinkError::Gone.into())),
            TroubleCause::Board => Ok(None),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Promise;

    #[test]
    fn a_late_machine_excuses_what_looks_broken_and_a_board_that_said_nothing_excuses_all() {
        let row = |ok| Check::judged(Promise::ForceLimit, "", "", ok);
        let late = |words: &str| Some(words.to_owned());
        let excuses = |rows: &[Check]| excuse(rows, None, late("host"));
        assert_eq!(excuse(&[row(false)], None, None), None);
        assert_eq!(excuses(&[row(true)]), None);
        assert_eq!(excuses(&[row(true), row(false)]), late("host"));
        for ok in [false, true] {
            let both = excuse(&[row(ok)], late("board"), late("host"));
            assert_eq!(both, late("board"));
        }
    }

    #[test]
    fn a_force_that_was_too_large_has_no_excuse() {
        let row = |certain| Check::judged(Promise::ForceLimit, "", "", false).certain(certain);
        let late = || Some("late".to_owned());
        assert_eq!(excuse(&[row(true), row(false)], late(), late()), None);
    }
}
