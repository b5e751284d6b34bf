//! Everything that can be set on a device, and the digest by which both ends know it.

#[cfg(feature = "controllers")]
use crate::controller::ControllerLaw;
#[cfg(feature = "controllers")]
use crate::sample::AXES_MAX;
#[cfg(feature = "several-axes")]
use crate::surface::SurfaceShape;
use crate::{
    frame::{CRC, Table, written},
    in_order::{Blank, blank, in_order},
    limits::{Field, Limits, LoopMode},
};
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// The whole configuration except the coefficients. Applied in one transaction: stage this, stage
/// the blocks of coefficients, commit with the digest of both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Configuration {
    /// The side on which the loop runs.
    pub loop_mode: LoopMode,
    /// T, the time from one tick to the next, µs.
    #[serde(with = "postcard::fixint::le")]
    pub tick_period_us: u32,
    /// K, the stiffness that the device renders, N/m.
    pub stiffness_n_per_m: f32,
    /// B, the factor of the fractional damper, N·s^μ/m.
    pub dissipation_n_s_mu_per_m: f32,
    /// μ, recorded only: the device uses the coefficients.
    pub order: f32,
    /// The environment begins at `surface_m` and pushes but never pulls.
    pub one_sided: bool,
    /// Place at which a one-sided environment begins, m.
    pub surface_m: f32,
    /// Form and number of the operator's coefficients, which follow in blocks.
    pub operator: OperatorShape,
    /// Limits of the safety chain, which hold for every run of the device.
    pub limits: Limits,
    /// The plant of a simulated device.
    pub simulation: Simulation,
    /// Push of the device's own motor, added to the force of a device loop before its limits, N; 0 for none. With one the
    /// environment begins where the handle stands at the start.
    pub own_push_n: f32,
    /// Force that a device loop adds in every second `tap_ticks` ticks of a run, N; 0 for none.
    pub tap_n: f32,
    /// Ticks from one step of that force to the next, at least 1; 0 without it.
    #[serde(with = "postcard::fixint::le")]
    pub tap_ticks: u32,
    /// Map from the depth behind the surface of a one-sided environment to the depth that the
    /// environment receives: 1/s in 1/m, c₀ to c₅, and q in 1/m.
    pub depth_map: Option<[f32; 8]>,
}

impl Configuration {
    /// No environment: zero force at 1 kHz, nothing simulated. A device starts with it.
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
        own_push_n: 0.0,
        tap_n: 0.0,
        tap_ticks: 0,
        depth_map: None,
    };

    /// [`Limits::tightened`] of a run whose tick may differ in length from that of the lasting
    /// configuration: delays are times, so the same delay is a different number of ticks.
    #[must_use]
    pub fn tightened(&self, set: &Self) -> (Limits, Option<Field>) {
        let mut limits = set.limits;
        if self.tick_period_us != set.tick_period_us {
            // Ticks of this run in a tick of what was set.
            let ticks = set.tick_period_us as f32 / self.tick_period_us.max(1) as f32;
            limits.guard.delay_least_samples *= ticks;
            limits.guard.delay_most_samples *= ticks;
            let delay = f32::from(limits.device_delay_ticks) * ticks;
            // Rounded up; a cast stays within a byte.
            let whole = delay as u8;
            let more = u8::from(f32::from(whole) < delay);
            limits.device_delay_ticks = whole.saturating_add(more);
        }
        self.limits.tightened(&limits)
    }
}

/// Coefficients in a [`CoefficientBlock`].
pub const COEFFICIENTS_PER_BLOCK: usize = 16;

/// Blocks that hold this many coefficients.
#[must_use]
pub const fn block_count(coefficients: u16) -> u16 {
    coefficients.div_ceil(COEFFICIENTS_PER_BLOCK as u16)
}

/// The meaning of a list of coefficients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum OperatorForm {
    /// g, k₁, …: weights of the newest sample and of those before.
    #[default]
    Taps,
    /// g, k₁, …, k₁₅, then a pair (d, W) for each decaying mode.
    Modes,
    /// g, then a pair (b, a) for each degree of a recursion.
    Recursion,
}

/// The key to the coefficients of an operator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct OperatorShape {
    /// The form, which gives each coefficient its meaning.
    pub form: OperatorForm,
    /// Differences (> 0) or sums (< 0) applied around the coefficients, −2 to 2.
    pub integer: i8,
    /// Number of coefficients, at least 1.
    #[serde(with = "postcard::fixint::le")]
    pub count: u16,
}

/// Sixteen coefficients of the operator; the last block is filled up with zeros.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct CoefficientBlock {
    /// Index of the first coefficient in the list, a multiple of 16.
    #[serde(with = "postcard::fixint::le")]
    pub offset: u16,
    /// Values in the order of [`OperatorForm`](crate::OperatorForm).
    #[serde(deserialize_with = "crate::in_order::array")]
    pub values: [f32; COEFFICIENTS_PER_BLOCK],
}

