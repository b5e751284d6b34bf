//! Short ways to simulated devices and to forces for them.

use core::fmt::Debug;
use fracdiff::{Real, Seconds};
use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_loop::units::{
    Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre, NewtonsPerSecond,
};
use haptic_loop::{Device, Reading, SafeForce, SafetyChain, SafetyState};
use nalgebra::{SVector, Vector1};

/// Mass of the dissertation's voice coil (section 4.4), kg.
pub const MASS: f64 = 0.065;
/// Its damping, N·s/m.
pub const DAMPING: f64 = 3.5;

/// A mass on a damper: kg, N·s/m, s.
#[must_use]
pub const fn ideal(mass: f64, damping: f64, sample_time: f64) -> MassDamperConfig {
    MassDamperConfig::ideal(
        Kilograms(mass),
        NewtonSecondsPerMetre(damping),
        Seconds(sample_time),
    )
}

/// The same held by a hand, N/m.
#[must_use]
pub const fn with_hand(
    mass: f64,
    damping: f64,
    stiffness: f64,
    sample_time: f64,
) -> MassDamperConfig {
    let mut config = ideal(mass, damping, sample_time);
    config.stiffness = NewtonsPerMetre(stiffness);
    config
}

/// A plant of one axis.
///
/// # Panics
/// A parameter out of range.
#[must_use]
pub fn plant(config: MassDamperConfig) -> MassDamper<1> {
    MassDamper::new(config).expect("parameters in range")
}

/// A force through a safety chain too wide to change it.
///
/// # Panics
/// Never.
#[must_use]
pub fn safe<F: Real, const D: usize>(force: SVector<F, D>) -> SafeForce<F, D> {
    let chain = SafetyChain::new(Newtons(1e9), NewtonsPerSecond(1e12), Seconds(1.0));
    let mut state = SafetyState::default();
    chain.expect("valid").apply(&mut state, &force, &force).0
}

/// Writes a force, N.
///
/// # Panics
/// If the device fails.
pub fn write(device: &mut impl Device<f64, 1, Error: Debug>, force: f64) {
    device.write(safe(Vector1::new(force))).expect("written");
}

/// Reads a device.
///
/// # Panics
/// If it fails.
pub fn read<const D: usize>(device: &mut impl Device<f64, D>) -> Reading<f64, D> {
    device.read().expect("read")
}
