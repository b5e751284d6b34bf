//! Limits of a device and its passivity guard: their names, ranges and defaults, and what is tighter.

use crate::in_order::{Blank, Fixed, blank, in_order};
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

in_order! {
    /// Limits of force and motion. All numbers are finite; with one axis `force_n` limits the norm of the force too.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Schema)]
    pub struct Limits {
        /// Largest force, N, above 0.
        pub force_n: f32,
        /// Largest rate of force, N/s, above 0.
        pub force_rate_n_per_s: f32,
        /// Silence from the host that latches a fault while armed or running, ms, 5 to 1000; see
        /// [`LoopMode::watchdog_ms`] for the default.
        #[serde(with = "postcard::fixint::le")]
        pub watchdog_ms: u16 as Fixed,
        /// Number of late ticks in a row that latches a fault; 0 means never.
        #[serde(with = "postcard::fixint::le")]
        pub late_ticks: u16 as Fixed,
        /// Host loop: most ticks between a sample and the force that answers it, 1 to 1000; an
        /// older force latches a fault.
        #[serde(with = "postcard::fixint::le")]
        pub max_age_ticks: u16 as Fixed,
        /// Largest wanted force with which a device loop may start, N, 0 to 1e6; 0 allows any
        /// finite force.
        pub start_force_n: f32,
        /// Time from the start in which the applied share of the wanted force rises from 0 to 1, s,
        /// 0 to 60; 0 means at once.
        pub rise_time_s: f32,
        /// Lowest position, m, −100 to 100. There is no workspace if this and `workspace_high_m`
        /// are both 0.
        pub workspace_low_m: f32,
        /// Highest position, m, above the lowest, at most 100. Beyond either a fault latches.
        pub workspace_high_m: f32,
        /// Width of the zones at both ends in which an outward motion is braked, m, 0 or 1e-6 to half the
        /// workspace; 0 for none.
        pub workspace_soft_m: f32,
        /// Speed from which on the motion is braked, m/s, from 0 to 1e-6 below `speed_hard_m_per_s`.
        pub speed_soft_m_per_s: f32,
        /// Speed above which a fault latches, m/s, 1e-6 to 100; 0 for none.
        pub speed_hard_m_per_s: f32,
        /// Bandwidth of the velocity that is estimated from positions, Hz, 0.1 to 10 000.
        pub velocity_bandwidth_hz: f32,
        /// Viscous damping b that brakes near limits and after a fault or stop, N·s/m; 0 for none. Without a mass at
        /// most 5 N·s/m; with one b ≤ m/((2d + 1)·T), d = `device_delay_ticks`.
        pub braking_n_s_per_m: f32,
        /// After a fault or stop the force falls to zero within this time, whatever its rate limit, s, 0.001 to 1.
        pub stop_time_s: f32,
        /// Largest braking force after a fault or stop, N, 0 to 10, unless the force at that moment
        /// was larger; it falls with the rest.
        pub brake_force_n: f32,
        /// m, least mass that moves with the device, kg, 1e-6 to 100; 0 for unknown.
        pub device_mass_kg: f32,
        /// d, ticks from a force to its effect, rounded up.
        pub device_delay_ticks: u8,
        /// Rise of the wanted force, N, 0 to 1e4, that latches a fault while the reading stands still for
        /// `stuck_time_s`; 0 for never.
        pub stuck_force_n: f32,
        /// Time for which a reading must stand still, s, 0.001 to 10: see `stuck_force_n`.
        pub stuck_time_s: f32,
        /// A reading that changes within a tick by more than `speed_hard_m_per_s`·T plus this
        /// latches a fault, m, 1e-6 to 1; 0 means never.
        pub jump_m: f32,
        /// The guard that keeps the loop from feeding the device energy.
        pub guard: Guard,
    }
}