impl CoefficientBlock {
    /// The block at this offset of a list, padded with zeros past the end of the list.
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

in_order! {
    /// The plant of a simulated device.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Schema)]
    pub struct Simulation {
        /// The kind of plant that replaces a real device.
        pub kind: SimulationKind,
        /// Mass of the device, kg.
        pub mass_kg: f32,
        /// Viscous damping of the device, N·s/m.
        pub damping_n_s_per_m: f32,
        /// Stiffness of the hand, N/m.
        pub hand_stiffness_n_per_m: f32,
        /// Constant push of the hand, N.
        pub push_n: f32,
        /// Depth at which the indentation is held, m.
        pub depth_m: f32,
        /// Time to reach that depth, s.
        pub ramp_time_s: f32,
        /// Ticks from the start of a run in which the plant stands still; with one axis only.
        pub start_ticks: f32,
    }
}

blank!(SimulationKind: Self::Real);

impl Simulation {
    /// Nothing is simulated: sensor and actuator are real.
    pub const REAL: Self = Self {
        kind: SimulationKind::Real,
        mass_kg: 0.0,
        damping_n_s_per_m: 0.0,
        hand_stiffness_n_per_m: 0.0,
        push_n: 0.0,
        depth_m: 0.0,
        ramp_time_s: 0.0,
        start_ticks: 0.0,
    };

    /// The dissertation's testbed without a hand: 65 g, 3.5 N·s/m.
    pub const TESTBED: Self = Self {
        kind: SimulationKind::MassDamper,
        mass_kg: 0.065,
        damping_n_s_per_m: 3.5,
        ..Self::REAL
    };
}

/// The plant of a simulated device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum SimulationKind {
    /// Nothing is simulated: sensor and actuator are real.
    #[default]
    Real,
    /// A mass-damper with a hand that pushes.
    MassDamper,
    /// An indentation by ramp and hold, imposed exactly.
    RigidIndentation,
    /// That indentation by an indenter of its own mass and servo, through a stiff contact.
    CompliantIndentation,
}

/// The range in which a device may move on an axis.
#[cfg(feature = "controllers")]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct AxisWorkspace {
    /// Lowest position, m, −100 to 100.
    pub low_m: f32,
    /// Highest position, m, above the lowest, at most 100. Beyond either a fault latches.
    pub high_m: f32,
    /// Width of the zones at both ends in which an outward motion is braked, m, 0 or 1e-6 to half the range.
    pub soft_m: f32,
}

/// A separate workspace for each axis of a device with several, for one run. Where
/// [`Limits`](crate::Limits) has a workspace for all axes, this one must lie within it.
#[cfg(feature = "controllers")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct WorkspaceBox {
    /// A range for each axis of the device, in their order.
    pub axes: heapless::Vec<AxisWorkspace, AXES_MAX>,
}

/// Digest of what two hands must share: CRC-32 (as zlib's) over numbers of eight little-endian bytes each, then a text.
#[must_use]
pub fn hand_digest(numbers: &[f64], text: &str) -> u32 {
    let mut digest = CRC.digest();
    for number in numbers {
        digest.update(&number.to_le_bytes());
    }
    digest.update(text.as_bytes());
    digest.finalize()
}

/// Digest of a configuration and its coefficients: CRC-32 (as zlib's) over the bytes of the
/// [`Configuration`] as they are on the wire, then each coefficient as four little-endian bytes.
#[derive(Clone)]
pub struct DigestBuilder(crc::Digest<'static, u32, Table>);

impl core::fmt::Debug for DigestBuilder {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("DigestBuilder").finish_non_exhaustive()
    }
}

impl DigestBuilder {
    /// Starts with the configuration; add the coefficients next.
    #[must_use]
    pub fn new(configuration: &Configuration) -> Self {
        // As long as the longest configuration on the wire.
        Self(CRC.digest()).message::<_, 204>(configuration)
    }

    /// Adds a message as it is on the wire, of N bytes at most.
    fn message<M: Serialize, const N: usize>(mut self, message: &M) -> Self {
        let mut bytes = [0; N];
        // A message into a buffer that is as long as it cannot fail.
        self.0
            .update(written(message, &mut bytes).unwrap_or_default());
        self
    }

    /// Adds coefficients, each as four little-endian bytes.
    #[must_use]
    pub fn coefficients(mut self, values: &[f32]) -> Self {
        for value in values {
            self.0.update(&value.to_le_bytes());
        }
        self
    }

    /// Adds the workspace of each axis after the coefficients, in wire format but without the count
    /// of axes.
    #[cfg(feature = "several-axes")]
    #[must_use]
    pub fn workspace(mut self, workspace: &WorkspaceBox) -> Self {
        for axis in &workspace.axes {
            self = self.coefficients(&[axis.low_m, axis.high_m, axis.soft_m]);
        }
        self
    }

    /// Adds a controller after the coefficients, in wire format.
    #[cfg(feature = "controllers")]
    #[must_use]
    pub fn controller(self, law: &ControllerLaw) -> Self {
        self.message::<_, 33>(law)
    }

    /// Adds a surface after the workspace of each axis, in wire format.
    #[cfg(feature = "several-axes")]
    #[must_use]
    pub fn surface(self, surface: &SurfaceShape) -> Self {
        self.message::<_, 18>(surface)
    }

    /// The digest of all that was added, in this order.
    #[must_use]
    pub fn finish(self) -> u32 {
        self.0.finalize()
    }
}
