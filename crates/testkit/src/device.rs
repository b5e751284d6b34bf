//! Short ways to simulated devices and to forces for them.

use core::fmt::Debug;
use fracdiff::{Real, Seconds};
use haptic_analysis::Dynamics;
use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_loop::units::{
    Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre, NewtonsPerSecond,
};
use haptic_loop::{
    Controller, Device, Engaged, Environment, Reading, SafeForce, SafetyChain, SafetyState,
};
use nalgebra::{SVector, Vector1};

/// Mass of the dissertation's voice coil (section 4.4), kg.
pub const MASS: f64 = 0.065;
/// Damping of that voice coil, N·s/m.
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

/// Device like [`ideal`], held by a hand of this stiffness, N/m.
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

/// The device of the dissertation's section 4.4, which is sampled at 2 ms there: 65 g, 3.5 N·s/m, ideal.
#[must_use]
pub const fn dissertation(sample_time: Seconds) -> MassDamperConfig {
    ideal(MASS, DAMPING, sample_time.0)
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

/// The simulated device of these dynamics.
///
/// # Panics
/// Parameters outside their ranges.
#[must_use]
pub fn of_dynamics(device: &Dynamics, sample_time: Seconds) -> MassDamper<1> {
    plant(MassDamperConfig {
        stiffness: NewtonsPerMetre(device.hand_stiffness_n_per_m),
        delay: Seconds(device.delay_s),
        current_lag: Seconds(device.current_lag_s),
        ..ideal(device.mass_kg, device.damping_n_s_per_m, sample_time.0)
    })
}

/// True if a push of the device in a loop with this law dies out, as `dies_out` sees it.
///
/// # Panics
/// Parameters outside their ranges.
pub fn settles<E: Environment<f64, 1>>(
    law: E,
    device: &Dynamics,
    sample_time: Seconds,
    theta: f64,
) -> bool {
    let chain = SafetyChain::new(Newtons(1e6), NewtonsPerSecond(1e12), sample_time);
    let mut controller = Controller::new(law, chain.expect("in range"));
    let mut plant = of_dynamics(device, sample_time);
    plant.set_state(Vector1::new(0.0), Vector1::new(1e-6));
    dies_out(controller.engage(plant), theta)
}

/// Samples after which a simulation is judged by its last windows.
const LONGEST: usize = 1_500_000;

/// True if the motion of a device in a loop dies out: its velocity falls to a millionth before it grows twentyfold from its
/// least. Judged by windows of many periods of the slowest motion that could decide, which has the angle θ, rad/sample. A force
/// at a limit of the chain is growth.
fn dies_out<E: Environment<f64, 1>>(
    mut engaged: Engaged<f64, 1, E, MassDamper<1>, &mut Controller<f64, 1, E>>,
    theta: f64,
) -> bool {
    let period = core::f64::consts::TAU / theta.max(1e-3);
    let window = (12.0 * period).ceil().max(256.0) as usize;
    let mut levels: Vec<f64> = Vec::new();
    for _ in 0..(LONGEST / window).max(24) {
        let mut sum = 0.0;
        for _ in 0..window {
            match engaged.tick() {
                Ok(sample) if sample.limiters.bits() != 0 => return false,
                Ok(_) => {}
                Err(never) => match never {},
            }
            sum += {
                let velocity = engaged.device().velocity()[0];
                velocity * velocity
            };
        }
        let level = 0.5 * libm::log(sum / window as f64);
        levels.push(level);
        let highest = levels.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let lowest = levels.iter().copied().fold(f64::INFINITY, f64::min);
        if level > lowest + 3.0 {
            return false;
        }
        if level < highest - 14.0 {
            return true;
        }
    }
    let last = levels.len() - 1;
    levels[last] < levels[last / 2]
}
