//! Why a run ended before its time.

use fracdiff::parameter::Shown;
use haptic_document::parameters::{MAX_AGE_TICKS, WATCHDOG};
use haptic_link::{FaultReport, Limits};
use haptic_loop::Fault;
use haptic_quantity::written;
use haptic_remote::{Impossible, LinkError};

/// Why a run ended before its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ending {
    /// Somebody asked for it.
    Interrupted,
    /// The safety chain latched a fault.
    Fault(Fault),
    /// The device latched a fault.
    DeviceFault(FaultReport),
    /// The device reported an impossible value.
    Impossible(Impossible),
    /// The link to the device cannot be used any more.
    LinkLost(LinkError),
    /// The device's own program, or another host, has stopped it.
    Stopped(LinkError),
    /// The other side of a line between two hands was silent for too long.
    Silent,
    /// The other side of such a line said goodbye.
    OtherLeft,
    /// The handle was not still while its force sensor was to be tared.
    Untared,
    /// The law that a motor pushed into swung: see [`MotorPush::swings`].
    Swing,
    /// The log could not be written.
    LogStopped,
}

/// Push of a motor into a law, N. The first swing of the law ends it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotorPush {
    /// Part of the force of the motor that renders the law.
    Own(f64),
    /// Push of the motor of a second device.
    Second(f64),
}

impl MotorPush {
    /// Share of the force of the device that renders the law, N.
    pub const fn own_n(self) -> f64 {
        match self {
            Self::Own(push_n) => push_n,
            Self::Second(_) => 0.0,
        }
    }

    /// True of a force that is a swing, N, within this limit: a law that holds a push makes at most twice that push on the way to rest, and
    /// never pulls. After a tap the limit alone tells.
    pub fn swings(self, force_n: f64, limit_n: f64, tapped: bool) -> bool {
        let (Self::Own(push_n) | Self::Second(push_n)) = self;
        let law_n = force_n - self.own_n();
        let beyond = law_n < -SWING_SHARE * push_n || law_n > push_n;
        beyond && !tapped || force_n.abs() >= AT_LIMIT * limit_n
    }
}

/// Share of the force limit that counts as the limit: single precision on a device rounds it.
pub const AT_LIMIT: f64 = 1.0 - 1e-6;

/// Pushes of the law's force that are a swing.
const SWING_SHARE: f64 = 3.0;

/// The one that takes the force away from a device that hears nothing more.
#[derive(Clone, Copy, Debug)]
pub struct ForceKeeper {
    /// This program itself, which serves it.
    pub served: bool,
    /// A watchdog of the device.
    pub alone: bool,
}

impl Default for ForceKeeper {
    fn default() -> Self {
        Self {
            served: false,
            alone: true,
        }
    }
}

/// Release of the force in a run that ended before its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LetGo {
    /// It fell to zero over several samples: at the limit of its rate, within the stop time, or braking.
    Ramped {
        /// Time of the last sample with a force, s.
        until_s: f64,
    },
    /// It was zero in the next sample.
    InOneSample,
    /// It was zero in the next sample that there is, after others that are missing.
    AfterGap {
        /// Time of the first sample without a force, s.
        zero_s: f64,
        /// The device has a watchdog of its own.
        alone: bool,
    },
    /// The device did not hear that it was to stop, and had a force up to this time, s; that was its last where it has fallen.
    PushedOn {
        /// Time of the last sample with a force, s.
        until_s: f64,
        /// A sample without one came after it.
        fallen: bool,
        /// The device has a watchdog of its own.
        alone: bool,
    },
    /// No sample shows the fall: the device lets the force fall.
    Unseen,
    /// There was none: the run was refused before it began.
    NeverBegan,
    /// The link is gone: the device lets go when its watchdog has run out.
    ByItself,
    /// The link is gone to a driver that may hold its last force.
    Held,
    /// The link is gone to a device that this program serves: it has taken the force away.
    TakenAway,
    /// The board of another maker failed. It was commanded to let go if it was still reachable, but may not have received that.
    Commanded,
}

/// The force in the samples after the last one that counts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Fall {
    /// Number of samples with a force.
    acting: u64,
    /// Time of the last of them, s.
    acting_until_s: f64,
    /// Time of the first without one, s, where those between it and the last with one are missing.
    zero_after_gap_s: Option<f64>,
    /// Tick of the last with one, of those that count too; `None` if one without came after it.
    last_acting: Option<u64>,
    seen: bool,
}

