//! Promises of a device, and what was seen of each.

use serde::Serialize;
use std::fmt;

/// A promise of the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Promise {
    /// No force and no start before it is armed.
    Arm,
    /// Limits of force and rate hold, and a run cannot loosen them.
    ForceLimit,
    /// A stop takes the force to zero.
    Stop,
    /// A force that is no number is a fault.
    FiniteCheck,
    /// A silent host is a fault.
    Watchdog,
    /// The samples around a fault can be read afterwards.
    FlightRecorder,
    /// A new connection finds the device without force, and as it was set.
    Reconnect,
    /// The emergency stop is a fault until it is closed.
    EmergencyStop,
}

impl Promise {
    /// Every one, in the order in which they are tried.
    pub const ALL: [Self; 8] = [
        Self::Arm,
        Self::ForceLimit,
        Self::Stop,
        Self::FiniteCheck,
        Self::Watchdog,
        Self::FlightRecorder,
        Self::Reconnect,
        Self::EmergencyStop,
    ];
}

impl fmt::Display for Promise {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Arm => "arm",
            Self::ForceLimit => "force limit",
            Self::Stop => "stop",
            Self::FiniteCheck => "finite check",
            Self::Watchdog => "watchdog",
            Self::FlightRecorder => "flight recorder",
            Self::Reconnect => "reconnect",
            Self::EmergencyStop => "emergency stop",
        })
    }
}

/// A row of the table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Check {
    /// The promise.
    pub check: Promise,
    /// In words, with its numbers.
    pub promised: String,
    /// Observation.
    pub seen: String,
    /// True if it was kept; `None` if this device has nothing of the kind, or if it could not be judged.
    pub ok: Option<bool>,
    /// It could not be judged, which is neither kept nor broken: see `host_late`, or the link was lost, an earlier trial failed, a limit
    /// of the device ended the trial, or a fault the test.
    pub not_judged: bool,
    /// It could not be judged: this machine was late in every attempt, and the board let go because of that.
    pub host_late: bool,
    /// What was seen breaks it, whatever this machine did meanwhile.
    #[serde(skip)]
    pub(super) certain: bool,
}

impl Check {
    pub(super) fn judged(
        check: Promise,
        promised: impl Into<String>,
        seen: impl Into<String>,
        ok: bool,
    ) -> Self {
        Self {
            check,
            promised: promised.into(),
            seen: seen.into(),
            ok: Some(ok),
            not_judged: false,
            host_late: false,
            certain: false,
        }
    }

    /// The same; with this seen, it is broken for certain.
    pub(super) fn certain(self, certain: bool) -> Self {
        Self { certain, ..self }
    }

    /// A promise of which this device makes none.
    pub(super) fn absent(
        check: Promise,
        promised: impl Into<String>,
        seen: impl Into<String>,
    ) -> Self {
        Self {
            ok: None,
            ..Self::judged(check, promised, seen, false)
        }
    }

    /// One that was not tried to its end.
    pub(super) fn not_judged(
        check: Promise,
        promised: impl Into<String>,
        seen: impl Into<String>,
    ) -> Self {
        Self {
            not_judged: true,
            ..Self::absent(check, promised, seen)
        }
    }

    /// One that this machine was too late for, whatever was seen.
    pub(super) fn too_late(self, why: &str) -> Self {
        Self {
            host_late: true,
            ..self.spoiled(why)
        }
    }

    /// One whose trial ended before its end for this reason, whatever was seen.
    pub(super) fn spoiled(self, why: &str) -> Self {
        Self {
            seen: format!("not judged: {why}; {}", self.seen),
            ok: None,
            not_judged: true,
            ..self
        }
    }
}
