#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(unreachable_pub)]

pub mod drive;
pub mod estimate;
pub mod fit;
pub mod response;
pub mod robot;
#[cfg(test)]
mod tests;

use haptic_document::{
    FileError, Named, Table, parameters,
    parameters::{
        DEVICE, MAX_AGE_TICKS, Parameter, SAMPLE_TIME, SIMULATED, WATCHDOG, range::Range,
    },
};
use haptic_link::Limits;
use haptic_loop::{
    SafetyLimits, Stuck, Workspace,
    units::{Metres, Newtons, NewtonsPerSecond},
};

parameters! {
    pub mod keys;
    /// Sample time of a measurement, s.
    MEASURE_SAMPLE_TIME = number("sample_time_s", SAMPLE_TIME.default_number(), SAMPLE_TIME.shown, Range::Within(1e-4, 1e-2), "Sample time");
    /// Force limit of a device that is measured, N.
    MEASURE_FORCE_LIMIT = number("force_limit_n", 10.0, "10N", Range::Within(1e-3, 1e3),
        "Largest force of the device; the measurement uses at most a fifth");
    /// Box of a measurement, m.
    MEASURE_BOX = number("box_m", 5e-3, "5mm", Range::Within(1e-4, 1.0),
        "Largest distance from the start; beyond it the force falls to zero");
    /// Length of the multi-sine, s.
    MEASURE_DURATION = number("duration_s", 8.0, "8s", Range::Within(1.0, 600.0), "Length of the multi-sine");
    /// Speed of a robot that is measured, m/s.
    MEASURE_SPEED = number("speed_m_per_s", 0.02, "20mm/s", Range::Within(1e-3, 0.05), "Robot: largest speed; a device that takes a force has none");
    /// A hand at the device.
    HELD = flag("held", "A hand holds the device as still as it can; its stiffness is measured too");
    /// Axis of a board with several.
    MEASURE_AXIS = text("axis", "x", "Axis that is moved, on a board with several; the others get no force");
    /// The device that is measured.
    MEASURE_DEVICE = text("device", "serial:auto", DEVICE.help);
}

/// Keys of a measurement alone, without those of the device that it moves.
pub const MEASURE: &[Parameter] = &[
    MEASURE_SAMPLE_TIME,
    MEASURE_FORCE_LIMIT,
    MEASURE_BOX,
    MEASURE_DURATION,
    MEASURE_SPEED,
    HELD,
    MEASURE_AXIS,
];

/// An axis of a board, by its number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeasuredAxis(pub usize);

impl Named for MeasuredAxis {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (Self(0), "x", "The first axis, or the only one"),
        (Self(1), "y", "The second"),
        (Self(2), "z", "The third"),
    ];

    fn name(self) -> &'static str {
        Self::CHOICES.get(self.0).map_or("", |choice| choice.1)
    }
}

/// The question that measures a device by moving it.
pub const MEASUREMENT: &str = "measure";

/// Tables of keys of a measurement, under their headings.
pub const TABLES: [(&str, &[Parameter]); 3] = [
    (MEASUREMENT, MEASURE),
    ("simulated", SIMULATED),
    ("device", &[MEASURE_DEVICE, WATCHDOG, MAX_AGE_TICKS]),
];

/// Plan of a measurement: what the device may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasurePlan {
    /// T of the loop, s.
    pub sample_time_s: f64,
    /// Largest force that the device may make, N. The measurement uses at most the share
    /// [`SHARE`](Self::SHARE) of it.
    pub force_limit_n: f64,
    /// The device stays within this distance of where it is at the start, m.
    pub box_m: f64,
    /// Length of the multi-sine, s.
    pub duration_s: f64,
    /// Largest speed of a robot, m/s.
    pub speed_m_per_s: f64,
    /// True if a hand holds the device: its stiffness is measured too.
    pub hand: bool,
    /// The axis of a device at a port that is moved.
    pub axis: MeasuredAxis,
    /// Limits of the device itself, which a measurement keeps.
    pub own: OwnLimits,
}

/// Limits of a device itself: largest force, N, its rate, N/s, and ends of its workspace, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnLimits {
    /// Largest force, N; infinite for a device without limits of its own.
    pub force_n: f64,
    /// Largest rate of it, N/s.
    pub force_rate_n_per_s: f64,
    /// Ends of the workspace, m.
    pub workspace_m: [f64; 2],
}

impl OwnLimits {
    pub(crate) const NONE: Self = Self {
        force_n: f64::INFINITY,
        force_rate_n_per_s: f64::INFINITY,
        workspace_m: [f64::NEG_INFINITY, f64::INFINITY],
    };

    /// Limits that are set on a device, whose workspace is that of its first axis.
    pub fn of(set: &Limits, axis: MeasuredAxis) -> Self {
        let [low_m, high_m] = [set.workspace_low_m, set.workspace_high_m].map(f64::from);
        Self {
            force_n: set.force_n.into(),
            force_rate_n_per_s: set.force_rate_n_per_s.into(),
            workspace_m: if low_m < high_m && axis == MeasuredAxis(0) {
                [low_m, high_m]
            } else {
                Self::NONE.workspace_m
            },
        }
    }
}

impl MeasurePlan {
    /// Share of the force limit that is used at most.
    pub const SHARE: f64 = 0.2;
    /// Time without force at the beginning, s.
    const REST_S: f64 = 0.5;
    /// Time in which a ramp reaches the largest force, s.
    const RAMP_S: f64 = 1.5;
    /// Longest time on the way to the middle, s: a device that does not come so far is measured where it is.
    const CENTRE_S: f64 = 3.0;
    /// Share of [`near_m`](Self::near_m) that counts as a motion, and share of the box in which it may rest.
    const MOVES: f64 = 0.02;

