//! Everything that can be set on a device, in one structure and a list of coefficients.

use crate::frame::CRC;
use crate::request::CoefficientBlock;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Coefficients in a [`CoefficientBlock`].
pub const COEFFICIENTS_PER_BLOCK: usize = 16;

/// Blocks that hold this many coefficients.
#[must_use]
pub const fn block_count(coefficients: u16) -> u16 {
    coefficients.div_ceil(COEFFICIENTS_PER_BLOCK as u16)
}

/// The whole configuration but the coefficients. Applied in one transaction: stage this, stage the
/// blocks of coefficients, commit with the digest of both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Configuration {
    /// Where the loop is closed.
    pub loop_mode: LoopMode,
    /// T, µs.
    #[serde(with = "postcard::fixint::le")]
    pub tick_period_us: u32,
    /// K, N/m.
    pub stiffness_n_per_m: f32,
    /// B, N·s^μ/m.
    pub dissipation_n_s_mu_per_m: f32,
    /// μ, for the record: the coefficients are what counts.
    pub order: f32,
    /// The environment begins at `surface_m` and pushes but never pulls.
    pub one_sided: bool,
    /// m.
    pub surface_m: f32,
    /// The operator's coefficients.
    pub operator: OperatorShape,
    /// Limits.
    pub limits: Limits,
    /// The plant of a simulated device.
    pub simulation: Simulation,
}

/// Where the loop is closed.
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

/// What a list of coefficients is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum OperatorForm {
    /// g, k₁, …: weights of the newest sample and of those before.
    #[default]
    Taps,
    /// g, k₁, …, k₁₅, then a pair (d, W) for each decaying mode.
    Modes,
    /// g, then a pair (b, a) for each degree of a recursion.
    Recursion,
    /// gain, g, then three (direct, decay, slow) for each first-order section.
    Sections,
}

/// How to read the coefficients of an operator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct OperatorShape {
    /// What they are.
    pub form: OperatorForm,
    /// Differences (> 0) or sums (< 0) around them, −2 to 2.
    pub integer: i8,
    /// How many.
    #[serde(with = "postcard::fixint::le")]
    pub count: u16,
}

/// What the device may do. All numbers are finite; with one axis `force_n` limits the norm of the force too.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Limits {
    /// Largest force, N, above 0.
    pub force_n: f32,
    /// Largest rate of force, N/s, above 0.
    pub force_rate_n_per_s: f32,
    /// Silence from the host that latches a fault while armed or running, ms, 5 to 1000; see
    /// [`LoopMode::watchdog_ms`] for the default.
    #[serde(with = "postcard::fixint::le")]
    pub watchdog_ms: u16,
    /// Late ticks in a row that latch a fault; 0 for never.
    #[serde(with = "postcard::fixint::le")]
    pub late_ticks: u16,
    /// Host loop: ticks from a sample to the force that answers it at most; an older force latches a fault. 1 to 1000.
    #[serde(with = "postcard::fixint::le")]
    pub max_age_ticks: u16,
    /// Largest wanted force with which a device loop may start, N, at least 0; 0 for any finite one.
    pub start_force_n: f32,
    /// From the start on the share of the wanted force that is used rises from 0 to 1 in this time, s,
    /// 0 to 60; 0 for at once.
    pub rise_time_s: f32,
    /// Lowest position, m, −100 to 100. With `workspace_high_m` both 0: no workspace.
    pub workspace_low_m: f32,
    /// Highest position, m, above the lowest, at most 100. Beyond either a fault latches.
    pub workspace_high_m: f32,
    /// Width of the zones at both ends in which an outward motion is braked, m, 0 or 1e-6 to half the
    /// workspace; 0 for none.
    pub workspace_soft_m: f32,
    /// Speed from which on the motion is braked, m/s, from 0 to 1e-6 below `speed_hard_m_per_s`.
    pub speed_soft_m_per_s: f32,
    /// Speed above which a fault latches, m/s, at most 1000; 0 for none.
    pub speed_hard_m_per_s: f32,
    /// Bandwidth of the velocity that is estimated from positions, Hz, 0.1 to 10 000.
    pub velocity_bandwidth_hz: f32,
    /// Viscous damping b that brakes near limits and after a fault or stop, N·s/m; 0 for none. Without a mass at
    /// most 5 N·s/m; with one b ≤ m/((2d + 1)·T), d = `device_delay_ticks`.
    pub braking_n_s_per_m: f32,
    /// After a fault or stop the force falls to zero within this time, whatever its rate limit, s, 0.001 to 1.
    pub stop_time_s: f32,
    /// Largest force with which braking goes on after a fault or stop, if that of the moment is smaller, N,
    /// 0 to 10; it falls with the rest.
    pub brake_force_n: f32,
    /// m, least mass that moves with the device, kg, 1e-6 to 1000; 0 for unknown.
    pub device_mass_kg: f32,
    /// d, ticks from a force to its effect, rounded up.
    pub device_delay_ticks: u8,
    /// A reading that stands still for `stuck_time_s` and goes on while the wanted force grows by more than this
    /// latches a fault, N, at least 0; 0 for never.
    pub stuck_force_n: f32,
    /// See `stuck_force_n`, s, 0.001 to 10.
    pub stuck_time_s: f32,
    /// A reading that moves in a tick by more than `speed_hard_m_per_s`·T and this latches a fault, m, 1e-6 to 1;
    /// 0 for never.
    pub jump_m: f32,
    /// Passivity guard.
    pub guard: Guard,
}