impl Limits {
    /// 10 N, 1000 N/s, 500 ms of silence, 20 late ticks, a start with at most 1 N that rises in 0.5
    /// s, 1.5 m/s, a jump of 1 mm, 3 N in 0.1 s on a sensor that stands still. Workspace, braking
    /// and guard are off, because they depend on the device.
    pub const DEFAULT: Self = Self {
        start_force_n: 1.0,
        rise_time_s: 0.5,
        speed_soft_m_per_s: 1.0,
        speed_hard_m_per_s: 1.5,
        stuck_force_n: 3.0,
        jump_m: 1e-3,
        ..Self::bare(10.0, 1000.0)
    };

    /// Force and its rate, 500 ms of silence, 20 late ticks, 0.1 s to stop; everything else off.
    #[must_use]
    pub const fn bare(force_n: f32, force_rate_n_per_s: f32) -> Self {
        Self {
            force_n,
            force_rate_n_per_s,
            watchdog_ms: LoopMode::Device.watchdog_ms(),
            late_ticks: 20,
            max_age_ticks: 10,
            start_force_n: 0.0,
            rise_time_s: 0.0,
            workspace_low_m: 0.0,
            workspace_high_m: 0.0,
            workspace_soft_m: 0.0,
            speed_soft_m_per_s: 0.0,
            speed_hard_m_per_s: 0.0,
            velocity_bandwidth_hz: 50.0,
            braking_n_s_per_m: 0.0,
            stop_time_s: 0.1,
            brake_force_n: 2.0,
            device_mass_kg: 0.0,
            device_delay_ticks: 1,
            stuck_force_n: 0.0,
            stuck_time_s: 0.1,
            jump_m: 0.0,
            guard: Guard::OFF,
        }
    }

    /// Shortest watchdog time, ms: a host cannot keep less.
    pub const WATCHDOG_MIN_MS: u16 = 5;
    /// Longest watchdog time, ms: an older force belongs to a position that the hand has left.
    pub const WATCHDOG_MAX_MS: u16 = 1000;
    /// Furthest end of a workspace from zero, m.
    pub const PLACE_MOST_M: f32 = 100.0;
    /// Least and most of [`stuck_time_s`](Self::stuck_time_s), s.
    pub const STUCK_TIME_S: [f64; 2] = [1e-3, 10.0];
    /// Largest [`max_age_ticks`](Self::max_age_ticks).
    pub const MAX_AGE_TICKS: u16 = 1000;
}

/// Direction in which a limit is tighter. NaN means no limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tighter {
    /// The smaller of two values is the tighter one.
    Less,
    /// The larger of two values is the tighter one.
    More,
    /// The smaller one, but 0 is no limit at all.
    LessUnlessOff,
}

/// A number of [`Limits`] that is a limit independent of the others: one row of [`Limits::TABLE`].
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// Its name on the wire; its key is [`Field::key`].
    pub field: Field,
    /// Finds the number in the limits.
    pub of: fn(&mut Limits) -> &mut f32,
    /// Least value; 0 is allowed too where it means no limit.
    pub least: f32,
    /// Largest value; a board may allow less.
    pub most: f32,
    /// Direction in which this limit is stricter.
    pub tighter: Tighter,
}

impl Limit {
    /// The least value allowed: 0 where a `value` of 0 means no limit, else `least`.
    #[must_use]
    pub const fn least_for(&self, value: f32) -> f32 {
        if value <= 0.0 && matches!(self.tighter, Tighter::LessUnlessOff) {
            0.0
        } else {
            self.least
        }
    }

    /// True if `value` is at least as tight as what is set.
    #[must_use]
    pub const fn is_tight(&self, value: f32, set: f32) -> bool {
        match self.tighter {
            Tighter::Less => value <= set,
            Tighter::More => value >= set,
            Tighter::LessUnlessOff => set <= 0.0 || (value > 0.0 && value <= set),
        }
    }
}

macro_rules! table {
    ($($field:ident $number:ident [$least:expr, $most:expr] $tighter:ident;)*) => {
        /// Once in memory, whoever reads it.
        static TABLE: [Limit; 11] = [$(Limit {
            field: Field::$field,
            of: |limits| &mut limits.$number,
            least: $least as f32,
            most: $most as f32,
            tighter: Tighter::$tighter,
        }),*];

        impl Limits {
            /// Least and most of each row of [`TABLE`](Self::TABLE) as they are written, for whoever asks a person.
            pub const RANGES: [[f64; 2]; 11] = [$([$least as f64, $most as f64]),*];
        }
    };
}

