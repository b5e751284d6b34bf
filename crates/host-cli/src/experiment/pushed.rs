//! A device that is pushed into a wall: what a single try and the search for a Z-width share.

use super::safety::{GuardedDevice, Safety};
use crate::failure::Failure;
use fracdiff::{Operator, Seconds};
use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_loop::units::{Metres, Newtons, NewtonsPerSecond};
use haptic_loop::{Limits, ParameterError, SafetyChain, Wall};
use nalgebra::SVector;

/// A device this far away has left, m: it will not come to rest.
pub(super) const GONE_M: f64 = 1.0;

/// A wall at the device's start position.
pub(super) type VirtualWall = Wall<f64, Operator<f64>>;

/// K in N/m and B in N·s^μ/m; one-sided it pushes but never pulls.
///
/// # Errors
/// As [`Wall::new`].
pub(super) fn wall_at_start(
    stiffness: f64,
    dissipation: f64,
    operator: Operator<f64>,
    one_sided: bool,
) -> Result<VirtualWall, ParameterError> {
    Wall::new(
        stiffness,
        dissipation,
        operator,
        one_sided.then_some(Metres(0.0)),
    )
}

/// The device with a constant push on it, N.
///
/// # Errors
/// A parameter of the device outside its range.
pub(super) fn pushed(config: MassDamperConfig, push_n: f64) -> Result<MassDamper<1>, Failure> {
    let mut device = MassDamper::new(config).map_err(Failure::input)?;
    device.set_external_force(SVector::from([push_n]));
    Ok(device)
}

/// A safety chain that limits the force alone. The rate is not what is tried here: the limit may be
/// crossed within one sample.
///
/// # Errors
/// A limit or sample time outside its range.
pub(super) fn force_limit(limit_n: f64, t: Seconds) -> Result<SafetyChain<f64>, Failure> {
    SafetyChain::from_limits(&force_alone(limit_n, t), t).map_err(Failure::input)
}

/// A chain with these limits of force and rate and what else is asked for; guard and braking are made for the device.
///
/// # Errors
/// A limit, sample time, or mass, damping or delay of the device outside its range.
pub(super) fn safe_force_limit(
    limits: Limits,
    device: &MassDamperConfig,
    safety: &Safety,
) -> Result<SafetyChain<f64>, Failure> {
    let t = device.sample_time;
    // A ratio just above a whole number is that number.
    let samples = (device.delay.0 / t.0 - 1e-9).ceil();
    let known = safety.guarded(GuardedDevice {
        mass_kg: Some(device.mass.0),
        damping_n_s_per_m: Some(device.damping.0),
        delay_samples: samples.max(0.0) as usize,
    });
    // A lag of the actuator counts as delay.
    let delay = ((device.delay.0 + device.lag.0) / t.0 - 1e-9)
        .ceil()
        .max(0.0) as u32;
    let limits = Limits {
        guard: safety.guard.of(&known, t)?,
        ..safety.braked(safety.on(limits, false), device.mass.0, delay)
    };
    SafetyChain::from_limits(&limits, t).map_err(Failure::input)
}

/// The limits of [`force_limit`].
pub(super) const fn force_alone(limit_n: f64, t: Seconds) -> Limits {
    Limits::bare(Newtons(limit_n), force_rate(limit_n, t))
}

/// A rate that limits nothing.
pub(super) const fn force_rate(limit_n: f64, t: Seconds) -> NewtonsPerSecond {
    NewtonsPerSecond(2.0 * limit_n / t.0)
}