/// The passivity guard: keeps the loop from feeding the device energy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Guard {
    /// Which. The other fields are not looked at when it is off.
    pub kind: GuardKind,
    /// N·s/m, 1e-6 to 1e6. Observer: the most damping that it adds. Energy bounding: viscous damping that the
    /// device surely has.
    pub damping_n_s_per_m: f32,
    /// Energy bounding: share of that damping that the loop may use up, 0.001 to 1.
    pub share: f32,
    /// How long a credit of energy lasts, s, from a tick to 3600. Energy bounding: 0 gives it up at once.
    pub forget_s: f32,
    /// Energy bounding: least delay from a measurement to the effect of its force, ticks, 0 to `delay_most_samples`.
    pub delay_least_samples: f32,
    /// Energy bounding: most, ticks, at most 4; the same if the delay is known.
    pub delay_most_samples: f32,
    /// Energy bounding: time constant of the actuator, s, 0 to 64 ticks.
    pub lag_s: f32,
    /// Energy bounding: standard deviation of the noise of the position, m, 0 to 0.01.
    pub noise_m: f32,
}

/// Which passivity guard.
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

/// The plant of a simulated device.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Simulation {
    /// What is simulated.
    pub kind: SimulationKind,
    /// Mass of the device, kg.
    pub mass_kg: f32,
    /// Its viscous damping, N·s/m.
    pub damping_n_s_per_m: f32,
    /// Stiffness of the hand, N/m.
    pub hand_stiffness_n_per_m: f32,
    /// Constant push of the hand, N.
    pub push_n: f32,
    /// Indentation that is held, m.
    pub depth_m: f32,
    /// Time to reach it, s.
    pub ramp_time_s: f32,
}

/// What a simulated device simulates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum SimulationKind {
    /// Nothing: a real device.
    #[default]
    Real,
    /// A mass-damper with a hand that pushes.
    MassDamper,
    /// An indentation by ramp and hold, imposed exactly.
    RigidIndentation,
    /// The same by an indenter of its own mass and servo, through a stiff contact.
    CompliantIndentation,
}

