//! Limits of a device and its passivity guard: their names, ranges and defaults, and what is tighter.

use crate::in_order::{Blank, Fixed, blank, in_order};
use haptic_loop::{Limit, SpeedLimit};
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
    pub const DEFAULT: Self = {
        let mut limits = Self::bare(0.0, 0.0);
        let mut row = 0;
        while row < Limit::ALL.len() {
            let (number, _) = limits.number(Limit::ALL[row]);
            *number = Limit::ALL[row].default_number() as f32;
            row += 1;
        }
        Self {
            speed_soft_m_per_s: SpeedLimit::SOFT.0 as f32,
            braking_n_s_per_m: 0.0,
            ..limits
        }
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
            velocity_bandwidth_hz: Limit::VelocityBandwidth.default_number() as f32,
            braking_n_s_per_m: 0.0,
            stop_time_s: Limit::StopTime.default_number() as f32,
            brake_force_n: Limit::BrakeForce.default_number() as f32,
            device_mass_kg: 0.0,
            device_delay_ticks: 1,
            stuck_force_n: 0.0,
            stuck_time_s: Limit::StuckTime.default_number() as f32,
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
    /// Largest [`max_age_ticks`](Self::max_age_ticks).
    pub const MAX_AGE_TICKS: u16 = 1000;
}

impl Limits {
    /// The number of a limit, and the field by which a device refuses it.
    #[must_use]
    // As `Limit::set`.
    #[inline(never)]
    pub const fn number(&mut self, limit: Limit) -> (&mut f32, Field) {
        match limit {
            Limit::Force => (&mut self.force_n, Field::ForceLimit),
            Limit::ForceRate => (&mut self.force_rate_n_per_s, Field::ForceRateLimit),
            Limit::StartForce => (&mut self.start_force_n, Field::StartForce),
            Limit::Speed => (&mut self.speed_hard_m_per_s, Field::SpeedHard),
            Limit::RiseTime => (&mut self.rise_time_s, Field::RiseTime),
            Limit::VelocityBandwidth => (&mut self.velocity_bandwidth_hz, Field::VelocityBandwidth),
            Limit::Braking => (&mut self.braking_n_s_per_m, Field::Braking),
            Limit::StopTime => (&mut self.stop_time_s, Field::StopTime),
            Limit::BrakeForce => (&mut self.brake_force_n, Field::BrakeForce),
            Limit::StuckForce => (&mut self.stuck_force_n, Field::StuckForce),
            Limit::StuckTime => (&mut self.stuck_time_s, Field::StuckTime),
            Limit::Jump => (&mut self.jump_m, Field::Jump),
            Limit::DeviceMass => (&mut self.device_mass_kg, Field::DeviceMass),
        }
    }

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
        for limit in Limit::ALL {
            let ((value, field), set_to) = (tight.number(limit), *of_set.number(limit).0);
            let no_effect =
                limit == Limit::StuckTime && Limit::StuckForce.is_off(set.stuck_force_n);
            let is_tight = no_effect || limit.is_tight(*value, set_to);
            keep(value, set_to, is_tight, field, &mut looser);
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
    /// Loop on the device; the host sets parameters and records.
    #[default]
    Device,
    /// Loop on the host; the device reports its position and applies the force it is sent.
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

/// Names of what can be refused, each with its words.
macro_rules! fields {
    ($($name:ident = $words:literal;)+) => {
        /// The fields that a device can refuse, numbered as on the wire.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
        pub enum Field {
            $(#[doc = $words] $name,)+
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
    ForceLimit = "force limit (N)";
    ForceRateLimit = "force rate limit (N/s)";
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
    StartForce = "start force (N)";
    RiseTime = "rise time (s)";
    WorkspaceLow = "low end of the workspace (m)";
    WorkspaceHigh = "high end of the workspace (m)";
    WorkspaceSoft = "workspace soft zone (m)";
    SpeedSoft = "soft speed limit (m/s)";
    SpeedHard = "speed limit (m/s)";
    VelocityBandwidth = "velocity bandwidth (Hz)";
    Braking = "braking (N·s/m)";
    StopTime = "stop time (s)";
    BrakeForce = "brake force (N)";
    DeviceMass = "mass of the device (kg)";
    StuckForce = "stuck force (N)";
    StuckTime = "stuck time (s)";
    Jump = "jump (m)";
    GuardDamping = "damping of the guard (N·s/m)";
    GuardShare = "share of the damping that the guard uses";
    GuardForget = "time in which the guard forgets (s)";
    GuardDelayLeast = "least delay of the guard (samples)";
    GuardDelayMost = "most delay of the guard (samples)";
    GuardLag = "lag of the actuator for the guard (s)";
    GuardNoise = "noise of the position for the guard (m)";
    MaxAge = "age of a force (ticks)";
    DepthMap = "map of the depth";
    OwnPush = "push of the device's own motor (N)";
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
