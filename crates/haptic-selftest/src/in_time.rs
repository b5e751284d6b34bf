//! Trials that this machine was late for: tried again, and at last not judged.
//!
//! The device half of a board of another maker runs on this machine. Where it is too busy, the board hears nothing, or its answer
//! waits here, and fault 12 ends the trial: that breaks no promise of the device.

use super::bench::{Bench, Broken};
use super::promise::Check;
use super::trial::ATTEMPTS;
use haptic_loop::Fault;
use haptic_remote::LinkError;
use haptic_remote::serial::TroubleCause;

/// Tries promises, up to five times where this machine was late, and appends their rows; what else the trial had to say.
///
/// # Errors
/// As the trial; a board from which nothing comes any more.
pub(super) fn in_time<T>(
    bench: &mut Bench<'_>,
    checks: &mut Vec<Check>,
    trial: impl Fn(&mut Bench<'_>) -> Result<(Vec<Check>, T), Broken>,
) -> Result<T, Broken> {
    let mut attempt = 1;
    loop {
        let late_before = bench.late_ticks()?;
        let (rows, told) = trial(bench)?;
        let excuse = match is_open(&rows) {
            true => bench.excuse(late_before)?,
            false => None,
        };
        let Some(why) = excuse else {
            checks.extend(rows);
            return Ok(told);
        };
        // Opened anew, the board knows nothing of the fault.
        let opened = bench.reconnect()?;
        opened.map_err(|_| Broken::Link(LinkError::Gone.into()))?;
        if attempt == ATTEMPTS {
            checks.extend(rows.into_iter().map(|check| check.too_late(&why)));
            return Ok(told);
        }
        attempt += 1;
    }
}

/// True if a promise looks broken, and none is for certain: a force beyond its limit has no excuse.
fn is_open(rows: &[Check]) -> bool {
    let broken = rows.iter().any(|check| check.ok == Some(false));
    broken && !rows.iter().any(|check| check.certain)
}

impl Bench<'_> {
    /// Ticks so far that were a period late, on the clock of whoever serves the device.
    fn late_ticks(&self) -> Result<u32, Broken> {
        Ok(self.link()?.statistics()?.overruns)
    }

    /// The lateness of this machine that made the board fail, in words; `None` for a board that failed by itself, or did not.
    ///
    /// # Errors
    /// Nothing comes from the board any more, and this machine was not late.
    fn excuse(&self, late_before: u32) -> Result<Option<String>, Broken> {
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
    fn a_force_that_was_too_large_has_no_excuse() {
        let row = |ok| Check::judged(Promise::ForceLimit, "", "", ok);
        assert!(!is_open(&[row(true)]));
        assert!(is_open(&[row(true), row(false)]));
        assert!(!is_open(&[row(false).certain(true), row(false)]));
    }
}