/// Names of what can be refused; numbers as on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Field {
    /// [`Configuration::tick_period_us`].
    TickPeriod,
    /// [`Configuration::stiffness_n_per_m`].
    Stiffness,
    /// [`Configuration::dissipation_n_s_mu_per_m`].
    Dissipation,
    /// [`Configuration::surface_m`].
    Surface,
    /// [`OperatorShape::integer`].
    IntegerPart,
    /// [`OperatorShape::count`].
    CoefficientCount,
    /// A coefficient.
    Coefficient,
    /// [`CoefficientBlock::offset`], or that of a request for one.
    Offset,
    /// [`Limits::force_n`].
    ForceLimit,
    /// [`Limits::force_rate_n_per_s`].
    ForceRateLimit,
    /// [`Limits::watchdog_ms`].
    Watchdog,
    /// [`Simulation::kind`].
    SimulationKind,
    /// [`Simulation::mass_kg`].
    Mass,
    /// [`Simulation::damping_n_s_per_m`].
    Damping,
    /// [`Simulation::hand_stiffness_n_per_m`].
    HandStiffness,
    /// [`Simulation::push_n`].
    Push,
    /// [`Simulation::depth_m`].
    Depth,
    /// [`Simulation::ramp_time_s`].
    RampTime,
    /// Samples in a frame.
    BatchLength,
    /// Ticks from a sent sample to the next.
    Every,
    /// Index of a flight-recorder sample.
    FlightIndex,
    /// [`Limits::start_force_n`].
    StartForce,
    /// [`Limits::rise_time_s`].
    RiseTime,
    /// [`Limits::workspace_low_m`].
    WorkspaceLow,
    /// [`Limits::workspace_high_m`].
    WorkspaceHigh,
    /// [`Limits::workspace_soft_m`].
    WorkspaceSoft,
    /// [`Limits::speed_soft_m_per_s`].
    SpeedSoft,
    /// [`Limits::speed_hard_m_per_s`].
    SpeedHard,
    /// [`Limits::velocity_bandwidth_hz`].
    VelocityBandwidth,
    /// [`Limits::braking_n_s_per_m`].
    Braking,
    /// [`Limits::stop_time_s`].
    StopTime,
    /// [`Limits::brake_force_n`].
    BrakeForce,
    /// [`Limits::device_mass_kg`].
    DeviceMass,
    /// [`Limits::stuck_force_n`].
    StuckForce,
    /// [`Limits::stuck_time_s`].
    StuckTime,
    /// [`Limits::jump_m`].
    Jump,
    /// [`Guard::damping_n_s_per_m`].
    GuardDamping,
    /// [`Guard::share`].
    GuardShare,
    /// [`Guard::forget_s`].
    GuardForget,
    /// [`Guard::delay_least_samples`].
    GuardDelayLeast,
    /// [`Guard::delay_most_samples`].
    GuardDelayMost,
    /// [`Guard::lag_s`].
    GuardLag,
    /// [`Guard::noise_m`].
    GuardNoise,
    /// [`Limits::max_age_ticks`].
    MaxAge,
    /// Another one, of a newer version.
    Other,
}

impl core::fmt::Display for Field {
    /// The name of the parameter with its unit, as in files and on command lines.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::TickPeriod => "tick period (µs)",
            Self::Stiffness => "stiffness (N/m)",
            Self::Dissipation => "dissipation (N·s^μ/m)",
            Self::Surface => "surface (m)",
            Self::IntegerPart => "integer part of the order",
            Self::CoefficientCount => "number of coefficients",
            Self::Coefficient => "coefficient",
            Self::Offset => "offset of coefficients",
            Self::ForceLimit => "force limit (N)",
            Self::ForceRateLimit => "force rate limit (N/s)",
            Self::Watchdog => "watchdog time (ms)",
            Self::SimulationKind => "simulation",
            Self::Mass => "mass (kg)",
            Self::Damping => "damping (N·s/m)",
            Self::HandStiffness => "stiffness of the hand (N/m)",
            Self::Push => "push (N)",
            Self::Depth => "depth of the indentation (m)",
            Self::RampTime => "ramp time (s)",
            Self::BatchLength => "samples in a frame",
            Self::Every => "ticks from sample to sample",
            Self::FlightIndex => "index of a flight-recorder sample",
            Self::StartForce => "start force (N)",
            Self::RiseTime => "rise time (s)",
            Self::WorkspaceLow => "low end of the workspace (m)",
            Self::WorkspaceHigh => "high end of the workspace (m)",
            Self::WorkspaceSoft => "soft zone of the workspace (m)",
            Self::SpeedSoft => "soft speed limit (m/s)",
            Self::SpeedHard => "speed limit (m/s)",
            Self::VelocityBandwidth => "bandwidth of the velocity (Hz)",
            Self::Braking => "braking (N·s/m)",
            Self::StopTime => "stop time (s)",
            Self::BrakeForce => "brake force (N)",
            Self::DeviceMass => "mass of the device (kg)",
            Self::StuckForce => "stuck force (N)",
            Self::StuckTime => "stuck time (s)",
            Self::Jump => "jump (m)",
            Self::GuardDamping => "damping of the guard (N·s/m)",
            Self::GuardShare => "share of the damping that the guard uses",
            Self::GuardForget => "time in which the guard forgets (s)",
            Self::GuardDelayLeast => "least delay of the guard (ticks)",
            Self::GuardDelayMost => "most delay of the guard (ticks)",
            Self::GuardLag => "lag of the actuator for the guard (s)",
            Self::GuardNoise => "noise of the position for the guard (m)",
            Self::MaxAge => "age of a force (ticks)",
            Self::Other => "a parameter of a newer version",
        })
    }
}

