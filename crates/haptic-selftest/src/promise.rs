//! Input and output of a self-test: settings, notices to the person beside the device, promises, rows.

use fracdiff::enumerated;
use fracdiff::parameter::Shown;
use haptic_document::parameters::FORCE_LIMIT;
use haptic_document::{Failure, Named};
use haptic_remote::serial::SerialLink;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A test of what a device promises, with a force that a hand holds easily.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelfTest {
    /// Force limit during the test, N; the device's own limit applies if it is lower.
    pub force_limit_n: f64,
    /// Period of the loop in the trials, µs; the nearest that the device has.
    pub period_us: u32,
    /// Availability of a person to press the emergency stop, if the device has one.
    pub emergency_stop: EmergencyStop,
}

/// The emergency stop of a device, which only a person can press.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmergencyStop {
    /// A simulated device has none; on a real one somebody presses it.
    AsTheDevice,
    /// The device has none, so that promise is not tried.
    Absent,
    /// Somebody presses it on request, even on a device that reports itself as simulated.
    Pressed,
}

impl SelfTest {
    /// 0.1 N, 1 kHz.
    pub const DEFAULT: Self = Self {
        force_limit_n: 0.1,
        period_us: 1000,
        emergency_stop: EmergencyStop::AsTheDevice,
    };
    /// Silence after which the device has to let go, ms.
    pub(super) const WATCHDOG_MS: u16 = 200;
    /// Range of [`force_limit_n`](Self::force_limit_n): what a hand can feel but hold without
    /// effort.
    pub const FORCE_LIMIT_N: [f64; 2] = [1e-3, 2.0];
    /// Time in which somebody presses the emergency stop, and in which they release it.
    pub const PATIENCE: Duration = Duration::from_secs(30);

    pub(super) fn check(&self) -> Result<(), Failure> {
        let [least, most] = Self::FORCE_LIMIT_N;
        if !(least..=most).contains(&self.force_limit_n) {
            return Err(Failure::bad_input(format_args!(
                "force limit {} N of a self-test is not in [{least}, {most}] N: change {FORCE_LIMIT}",
                Shown(self.force_limit_n)
            )));
        }
        Ok(())
    }
}

impl Named for EmergencyStop {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Pressed, "pressed", "Somebody presses it when told to"),
        (Self::Absent, "none", "The device has none"),
    ];

    fn name(self) -> &'static str {
        match self {
            // Nobody chooses this one.
            Self::AsTheDevice => "",
            Self::Pressed => "pressed",
            Self::Absent => "none",
        }
    }
}

/// Notice for the person beside the device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Notice {
    /// The device is real and may move with this force, N.
    MayMove(f32),
    /// This promise is tried now.
    Trying(Promise),
    /// Nothing comes from the device; it is asked on for some seconds.
    Silent,
    /// The emergency stop is to be pressed within [`SelfTest::PATIENCE`].
    PressEmergencyStop,
    /// It is to be released again.
    ReleaseEmergencyStop,
}

/// The caller's side of the test: it connects, watches, and may end the test.
#[derive(Clone, Copy)]
pub struct Attendant<'a> {
    /// Connects with the device, by a link that `stop` stops; called again after the link was closed.
    pub connect: &'a dyn Fn() -> Result<SerialLink, Failure>,
    /// Hears what the person beside the device has to know or do now.
    pub notice: &'a dyn Fn(Notice),
    /// Set to end the test.
    pub stop: &'a AtomicBool,
}

impl fmt::Debug for Attendant<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Attendant").finish_non_exhaustive()
    }
}

pub(super) const AXES: [&str; 3] = ["x", "y", "z"];

enumerated! {
    /// A promise of the device.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Promise {
        /// No force and no start before it is armed.
        Arm "arm",
        /// Limits of force and rate hold, and a run cannot loosen them.
        ForceLimit "force limit",
        /// A stop takes the force to zero.
        Stop "stop",
        /// It moves with its force.
        Direction "direction",
        /// A force that is no number is a fault.
        FiniteCheck "finite check",
        /// A silent host is a fault.
        Watchdog "watchdog",
        /// The samples around a fault can be read afterwards.
        FlightRecorder "flight recorder",
        /// A new connection finds the device without force, and as it was set.
        Reconnect "reconnect",
        /// The emergency stop is a fault until it is closed.
        EmergencyStop "emergency stop",
    }
}

impl fmt::Display for Promise {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A row of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// The promise that this row is about.
    pub check: Promise,
    /// The result in words, with its numbers.
    pub promised: String,
    /// The observation in words, with its numbers; or the reason why it was not judged.
    pub seen: String,
    /// True if it was kept; `None` if this device lacks the function, or it could not be judged.
    pub ok: Option<bool>,
    /// It could not be judged, which is neither kept nor broken: see `host_late`, or the link was lost, an earlier trial failed, a limit
    /// of the device ended the trial, or a fault the test.
    pub not_judged: bool,
    /// True if it could not be judged because this machine was late in every attempt and the board
    /// therefore let go.
    pub host_late: bool,
    /// Measured values, by names that end in their units.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub figures: BTreeMap<&'static str, f64>,
    /// True if the observation breaks the promise, whatever this machine did meanwhile.
    #[serde(skip)]
    pub(super) certain: bool,
}

impl Check {
    pub(super) fn judged(
        check: Promise,
        promised: impl Into<String>,
        seen: impl Into<String>,
        ok: impl Into<Option<bool>>,
    ) -> Self {
        Self {
            check,
            promised: promised.into(),
            seen: seen.into(),
            ok: ok.into(),
            not_judged: false,
            host_late: false,
            figures: BTreeMap::new(),
            certain: false,
        }
    }

    pub(super) fn figure(mut self, name: &'static str, value: impl Into<f64>) -> Self {
        self.figures.insert(name, value.into());
        self
    }

    /// One row for several axes: the worst of them, which its words name, or with `all` the words of each.
    pub(super) fn of_axes(mut rows: Vec<Self>, all: bool) -> Option<Self> {
        let is_one = rows.len() == 1;
        let named = rows.iter().zip(AXES).map(|(row, axis)| {
            if is_one {
                row.seen.clone()
            } else {
                format!("{axis}: {}", row.seen)
            }
        });
        let mut words: Vec<String> = named.collect();
        let badness = |row: &Self| match row.ok {
            Some(false) => 3 + u8::from(row.certain),
            None => 1 + u8::from(row.not_judged),
            Some(true) => 0,
        };
        let most = rows.iter().map(badness).max()?;
        let worst = rows.iter().position(|row| badness(row) == most)?;
        let seen = if all {
            words.join("; ")
        } else {
            words.swap_remove(worst)
        };
        Some(Self {
            seen,
            ..rows.swap_remove(worst)
        })
    }

    /// Row that says whether, with this seen, it is broken for certain.
    pub(super) fn certain(self, certain: bool) -> Self {
        Self { certain, ..self }
    }

    /// One that was not tried to its end.
    pub(super) fn not_judged(
        check: Promise,
        promised: impl Into<String>,
        seen: impl Into<String>,
    ) -> Self {
        Self {
            not_judged: true,
            ..Self::judged(check, promised, seen, None)
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