table! {
    ForceLimit force_n [f32::MIN_POSITIVE, 1e6] Less;
    ForceRateLimit force_rate_n_per_s [f32::MIN_POSITIVE, 1e10] Less;
    StartForce start_force_n [0.0, 1e6] LessUnlessOff;
    RiseTime rise_time_s [0.0, 60.0] More;
    SpeedHard speed_hard_m_per_s [1e-6, 100.0] LessUnlessOff;
    VelocityBandwidth velocity_bandwidth_hz [0.1, 1e4] More;
    StopTime stop_time_s [1e-3, 1.0] Less;
    BrakeForce brake_force_n [0.0, 10.0] Less;
    DeviceMass device_mass_kg [1e-6, 100.0] LessUnlessOff;
    StuckForce stuck_force_n [0.0, 1e4] LessUnlessOff;
    Jump jump_m [1e-6, 1.0] LessUnlessOff;
}

impl Limits {
    /// The limits that do not depend on one another. Workspace, speed zone, braking, stuck time and
    /// guard do: see [`tightened`](Self::tightened).
    pub const TABLE: &'static [Limit; 11] = &TABLE;

    /// These limits, each replaced by that of `set` where that is tighter; also the first one that
    /// was looser.
    ///
    /// - *Tighter* are less force, rate, force at a start, speed, a narrower workspace, a longer rise, a faster estimate
    ///   of the velocity, a shorter stop, less force of braking in it, a stricter look at the position.
    /// - *Mass and delay* of the device say how much braking it bears: less mass and more delay are tighter.
    /// - *Braking and guard* have no order: where they are on they stay as they were set, where they are off a run may
    ///   switch them on.
    /// - *Of the run* are watchdog, late ticks and age of a force, within their ranges: they suit its line and its host.
    #[must_use]
    pub fn tightened(&self, set: &Self) -> (Self, Option<Field>) {
        let mut looser = None;
        let (mut tight, mut of_set) = (*self, *set);
        for limit in Self::TABLE {
            let (value, set) = ((limit.of)(&mut tight), *(limit.of)(&mut of_set));
            let is_tight = limit.is_tight(*value, set);
            keep(value, set, is_tight, limit.field, &mut looser);
        }
        if set.stuck_force_n > 0.0 {
            let is_tight = self.stuck_time_s <= set.stuck_time_s;
            let (time, set) = (&mut tight.stuck_time_s, set.stuck_time_s);
            keep(time, set, is_tight, Field::StuckTime, &mut looser);
        }
        if set.device_mass_kg > 0.0 && self.device_delay_ticks < set.device_delay_ticks {
            looser.get_or_insert(Field::DeviceMass);
            tight.device_delay_ticks = set.device_delay_ticks;
        }
        self.tighten_workspace(set, &mut tight, &mut looser);
        self.tighten_braking(set, &mut tight, &mut looser);
        if set.guard.kind != GuardKind::Off && self.guard != set.guard {
            looser.get_or_insert(Field::GuardDamping);
            tight.guard = set.guard;
        }
        (tight, looser)
    }

    fn tighten_workspace(&self, set: &Self, tight: &mut Self, looser: &mut Option<Field>) {
        let (low, high) = (self.workspace_low_m, self.workspace_high_m);
        let (set_low, set_high) = (set.workspace_low_m, set.workspace_high_m);
        if set_low >= set_high {
            return;
        }
        let inside = low < high && low < set_high && high > set_low;
        let (is_low, is_high) = (inside && low >= set_low, inside && high <= set_high);
        let (low, high) = (&mut tight.workspace_low_m, &mut tight.workspace_high_m);
        keep(low, set_low, is_low, Field::WorkspaceLow, looser);
        keep(high, set_high, is_high, Field::WorkspaceHigh, looser);
    }

