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

/// What the device may do.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Limits {
    /// Largest force, N.
    pub force_n: f32,
    /// Largest rate of force, N/s.
    pub force_rate_n_per_s: f32,
    /// Silence from the host that latches a fault while armed or running, ms, 5 to 1000.
    #[serde(with = "postcard::fixint::le")]
    pub watchdog_ms: u16,
    /// Late ticks in a row that latch a fault; 0 for never.
    #[serde(with = "postcard::fixint::le")]
    pub late_ticks: u16,
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
            Self::Other => "a parameter of a newer version",
        })
    }
}

impl Limits {
    /// 10 N, 1000 N/s, 20 ms of silence, 20 late ticks.
    pub const DEFAULT: Self = Self {
        force_n: 10.0,
        force_rate_n_per_s: 1000.0,
        watchdog_ms: 20,
        late_ticks: 20,
    };
    /// Shortest watchdog time, ms.
    pub const WATCHDOG_MIN_MS: u16 = 5;
    /// Longest, ms.
    pub const WATCHDOG_MAX_MS: u16 = 1000;
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
pub struct DigestBuilder(crc::Digest<'static, u32, crc::Table<1>>);

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
        let mut bytes = [0; 160];
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
