//! The safety chain of a loop: of the simulated device, or of what runs here beside a device at a port.

use crate::{
    Sensors,
    advice::parameter,
    safety::{GuardedDevice, Safety},
};
use fracdiff::{Real, Seconds};
use haptic_document::Failure;
use haptic_link::LoopMode;
use haptic_loop::{SafetyChain, SafetyLimits, plant::MassDamperConfig};

/// The chain of the loop that runs here: these limits and what else is asked for, guard and braking made for the device. Beside a device at a
/// port it does force and rate alone, and with the device's own loop it runs only to be checked.
///
/// # Errors
/// A limit outside its range, or one that acts on nothing there.
pub fn safe_chain<F: Real>(
    limits: SafetyLimits,
    device: &MassDamperConfig,
    sensors: Sensors,
    safety: &Safety,
    at_port: Option<LoopMode>,
) -> Result<SafetyChain<F>, Failure> {
    let t = device.sample_time;
    let limits = match at_port {
        None => {
            let known = safety.guarded(GuardedDevice::simulated(device, sensors));
            SafetyLimits {
                guard: safety.guard.of(&known, t)?,
                ..safety.braked(safety.on(limits, false), device.mass.0, delay_ticks(device))
            }
        }
        Some(loop_mode) => limits_here(loop_mode, limits_there(limits, device, safety)),
    };
    chain(&limits, t, safety, at_port)
}

/// The limits of a chain of a serial device, without its guard.
#[must_use]
pub fn limits_there(
    limits: SafetyLimits,
    device: &MassDamperConfig,
    safety: &Safety,
) -> SafetyLimits {
    let limits = safety.on(limits, true);
    let delay = limits.device_delay_samples.max(delay_ticks(device));
    safety.braked(limits, device.mass.0, delay)
}

/// A chain of these limits, if all that was asked for acts on the simulated device, or on one at a port.
///
/// # Errors
/// A limit outside its range, or one that acts on nothing there.
pub fn chain<F: Real>(
    limits: &SafetyLimits,
    t: Seconds,
    safety: &Safety,
    at_port: Option<LoopMode>,
) -> Result<SafetyChain<F>, Failure> {
    let chain = SafetyChain::from_limits(limits, t).map_err(parameter)?;
    match at_port {
        None => safety.acts()?,
        Some(_) => safety.acts_on_device()?,
    }
    Ok(chain)
}

/// Limits of the chain in this program beside a device: with the device's own loop it only checks them. A loop here keeps force, norm, rate, start
/// and stop; the rest is up to the device, which knows where it is without delay.
#[must_use]
pub const fn limits_here(loop_mode: LoopMode, limits: SafetyLimits) -> SafetyLimits {
    match loop_mode {
        LoopMode::Device => limits,
        LoopMode::Host => SafetyLimits {
            norm: limits.norm,
            start_force: limits.start_force,
            stop_time: limits.stop_time,
            brake_force: limits.brake_force,
            ..SafetyLimits::bare(limits.force, limits.rate)
        },
    }
}

/// Ticks from a measurement to the effect of its force, for braking: the lag of the actuator counts as delay.
fn delay_ticks(device: &MassDamperConfig) -> u32 {
    let ticks = (device.delay.0 + device.current_lag.0) / device.sample_time.0;
    // A ratio just above a whole number is that number.
    (ticks - 1e-9).ceil().max(0.0) as u32
}
