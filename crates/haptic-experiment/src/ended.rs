//! Why a run ended before its time.

use haptic_link::FaultReport;
use haptic_loop::Fault;
use haptic_remote::LinkError;

/// Why a run ended before its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ended {
    /// Somebody asked for it.
    Interrupted,
    /// The safety chain latched a fault.
    Fault(Fault),
    /// The device latched a fault.
    DeviceFault(FaultReport),
    /// The link to the device cannot be used any more.
    LinkLost(LinkError),
    /// The other side of a line between two hands was silent for too long.
    Silent,
    /// The log could not be written.
    LogStopped,
}

/// What became of the force of a run that ended before its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LetGo {
    /// It fell to zero over several samples: at the limit of its rate, within the stop time, or braking.
    Ramped,
    /// It was zero in the next sample.
    InOneSample,
    /// The link is gone: the device lets go when its watchdog has run out.
    ByItself,
    /// The board of another maker failed; it was told to let go if it still could be, and nobody knows for sure if it has heard that.
    Told,
}

impl LetGo {
    /// Of a run that ended for this reason, in whose log so many samples with a force came after the last that counts.
    pub(crate) const fn of(ended: Ended, acting: u64) -> Self {
        match ended {
            Ended::LinkLost(_) => Self::ByItself,
            Ended::DeviceFault(report) if report.status.fault == Fault::BoardFailed.code() => {
                Self::Told
            }
            _ if acting > 0 => Self::Ramped,
            _ => Self::InOneSample,
        }
    }

    /// In words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Ramped => "the force ramped to zero",
            Self::InOneSample => "the force was zero one sample later",
            Self::ByItself => "the device lets go by itself",
            Self::Told => {
                "if the board has not heard that it is to make no force, as with its plug out, it may still push: switch its supply off \
                 before you touch it"
            }
        }
    }
}

impl Ended {
    /// True if a fault ended the run.
    #[must_use]
    pub const fn is_fault(self) -> bool {
        matches!(self, Self::Fault(_) | Self::DeviceFault(_))
    }

    /// In words; of a device that let go by its watchdog with a longer time than it had.
    #[must_use]
    pub fn reason(self, watchdog_ms: Option<u16>) -> String {
        match self {
            Self::Interrupted => "interrupted".to_owned(),
            Self::Fault(fault) => format!("fault: {fault}"),
            Self::DeviceFault(report) => {
                let silent = report.status.fault == Fault::HostSilent.code();
                let advice = watchdog_ms.filter(|_| silent).map(longer_watchdog);
                format!(
                    "{}{}",
                    LinkError::Faulted(report),
                    advice.unwrap_or_default()
                )
            }
            Self::LinkLost(error) => error.to_string(),
            Self::Silent => "the other side was silent for too long".to_owned(),
            Self::LogStopped => "the log could not be written".to_owned(),
        }
    }
}

/// Five times as long, as long as can be.
fn longer_watchdog(watchdog_ms: u16) -> String {
    let most = haptic_link::Limits::WATCHDOG_MAX_MS;
    if watchdog_ms >= most {
        return format!(
            "; {watchdog_ms} ms is the longest watchdog time: look for what kept this machine or the line busy"
        );
    }
    let longer = watchdog_ms.saturating_mul(5).min(most);
    let longer_s = f64::from(longer) / 1e3;
    format!("; if this machine was only busy, give it longer with `watchdog_s` = {longer_s}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_link::{State, Status};

    #[test]
    fn what_became_of_a_force_is_seen_in_the_log_or_nobody_knows() {
        let fault = |fault: Fault| {
            Ended::DeviceFault(FaultReport {
                status: Status {
                    state: State::Fault,
                    fault: fault.code(),
                    faults: 1,
                },
                tick: 7,
                time_us: 7000,
            })
        };
        for (ended, acting, let_go) in [
            (Ended::Interrupted, 10, LetGo::Ramped),
            (Ended::Interrupted, 0, LetGo::InOneSample),
            (Ended::Fault(Fault::Workspace), 0, LetGo::InOneSample),
            (fault(Fault::HostSilent), 10, LetGo::Ramped),
            (fault(Fault::BoardFailed), 0, LetGo::Told),
            (Ended::LinkLost(LinkError::Gone), 0, LetGo::ByItself),
        ] {
            assert_eq!(LetGo::of(ended, acting), let_go, "{ended:?} {acting}");
        }
    }
}