    /// Rate of force that lets enough of the multi-sine through, in its largest force, 1/s: its slow lines, and less of its fast ones.
    const RATE_PER_S: f64 = 100.0;

    /// Forces that keep a device moving, in those at which it began to: of fewer than twice as many the multi-sine would have some only.
    const KEEPS_MOVING: f64 = 3.0;

    /// The plan of a table, within no limits of a device yet.
    ///
    /// # Errors
    /// A value that is wrong, with its place.
    pub fn read(table: &Table<'_>) -> Result<Self, FileError> {
        Ok(Self {
            sample_time_s: table.number(&MEASURE_SAMPLE_TIME)?,
            force_limit_n: table.number(&MEASURE_FORCE_LIMIT)?,
            box_m: table.number(&MEASURE_BOX)?,
            duration_s: table.number(&MEASURE_DURATION)?,
            speed_m_per_s: table.number(&MEASURE_SPEED)?,
            hand: table.flag(&HELD)?,
            axis: table.choice(&MEASURE_AXIS)?,
            own: OwnLimits::NONE,
        })
    }

    /// This plan within the limits of a device.
    pub fn within(self, own: OwnLimits) -> Self {
        let [low_m, high_m] = own.workspace_m;
        let box_m = f64::min(self.box_m, 0.5 * (high_m - low_m));
        Self { box_m, own, ..self }
    }

    /// Largest force of the measurement, N.
    pub fn force_n(&self) -> f64 {
        f64::min(Self::SHARE * self.force_limit_n, self.own.force_n)
    }

    /// Middle of the box of a device that is at `start_m`: as near to there as its workspace allows.
    fn middle_m(&self, start_m: f64) -> f64 {
        let [low_m, high_m] = self.own.workspace_m;
        start_m.max(low_m + self.box_m).min(high_m - self.box_m)
    }

    /// The length to which motions are compared, m: the box, but not more than the usual one. A wider box gives room, it asks for no more motion.
    fn near_m(&self) -> f64 {
        f64::min(self.box_m, MEASURE_BOX.default_number())
    }

    /// Limits of the safety chain of a device that is at `start_m`.
    pub fn limits(&self, start_m: f64) -> SafetyLimits {
        let (force, middle_m) = (self.force_n(), self.middle_m(start_m));
        let default = SafetyLimits::default();
        // As steep as the fastest line of the multi-sine, so that its highest frequencies get through.
        let rate = f64::max(default.rate.0, 1000.0 * force).min(self.own.force_rate_n_per_s);
        SafetyLimits {
            force: Newtons(force),
            norm: None,
            rate: NewtonsPerSecond(rate),
            brake_force: Newtons(f64::min(default.brake_force.0, force)),
            stuck: default.stuck.map(|stuck| Stuck {
                force: Newtons(force),
                ..stuck
            }),
            workspace: Some(Workspace {
                low: Metres(middle_m - self.box_m),
                high: Metres(middle_m + self.box_m),
                soft: Metres(0.1 * self.box_m),
            }),
            rise_time: None,
            ..default
        }
    }

    fn ticks(&self, time_s: f64) -> u64 {
        (time_s / self.sample_time_s).round() as u64
    }

    /// Most ticks that a measurement takes, its ramps and the way to zero included.
    pub fn ticks_at_most(&self) -> u64 {
        let to_the_middle_s = 2.0 * (Self::CENTRE_S + 0.3);
        self.ticks(Self::REST_S + 2.0 * Self::RAMP_S + 2.0 + to_the_middle_s + self.duration_s)
    }
}

/// Force applied and position read, tick by tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionRecord {
    /// T, from one entry to the next, s.
    pub sample_time_s: f64,
    /// Position at the start of each tick, m; not a number where the sample was lost.
    pub position_m: Vec<f64>,
    /// Force that the device applied from each tick on, N.
    pub force_n: Vec<f64>,
    /// Ticks at the beginning without any force.
    pub rest: usize,
    /// First tick of the multi-sine.
    pub driven_from: usize,
    /// Forces at which the device began to move, upwards and downwards, N.
    pub breakaway_n: Option<(f64, f64)>,
}

impl MotionRecord {
    /// An empty record with room for `ticks` ticks.
    fn with_capacity(sample_time_s: f64, ticks: usize) -> Self {
        Self {
            sample_time_s,
            position_m: Vec::with_capacity(ticks),
            force_n: Vec::with_capacity(ticks),
            ..Self::default()
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.position_m.len().min(self.force_n.len())
    }

    pub(crate) fn lost(&self) -> usize {
        self.position_m.iter().filter(|x| !x.is_finite()).count()
    }

    /// Appends a tick; the force is held over the missing ones before it.
    fn push(&mut self, missing: u64, position_m: f64, force_n: f64) {
        let last = self.force_n.last().copied().unwrap_or_default();
        for _ in 0..missing {
            self.position_m.push(f64::NAN);
            self.force_n.push(last);
        }
        self.position_m.push(position_m);
        self.force_n.push(force_n);
    }

    /// Largest magnitude of the force, N.
    pub fn largest_force_n(&self) -> f64 {
        self.force_n
            .iter()
            .fold(0.0, |most, f| f64::max(most, f.abs()))
    }

    /// Lowest and highest position about the first, m.
    pub fn reach_m(&self) -> (f64, f64) {
        let present = || self.position_m.iter().copied().filter(|x| x.is_finite());
        let start = present().next().unwrap_or_default();
        present().fold((0.0, 0.0), |(low, high), x| {
            (f64::min(low, x - start), f64::max(high, x - start))
        })
    }
}
