//! The limits of a safety chain, in SI units.

use crate::guard::Guard;
use crate::units::{
    Hertz, Metres, MetresPerSecond, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond, Seconds,
};

/// Every limit of a [`SafetyChain`](crate::SafetyChain); `None` is off.
///
/// The defaults suit a desktop device of some 65 g, to be replaced by those of the device at hand: its
/// workspace is not known here, nor is a guard, which needs its mass or damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest force on each axis, above 0. *Default* 10 N: what a desktop device makes and a finger holds.
    pub force: Newtons,
    /// Largest magnitude of the whole force, above 0 and at most 1e9 N: else a diagonal gets √D times the limit
    /// of an axis. With it `force` too is at most 1e9 N. *Default* 10 N.
    pub norm: Option<Newtons>,
    /// Largest rate of force on each axis, above 0. *Default* 1000 N/s: a wall of 2 kN/m met at 0.5 m/s.
    pub rate: NewtonsPerSecond,
    /// Largest magnitude of a wanted force with which [`may_start`](crate::Controller::may_start) lets a
    /// device be armed, above 0. *Default* 1 N: felt, but moves no hand.
    pub start_force: Option<Newtons>,
    /// From start or [`clear`](crate::SafetyState::clear) the share of the wanted force that is used rises from
    /// 0 to 1 in this time, above 0. *Default* 0.5 s: whoever lets go within 0.2 s has met less than half.
    pub rise_time: Option<Seconds>,
    /// Where the device may be. *Default* off.
    pub workspace: Option<Workspace>,
    /// How fast it may move. *Default* 1 and 1.5 m/s: an exploring hand stays below 0.5 m/s.
    pub speed: Option<SpeedLimit>,
    /// ω/2π above 0, bandwidth of the velocity that is estimated from positions,
    /// v ← v + (1 − e^(−ωT))·(Δ/T − v). *Default* 50 Hz: at 1 kHz an encoder step of 10 µm is 3 mm/s, and a motion
    /// is seen 3 ms late.
    pub velocity_bandwidth: Hertz,
    /// Viscous damping that brakes near a limit and after a fault, above 0. *Default* 5 N·s/m: with the lag of the
    /// estimate 1/ω = 3.2 ms and 65 g it is critical, ζ = √(m·ω/b)/2 = 1. Off, a limit only latches its fault.
    pub braking: Option<NewtonSecondsPerMetre>,
    /// After a fault or stop the braking fades out in this time, above 0. *Default* 0.2 s, 15 times m/b.
    pub braking_time: Seconds,
    /// Keeps the loop from feeding the device energy. *Default* off.
    pub guard: Option<Guard>,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            norm: Some(Newtons(10.0)),
            start_force: Some(Newtons(1.0)),
            rise_time: Some(Seconds(0.5)),
            speed: Some(SpeedLimit {
                soft: MetresPerSecond(1.0),
                hard: MetresPerSecond(1.5),
            }),
            braking: Some(NewtonSecondsPerMetre(5.0)),
            ..Self::bare(Newtons(10.0), NewtonsPerSecond(1000.0))
        }
    }
}

impl Limits {
    /// Force and rate alone, everything else off.
    #[must_use]
    pub const fn bare(force: Newtons, rate: NewtonsPerSecond) -> Self {
        Self {
            force,
            norm: None,
            rate,
            start_force: None,
            rise_time: None,
            workspace: None,
            speed: None,
            velocity_bandwidth: Hertz(50.0),
            braking: None,
            braking_time: Seconds(0.2),
            guard: None,
        }
    }
}

/// Where the device may be, the same interval on each axis.
///
/// ```text
/// low ─soft─▶ ················· ◀─soft─ high       beyond low or high: Fault::Workspace
/// f = −p·b·v while v points outwards,  p = 0 at the inner edge of the soft zone, 1 at its outer
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Workspace {
    /// Lowest position.
    pub low: Metres,
    /// Highest position, above `low`.
    pub high: Metres,
    /// Width of the zones in which an outward motion is braked, 0 or more, at most half the workspace.
    pub soft: Metres,
}

/// How fast the device may move on each axis.
///
/// ```text
/// f = −p·b·v,  p = 0 at the soft speed, 1 at the hard one       above the hard one: Fault::Velocity
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedLimit {
    /// From here on the motion is braked, at least 0.
    pub soft: MetresPerSecond,
    /// Latches the fault, above `soft`.
    pub hard: MetresPerSecond,
}

/// A device that must not be armed now: the force would begin with a blow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartRefused {
    /// Magnitude of the wanted force, N; NaN or infinite if it is not finite.
    pub wanted_n: f64,
    /// Largest with which a start is allowed, N; infinite if any finite force is.
    pub allowed_n: f64,
}

impl core::fmt::Display for StartRefused {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self {
            wanted_n,
            allowed_n,
        } = self;
        write!(
            f,
            "the wanted force of {wanted_n} N is not within the {allowed_n} N allowed at the start"
        )
    }
}

impl core::error::Error for StartRefused {}