    fn tighten_braking(&self, set: &Self, tight: &mut Self, looser: &mut Option<Field>) {
        if set.braking_n_s_per_m > 0.0 {
            let same = (self.braking_n_s_per_m - set.braking_n_s_per_m).abs() <= 0.0;
            let braking = &mut tight.braking_n_s_per_m;
            keep(braking, set.braking_n_s_per_m, same, Field::Braking, looser);
            let half = 0.5 * (tight.workspace_high_m - tight.workspace_low_m);
            let least = set.workspace_soft_m.min(half);
            let (zone, wide) = (&mut tight.workspace_soft_m, self.workspace_soft_m >= least);
            keep(zone, least, wide, Field::WorkspaceSoft, looser);
            // 0 brakes every motion.
            if set.speed_hard_m_per_s > 0.0 {
                let most = set.speed_soft_m_per_s;
                let (soft, slow) = (
                    &mut tight.speed_soft_m_per_s,
                    self.speed_soft_m_per_s <= most,
                );
                keep(soft, most, slow, Field::SpeedSoft, looser);
            }
        }
        // If the hard limit came from the set configuration, the zone before it has to fit.
        if tight.speed_hard_m_per_s > 0.0 && tight.speed_soft_m_per_s >= tight.speed_hard_m_per_s
            || self.speed_hard_m_per_s <= 0.0
        {
            tight.speed_soft_m_per_s = set.speed_soft_m_per_s.min(tight.speed_hard_m_per_s);
        }
    }
}

/// Keeps a tight value; replaces a loose one by the set value, and records the first such field.
#[inline(never)]
fn keep(value: &mut f32, set: f32, is_tight: bool, field: Field, looser: &mut Option<Field>) {
    if !is_tight {
        *value = set;
        looser.get_or_insert(field);
    }
}

/// The side on which the loop runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum LoopMode {
    /// On the device; the host sets parameters and records.
    #[default]
    Device,
    /// On the host; the device reports its position and applies the force it is sent.
    Host,
}

impl LoopMode {
    /// The watchdog time unless given, ms: 20 in a host loop, whose force is as old as the silence, and 500 in a
    /// device loop, whose force does not come from the host.
    #[must_use]
    pub const fn watchdog_ms(self) -> u16 {
        match self {
            Self::Device => 500,
            Self::Host => 20,
        }
    }
}

in_order! {
    /// The passivity guard: keeps the loop from feeding the device energy.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Schema)]
    pub struct Guard {
        /// The kind of guard. The other fields are ignored when it is off.
        pub kind: GuardKind,
        /// N·s/m, 1e-6 to 1e6. Observer: the most damping that it adds. Energy bounding: viscous
        /// damping that the device certainly has.
        pub damping_n_s_per_m: f32,
        /// Energy bounding: share of that damping that the loop may use up, 0.001 to 1.
        pub share: f32,
        /// Time that a credit of energy lasts, s, from a tick to 3600. Energy bounding: 0 discards
        /// it at once.
        pub forget_s: f32,
        /// Energy bounding: least delay from a measurement to the effect of its force, ticks, 0 to `delay_most_samples`.
        pub delay_least_samples: f32,
        /// Energy bounding: largest such delay, ticks, at most 4; equal to `delay_least_samples` if
        /// the delay is known.
        pub delay_most_samples: f32,
        /// Energy bounding: time constant of the actuator, s, 0 to 64 ticks.
        pub lag_s: f32,
        /// Energy bounding: standard deviation of the noise of the position, m, 0 to 0.01.
        pub noise_m: f32,
    }
}

blank!(Guard: Self::OFF, GuardKind: Self::Off);

impl Guard {
    /// No guard; apart from the damping, the parameters are the starting values of energy bounding.
    pub const OFF: Self = Self {
        kind: GuardKind::Off,
        damping_n_s_per_m: 0.0,
        share: 0.8,
        forget_s: 0.5,
        delay_least_samples: 0.0,
        delay_most_samples: 0.0,
        lag_s: 0.0,
        noise_m: 0.0,
    };
}