impl Fall {
    /// Takes a sample that counts.
    pub fn before(&mut self, tick: u64, force_n: f64) {
        self.seen = true;
        self.last_acting = (force_n != 0.0).then_some(tick);
    }

    /// True if the newest has no force.
    pub const fn has_fallen(&self) -> bool {
        self.last_acting.is_none()
    }

    /// Takes a sample behind those that count.
    pub fn after(&mut self, tick: u64, time_s: f64, force_n: f64) {
        self.seen = true;
        if force_n != 0.0 {
            self.acting += 1;
            self.acting_until_s = time_s;
            self.last_acting = Some(tick);
        } else if let Some(last) = self.last_acting.take()
            && tick > last + 1
        {
            self.zero_after_gap_s = Some(time_s);
        }
    }
}

impl LetGo {
    /// Release in a run that ended for this reason, on a device with this keeper.
    pub fn of(ended: Ending, fall: Fall, keeper: ForceKeeper) -> Self {
        match (ended, fall.zero_after_gap_s) {
            (
                Ending::Untared
                | Ending::LinkLost(LinkError::Refused {
                    request: "arm" | "start",
                    ..
                }),
                _,
            ) => Self::NeverBegan,
            (Ending::LinkLost(_), _) if keeper.served => Self::TakenAway,
            (Ending::LinkLost(_), _) if keeper.alone => Self::ByItself,
            (Ending::LinkLost(_), _) => Self::Held,
            // A program that is a device has no force from the call on that found it.
            (Ending::DeviceFault(report), _)
                if report.status.fault == Fault::BoardFailed.code()
                    && report.status.reason.some().is_none() =>
            {
                Self::Commanded
            }
            _ if !fall.has_fallen() => Self::Unseen,
            (Ending::DeviceFault(_), _) if !fall.seen => Self::Unseen,
            (_, Some(zero_s)) => Self::AfterGap {
                zero_s,
                alone: keeper.alone,
            },
            _ if fall.acting > 0 => Self::Ramped {
                until_s: fall.acting_until_s,
            },
            _ => Self::InOneSample,
        }
    }

    /// Release as by [`of`](Self::of), in a run whose device did not receive the stop.
    pub fn unheard(ended: Ending, fall: Fall, keeper: ForceKeeper) -> Self {
        match fall.acting {
            0 => Self::of(ended, fall, keeper),
            _ => Self::PushedOn {
                until_s: fall.acting_until_s,
                fallen: fall.has_fallen(),
                alone: keeper.alone,
            },
        }
    }

    /// The release as the end of a sentence.
    pub fn words(self) -> String {
        let at = |time_s| written("time_s", time_s);
        match self {
            Self::Ramped { until_s } => format!("the force ramped to zero until {}", at(until_s)),
            Self::InOneSample => "the force was zero one sample later".to_owned(),
            Self::AfterGap { zero_s, alone } => format!(
                "the force was zero at {}; no sample tells of the time before{}",
                at(zero_s),
                if alone { "" } else { ", in which a device without a watchdog keeps its last force" }
            ),
            Self::PushedOn { until_s, fallen: true, .. } => {
                format!("the device pushed on until {}, and then let go", at(until_s))
            }
            Self::PushedOn { until_s, fallen: false, alone } => format!(
                "the device still pushed at {}, and {}",
                at(until_s),
                if alone { "lets go by itself when its watchdog time is over" } else { HELD }
            ),
            Self::Unseen => "no sample tells how the force fell: the device lets it fall by itself, within its stop time".to_owned(),
            Self::NeverBegan => "before there was any force".to_owned(),
            Self::ByItself => "the device lets go by itself".to_owned(),
            Self::Held => HELD.to_owned(),
            Self::TakenAway => "this program has taken the force away".to_owned(),
            Self::Commanded => "if the board did not hear the stop, it may still push: switch its supply off before you touch it"
                .to_owned(),
        }
    }
}

/// The danger of a device without a watchdog that hears nothing any more.
const HELD: &str = "its driver may still push: switch it off";

