//! Limits of a device, and its passivity guard.

use crate::in_order::{Blank, Fixed, blank, read_in_order};
use crate::loop_mode::LoopMode;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Limits of force and motion. All numbers are finite; with one axis `force_n` limits the norm of the force too.
///
/// ```
/// use haptic_link::Limits;
///
/// // A run that asks for more force than was set to last keeps what was set.
/// let set = Limits { force_n: 4.0, ..Limits::DEFAULT };
/// let (force_n, looser) = {
///     let (tight, looser) = Limits::DEFAULT.tightened(&set);
///     (tight.force_n, looser)
/// };
/// assert_eq!(force_n, 4.0);
/// assert!(looser.is_some());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Schema)]
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

read_in_order!(Limits {
    force_n,
    force_rate_n_per_s,
    watchdog_ms as Fixed,
    late_ticks as Fixed,
    max_age_ticks as Fixed,
    start_force_n,
    rise_time_s,
    workspace_low_m,
    workspace_high_m,
    workspace_soft_m,
    speed_soft_m_per_s,
    speed_hard_m_per_s,
    velocity_bandwidth_hz,
    braking_n_s_per_m,
    stop_time_s,
    brake_force_n,
    device_mass_kg,
    device_delay_ticks,
    stuck_force_n,
    stuck_time_s,
    jump_m,
    guard,
});

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

/// The passivity guard: keeps the loop from feeding the device energy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Schema)]
pub struct Guard {
    /// The kind of guard. The other fields are not looked at when it is off.
    pub kind: GuardKind,
    /// N·s/m, 1e-6 to 1e6. Observer: the most damping that it adds. Energy bounding: viscous damping that the
    /// device surely has.
    pub damping_n_s_per_m: f32,
    /// Energy bounding: share of that damping that the loop may use up, 0.001 to 1.
    pub share: f32,
    /// Time that a credit of energy lasts, s, from a tick to 3600. Energy bounding: 0 gives it up at once.
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

read_in_order!(Guard {
    kind,
    damping_n_s_per_m,
    share,
    forget_s,
    delay_least_samples,
    delay_most_samples,
    lag_s,
    noise_m,
});

blank!(Guard: Self::OFF, GuardKind: Self::Off);

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