impl Limits {
    /// 10 N, 1000 N/s, 500 ms of silence, 20 late ticks, a start with at most 1 N that rises in 0.5 s, 1.5 m/s,
    /// a jump of 1 mm, 3 N in 0.1 s on a sensor that stands still. Workspace, braking and guard are off: they
    /// need to know the device.
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

    /// Shortest watchdog time, ms.
    pub const WATCHDOG_MIN_MS: u16 = 5;
    /// Longest, ms.
    pub const WATCHDOG_MAX_MS: u16 = 1000;
    /// Largest [`max_age_ticks`](Self::max_age_ticks).
    pub const MAX_AGE_TICKS: u16 = 1000;
}

impl Guard {
    /// None; the parameters are those with which energy bounding would begin, but for the damping.
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

impl Simulation {
    /// A real device.
    pub const REAL: Self = Self {
        kind: SimulationKind::Real,
        mass_kg: 0.0,
        damping_n_s_per_m: 0.0,
        hand_stiffness_n_per_m: 0.0,
        push_n: 0.0,
        depth_m: 0.0,
        ramp_time_s: 0.0,
    };

    /// The dissertation's testbed without a hand: 65 g, 3.5 N·s/m.
    pub const TESTBED: Self = Self {
        kind: SimulationKind::MassDamper,
        mass_kg: 0.065,
        damping_n_s_per_m: 3.5,
        ..Self::REAL
    };
}

impl Configuration {
    /// No environment: zero force at 1 kHz, nothing simulated. What a device starts with.
    pub const PASSIVE: Self = Self {
        loop_mode: LoopMode::Device,
        tick_period_us: 1000,
        stiffness_n_per_m: 0.0,
        dissipation_n_s_mu_per_m: 0.0,
        order: 0.0,
        one_sided: false,
        surface_m: 0.0,
        operator: OperatorShape {
            form: OperatorForm::Taps,
            integer: 0,
            count: 1,
        },
        limits: Limits::DEFAULT,
        simulation: Simulation::REAL,
    };
}

/// Digest of a configuration and its coefficients: CRC-32 (as zlib's) over the bytes of the
/// [`Configuration`] as they are on the wire, then each coefficient as four little-endian bytes.
#[derive(Clone)]
pub struct DigestBuilder(crc::Digest<'static, u32, crc::NoTable>);

impl core::fmt::Debug for DigestBuilder {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("DigestBuilder").finish_non_exhaustive()
    }
}

impl DigestBuilder {
    /// Over the configuration; the coefficients follow.
    #[must_use]
    pub fn new(configuration: &Configuration) -> Self {
        let mut digest = CRC.digest();
        // Longer than any configuration can be on the wire.
        let mut bytes = [0; 192];
        // A message of fixed size into a buffer that is longer cannot fail.
        let written = postcard::to_slice(configuration, &mut bytes).map_or(0, |bytes| bytes.len());
        digest.update(&bytes[..written]);
        Self(digest)
    }

    /// Adds coefficients.
    #[must_use]
    pub fn coefficients(mut self, values: &[f32]) -> Self {
        for value in values {
            self.0.update(&value.to_le_bytes());
        }
        self
    }

    /// The digest.
    #[must_use]
    pub fn finish(self) -> u32 {
        self.0.finalize()
    }
}

impl CoefficientBlock {
    /// The block at this offset of a list; what lies behind its end is zero.
    #[must_use]
    pub fn of(values: &[f32], offset: u16) -> Self {
        let rest = values.get(usize::from(offset)..).unwrap_or_default();
        let mut block = [0.0; COEFFICIENTS_PER_BLOCK];
        for (slot, value) in block.iter_mut().zip(rest) {
            *slot = *value;
        }
        Self {
            offset,
            values: block,
        }
    }
}