impl Ending {
    /// True if a fault ended the run.
    pub const fn is_fault(self) -> bool {
        matches!(
            self,
            Self::Fault(_) | Self::DeviceFault(_) | Self::Impossible(_)
        )
    }

    /// The fault that ended it, as on the wire.
    pub const fn fault_code(self) -> Option<u8> {
        match self {
            Self::Fault(fault) => Some(fault.code()),
            Self::DeviceFault(report) => Some(report.status.fault),
            // A fault of the device, though it reports no code.
            Self::Impossible(_) => Some(Fault::BoardFailed.code()),
            Self::Interrupted | Self::Silent | Self::LinkLost(_) => None,
            Self::OtherLeft | Self::LogStopped | Self::Swing | Self::Untared | Self::Stopped(_) => {
                None
            }
        }
    }

    /// The kind of its event in a log.
    pub const fn kind(self) -> &'static str {
        match self {
            Self::Fault(_) | Self::DeviceFault(_) | Self::Impossible(_) => "fault",
            Self::Interrupted => "interrupted",
            Self::Silent => "silent",
            Self::LinkLost(_) => "link",
            Self::OtherLeft | Self::LogStopped | Self::Swing | Self::Untared | Self::Stopped(_) => {
                "ended"
            }
        }
    }

    /// Reason in words; for a device that this host was too late for, with the lateness that it may be allowed.
    pub fn reason(self, lateness: Option<Lateness>) -> String {
        match self {
            Self::Interrupted => "interrupted".to_owned(),
            Self::Fault(fault) => format!("fault: {fault}"),
            Self::DeviceFault(report) => {
                let fault = Fault::from_code(report.status.fault);
                let advice = lateness.zip(fault);
                let advice = advice.and_then(|(lateness, fault)| lateness.advice(fault));
                format!(
                    "{}{}",
                    LinkError::Faulted(report),
                    advice.unwrap_or_default()
                )
            }
            Self::Impossible(impossible) => LinkError::Impossible(impossible).to_string(),
            Self::LinkLost(error) | Self::Stopped(error) => error.to_string(),
            Self::Silent => "the other side was silent for too long".to_owned(),
            Self::OtherLeft => "the other side left".to_owned(),
            Self::Swing => format!(
                "the law swung: it reached the force limit or, without taps, pulled by more than the push or made more than {SWING_SHARE} times the push"
            ),
            Self::Untared => "the handle moved while its force sensor was tared: let go of it, take away what leans on it, and run it again".to_owned(),
            Self::LogStopped => "the log could not be written".to_owned(),
        }
    }
}

/// Factor by which longer times are proposed.
const LONGER: u16 = 5;

/// Lateness that a device allows its host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lateness {
    /// Silence after which the device lets go, ms.
    pub watchdog_ms: u16,
    /// Ticks from a sample to the force that answers it at most, in a loop on the host.
    pub max_age_ticks: u16,
}

impl Lateness {
    /// Five times as much, as far as can be; never less.
    pub fn longer(self) -> Self {
        let times = |value: u16, most: u16| value.saturating_mul(LONGER).min(most).max(value);
        Self {
            watchdog_ms: times(self.watchdog_ms, Limits::WATCHDOG_MAX_MS),
            max_age_ticks: times(self.max_age_ticks, Limits::MAX_AGE_TICKS),
        }
    }

    /// Silence after which the device lets go, s.
    pub fn watchdog_s(self) -> f64 {
        f64::from(self.watchdog_ms) / 1e3
    }

