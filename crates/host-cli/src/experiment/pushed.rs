//! A device that is pushed into a wall: what a single try and the search for a Z-width share.

use crate::failure::Failure;
use fracdiff::{Operator, Seconds};
use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_loop::units::{Metres, Newtons, NewtonsPerSecond};
use haptic_loop::{ParameterError, SafetyChain, Wall};
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
    SafetyChain::new(Newtons(limit_n), force_rate(limit_n, t), t).map_err(Failure::input)
}

/// A rate that limits nothing.
pub(super) fn force_rate(limit_n: f64, t: Seconds) -> NewtonsPerSecond {
    NewtonsPerSecond(2.0 * limit_n / t.0)
}
