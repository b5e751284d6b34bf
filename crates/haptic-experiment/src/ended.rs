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

impl Ended {
    /// True if the link ended the run.
    #[must_use]
    pub const fn is_link(self) -> bool {
        matches!(self, Self::LinkLost(_))
    }

    /// True if the board of another maker failed: then nobody knows for sure if it has heard that there is to be no force.
    #[must_use]
    pub const fn is_board(self) -> bool {
        match self {
            Self::DeviceFault(report) => report.status.fault == Fault::BoardFailed.code(),
            _ => false,
        }
    }

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