    /// Remedy for a fault caused by lateness, to follow the words of the fault; `None` for another fault.
    pub fn advice(self, fault: Fault) -> Option<String> {
        let longer = self.longer();
        let (is_most, most, more) = if fault == Fault::HostSilent {
            (
                longer.watchdog_ms == self.watchdog_ms,
                format!("{} ms is the longest watchdog time", self.watchdog_ms),
                WATCHDOG.set_to(Shown(longer.watchdog_s())),
            )
        } else if fault == Fault::StaleForce {
            (
                longer.max_age_ticks == self.max_age_ticks,
                format!("a force may be {} ticks old at most", self.max_age_ticks),
                MAX_AGE_TICKS.set_to(longer.max_age_ticks),
            )
        } else {
            return None;
        };
        Some(if is_most {
            format!("; {most}: look for what kept this machine or the line busy")
        } else {
            format!("; if this machine or the line was only busy, allow it more with {more}")
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::ending::*;

    fn reported(fault: Fault) -> FaultReport {
        let status = haptic_link::Status {
            state: haptic_link::State::Fault,
            fault: fault.code(),
            faults: 1,
            ..Default::default()
        };
        FaultReport {
            status,
            tick: 7,
            time_us: 7000,
        }
    }

    const fn keeper(served: bool, alone: bool) -> ForceKeeper {
        ForceKeeper { served, alone }
    }

    const KEEPERS: [ForceKeeper; 4] = [
        keeper(true, false),
        keeper(true, true),
        keeper(false, true),
        keeper(false, false),
    ];

    #[test]
    fn what_became_of_a_force_is_seen_in_the_log_or_nobody_knows() {
        let fault = |fault: Fault| Ending::DeviceFault(reported(fault));
        let mut report = reported(Fault::BoardFailed);
        report.status.reason = haptic_link::Reason::of(haptic_link::Trouble::Time);
        let of_program = Ending::DeviceFault(report);
        let refused = LinkError::Refused {
            request: "start",
            refusal: haptic_link::Refusal::Connection,
        };
        let none = Fall::default();
        let ramp = Fall {
            acting: 10,
            acting_until_s: 0.5,
            seen: true,
            ..none
        };
        let ramped = LetGo::Ramped { until_s: 0.5 };
        let gap = Fall {
            seen: true,
            zero_after_gap_s: Some(4.735),
            ..none
        };
        let still = Fall {
            last_acting: Some(7),
            ..ramp
        };
        for (ended, fall, let_go) in [
            (Ending::Interrupted, ramp, ramped),
            (Ending::Interrupted, none, LetGo::InOneSample),
            (Ending::Fault(Fault::Workspace), none, LetGo::InOneSample),
            (fault(Fault::HostSilent), ramp, ramped),
            (fault(Fault::HostSilent), still, LetGo::Unseen),
            (fault(Fault::HostSilent), none, LetGo::Unseen),
            (Ending::Interrupted, still, LetGo::Unseen),
            (fault(Fault::BoardFailed), none, LetGo::Commanded),
            (of_program, ramp, ramped),
            (Ending::LinkLost(refused), none, LetGo::NeverBegan),
        ] {
            for keeper in KEEPERS {
                assert_eq!(LetGo::of(ended, fall, keeper), let_go, "{ended:?} {fall:?}");
            }
        }
        let gone = Ending::LinkLost(LinkError::Gone);
        let lost = [
            LetGo::TakenAway,
            LetGo::TakenAway,
            LetGo::ByItself,
            LetGo::Held,
        ];
        for (keeper, lost) in KEEPERS.into_iter().zip(lost) {
            let let_go = LetGo::of(fault(Fault::HostSilent), gap, keeper);
            let (zero_s, alone) = (4.735, keeper.alone);
            assert_eq!(let_go, LetGo::AfterGap { zero_s, alone });
            assert_eq!(let_go.words().contains("without a watchdog"), !alone);
            assert_eq!(LetGo::of(gone, none, keeper), lost);
        }
        assert_eq!(
            LetGo::Held.words(),
            "its driver may still push: switch it off"
        );
    }

    #[test]
    fn a_stop_that_was_not_heard_is_told_by_the_samples_after_it() {
        let silent = Ending::DeviceFault(reported(Fault::HostSilent));
        let fell = Fall {
            acting: 10,
            seen: true,
            acting_until_s: 0.5,
            ..Fall::default()
        };
        let still = Fall {
            last_acting: Some(500),
            ..fell
        };
        for (fall, keeper, words) in [
            (
                fell,
                KEEPERS[2],
                "the device pushed on until 500 ms, and then let go",
            ),
            (
                still,
                KEEPERS[2],
                "the device still pushed at 500 ms, and lets go by itself when its watchdog time is over",
            ),
            (
                still,
                KEEPERS[3],
                "the device still pushed at 500 ms, and its driver may still push: switch it off",
            ),
        ] {
            let let_go = LetGo::unheard(silent, fall, keeper);
            assert_eq!(let_go.words(), words);
        }
    }

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