/// The kind of passivity guard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum GuardKind {
    /// None.
    #[default]
    Off,
    /// Adds damping while more energy has come out than went in.
    Observer,
    /// Bounds the force by the energy at hand.
    EnergyBounding,
}

/// Names of what can be refused, each with its words and, of a limit, its key.
macro_rules! fields {
    ($($name:ident = $words:literal $(, $key:literal)?;)+) => {
        /// The fields that a device can refuse, numbered as on the wire.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
        pub enum Field {
            $(#[doc = $words] $name,)+
        }

        impl Field {
            /// The key of a limit in files, options and reports; empty for a field that is not a
            /// limit.
            #[must_use]
            pub const fn key(self) -> &'static str {
                match self {
                    $(Self::$name => concat!("" $(, $key)?),)+
                }
            }
        }

        impl core::fmt::Display for Field {
            /// The name of the parameter with its unit, as a person gives it.
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.write_str(match self {
                    $(Self::$name => $words,)+
                })
            }
        }
    };
}

fields! {
    TickPeriod = "sample time (ms)";
    Stiffness = "stiffness (N/m)";
    Dissipation = "dissipation (N·s^μ/m)";
    Surface = "surface (m)";
    IntegerPart = "integer part of the order";
    CoefficientCount = "number of coefficients";
    Coefficient = "coefficient";
    Offset = "offset of coefficients";
    ForceLimit = "force limit (N)", "force_limit_n";
    ForceRateLimit = "force rate limit (N/s)", "force_rate_limit_n_per_s";
    Watchdog = "watchdog time (ms)";
    SimulationKind = "simulation";
    Mass = "mass (kg)";
    Damping = "damping (N·s/m)";
    HandStiffness = "hand stiffness (N/m)";
    Push = "push (N)";
    Depth = "depth of the indentation (m)";
    RampTime = "ramp time (s)";
    BatchLength = "samples in a frame";
    Every = "ticks from sample to sample";
    FlightIndex = "index of a flight-recorder sample";
    StartForce = "start force (N)", "start_force_n";
    RiseTime = "rise time (s)", "rise_time_s";
    WorkspaceLow = "low end of the workspace (m)";
    WorkspaceHigh = "high end of the workspace (m)";
    WorkspaceSoft = "workspace soft zone (m)", "workspace_soft_m";
    SpeedSoft = "soft speed limit (m/s)", "speed_soft_m_per_s";
    SpeedHard = "speed limit (m/s)", "speed_limit_m_per_s";
    VelocityBandwidth = "velocity bandwidth (Hz)", "velocity_bandwidth_hz";
    Braking = "braking (N·s/m)", "braking_n_s_per_m";
    StopTime = "stop time (s)", "stop_time_s";
    BrakeForce = "brake force (N)", "brake_force_n";
    DeviceMass = "mass of the device (kg)", "device_mass_kg";
    StuckForce = "stuck force (N)", "stuck_force_n";
    StuckTime = "stuck time (s)", "stuck_time_s";
    Jump = "jump (m)", "jump_m";
    GuardDamping = "damping of the guard (N·s/m)";
    GuardShare = "share of the damping that the guard uses";
    GuardForget = "time in which the guard forgets (s)";
    GuardDelayLeast = "least delay of the guard (samples)";
    GuardDelayMost = "most delay of the guard (samples)";
    GuardLag = "lag of the actuator for the guard (s)";
    GuardNoise = "noise of the position for the guard (m)";
    MaxAge = "age of a force (ticks)";
    DepthMap = "map of the depth";
    Other = "a parameter of a newer version";
}

impl Field {
    /// Converts a number from the wire to the unit that [`Display`](core::fmt::Display) names.
    #[must_use]
    pub fn shown(self, on_the_wire: f32) -> f32 {
        if self == Self::TickPeriod {
            on_the_wire / 1000.0
        } else {
            on_the_wire
        }
    }
}
