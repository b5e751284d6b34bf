//! How late this host may be for a device, and what to allow it where it was later.

use crate::document::parameters::{MAX_AGE_TICKS, WATCHDOG};
use fracdiff::parameter::Shown;
use haptic_link::Limits;
use haptic_loop::Fault;

/// So many times as much is proposed.
const LONGER: u16 = 5;

/// How late a host may be for a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lateness {
    /// Silence after which the device lets go, ms.
    pub watchdog_ms: u16,
    /// Ticks from a sample to the force that answers it at most, in a loop on the host.
    pub max_age_ticks: u16,
}

impl Lateness {
    /// Five times as much, as far as can be; never less.
    #[must_use]
    pub fn longer(self) -> Self {
        let times = |value: u16, most: u16| value.saturating_mul(LONGER).min(most).max(value);
        Self {
            watchdog_ms: times(self.watchdog_ms, Limits::WATCHDOG_MAX_MS),
            max_age_ticks: times(self.max_age_ticks, Limits::MAX_AGE_TICKS),
        }
    }

    /// The watchdog time, s.
    #[must_use]
    pub(crate) fn watchdog_s(self) -> f64 {
        f64::from(self.watchdog_ms) / 1e3
    }

    /// What to do about a fault that comes of it, behind the words of the fault; `None` for another one.
    pub(crate) fn advice(self, fault: Fault) -> Option<String> {
        let longer = self.longer();
        let (is_most, most, more) = match fault {
            Fault::HostSilent => (
                longer.watchdog_ms == self.watchdog_ms,
                format!("{} ms is the longest watchdog time", self.watchdog_ms),
                format!(
                    "give it longer with {}",
                    WATCHDOG.set_to(Shown(longer.watchdog_s()))
                ),
            ),
            Fault::StaleForce => (
                longer.max_age_ticks == self.max_age_ticks,
                format!(
                    "{} ticks are the most that a force may be old",
                    self.max_age_ticks
                ),
                format!(
                    "allow it more with {}",
                    MAX_AGE_TICKS.set_to(longer.max_age_ticks)
                ),
            ),
            _ => return None,
        };
        Some(if is_most {
            format!("; {most}: look for what kept this machine or the line busy")
        } else {
            format!("; if this machine or the line was only busy, {more}")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_proposed_is_never_less_than_what_there_was() {
        for (watchdog_ms, watchdog_s) in [(1, 0.005), (20, 0.1), (300, 1.0), (999, 1.0)] {
            let lateness = Lateness {
                watchdog_ms,
                max_age_ticks: 10,
            };
            let advice = lateness.advice(Fault::HostSilent).expect("a remedy");
            let words = format!("`watchdog_s` = {}", Shown(watchdog_s));
            assert!(advice.ends_with(&words), "{advice}");
        }
        let most = Lateness {
            watchdog_ms: Limits::WATCHDOG_MAX_MS,
            max_age_ticks: Limits::MAX_AGE_TICKS,
        };
        for fault in [Fault::HostSilent, Fault::StaleForce] {
            let advice = most.advice(fault).expect("a remedy");
            assert!(advice.contains("look for what kept"), "{advice}");
        }
        assert_eq!(most.advice(Fault::Workspace), None);
    }

    #[test]
    fn a_force_that_was_too_old_has_a_remedy() {
        for (max_age_ticks, allowed) in [(10, "50"), (300, "1000")] {
            let lateness = Lateness {
                watchdog_ms: 20,
                max_age_ticks,
            };
            let advice = lateness.advice(Fault::StaleForce).expect("a remedy");
            assert!(
                advice.ends_with(&format!("`max_age_ticks` = {allowed}")),
                "{advice}"
            );
        }
    }
}
