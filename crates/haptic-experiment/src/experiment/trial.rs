//! A device that hits a wall and is pushed into it, as an experiment: its plan and the try-out in virtual time are in [`haptic_judge::trial`].

mod position_law;
mod report;
mod second;
mod setup;

use super::kind::Conduct;
use fracdiff::Real;
use haptic_document::Failure;
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::{SafetyChain, SafetyLimits};
use haptic_run::remote::{RemoteLaw, held};
use haptic_trial::Sensors;
use haptic_trial::safety::{GuardedDevice, Safety};
pub(crate) use position_law::PositionLaw;
pub(crate) use report::{OfSample, OffN, Seen, Trial, incomparable, limited, louder, six_digits};
pub(crate) use second::{Pushed, PushedLoop, SecondDevice};
pub(crate) use setup::{Parts, TrialSetup, setup};

/// The chain of the loop that runs here: these limits and what else is asked for, guard and braking made for the device. Beside a device at a
/// port it does force and rate alone, and with the device's own loop it runs only to be checked.
pub(crate) fn safe_chain<F: Real>(
    limits: SafetyLimits,
    device: &MassDamperConfig,
    sensors: Sensors,
    safety: &Safety,
    conduct: &Conduct,
) -> Result<SafetyChain<F>, Failure> {
    let t = device.sample_time;
    let limits = match &conduct.remote {
        None => {
            let known = safety.guarded(GuardedDevice::simulated(device, sensors));
            SafetyLimits {
                guard: safety.guard.of(&known, t)?,
                ..safety.braked(safety.on(limits, false), device.mass.0, delay_ticks(device))
            }
        }
        Some(remote) => remote.limits_here(limits_there(limits, device, safety)),
    };
    conduct.chain(&limits, t, safety)
}

/// The limits of a chain of a serial device, without its guard.
fn limits_there(limits: SafetyLimits, device: &MassDamperConfig, safety: &Safety) -> SafetyLimits {
    let limits = safety.on(limits, true);
    let delay = limits.device_delay_samples.max(delay_ticks(device));
    safety.braked(limits, device.mass.0, delay)
}

/// Settings for a device at a port without a law: limits, and the plant of an emulated one with a push, N. `rate` is the requested force
/// rate limit.
pub(crate) fn no_law_there(
    limits: SafetyLimits,
    rate: Option<f64>,
    safety: &Safety,
    device: &MassDamperConfig,
    push_n: f64,
) -> RemoteLaw {
    RemoteLaw::none(
        limits_there(limits, device, safety),
        rate,
        safety,
        GuardedDevice::given(device),
        held(device, push_n),
    )
}

/// Ticks from a measurement to the effect of its force, for braking: the lag of the actuator counts as delay.
fn delay_ticks(device: &MassDamperConfig) -> u32 {
    let ticks = (device.delay.0 + device.current_lag.0) / device.sample_time.0;
    // A ratio just above a whole number is that number.
    (ticks - 1e-9).ceil().max(0.0) as u32
}
