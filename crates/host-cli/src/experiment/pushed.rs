//! A device that is pushed into a wall: what a single try and the search for a Z-width share.

use crate::failure::Failure;
use fracdiff::{Operator, Seconds};
use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_loop::units::{Metres, Newtons, NewtonsPerSecond};
use haptic_loop::{
    EnergyBounding, Guard, Limits, ParameterError, PassivityObserver, SafetyChain, Wall,
};
use nalgebra::SVector;
use serde::Serialize;

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

/// What keeps a wall from feeding the device energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum GuardChoice {
    /// Nothing.
    #[default]
    Off,
    /// Time-domain passivity observer, with the damping that the device bears.
    Observer,
    /// Energy bounding by the damping of the device, its delay rounded up.
    EnergyBounding,
}

impl GuardChoice {
    /// The guard for a device, if there is to be one.
    fn of(self, device: &MassDamperConfig) -> Option<Guard> {
        match self {
            Self::Off => None,
            Self::Observer => Some(Guard::Observer(PassivityObserver::bearable(
                device.mass,
                device.sample_time,
            ))),
            Self::EnergyBounding => {
                // A ratio just above a whole number is that number.
                let samples = (device.delay.0 / device.sample_time.0 - 1e-9).ceil();
                Some(Guard::EnergyBounding(EnergyBounding {
                    delay_samples: samples.max(0.0) as usize,
                    ..EnergyBounding::of(device.damping)
                }))
            }
        }
    }
}

/// A safety chain that limits the force alone. The rate is not what is tried here: the limit may be
/// crossed within one sample.
///
/// # Errors
/// A limit or sample time outside its range.
pub(super) fn force_limit(limit_n: f64, t: Seconds) -> Result<SafetyChain<f64>, Failure> {
    guarded(limit_n, t, None)
}

/// The same with a guard that is made for the device.
///
/// # Errors
/// A limit, sample time, or damping or delay of the device outside its range.
pub(super) fn guarded_force_limit(
    limit_n: f64,
    device: &MassDamperConfig,
    guard: GuardChoice,
) -> Result<SafetyChain<f64>, Failure> {
    guarded(limit_n, device.sample_time, guard.of(device))
}

fn guarded(limit_n: f64, t: Seconds, guard: Option<Guard>) -> Result<SafetyChain<f64>, Failure> {
    let limits = Limits {
        guard,
        ..Limits::bare(Newtons(limit_n), force_rate(limit_n, t))
    };
    SafetyChain::from_limits(&limits, t).map_err(Failure::input)
}

/// A rate that limits nothing.
pub(super) fn force_rate(limit_n: f64, t: Seconds) -> NewtonsPerSecond {
    NewtonsPerSecond(2.0 * limit_n / t.0)
}
