//! Settings for a device at a port on which no law runs, or one that is pushed.

use haptic_judge::setup::TrialSetup;
use haptic_loop::{SafetyLimits, plant::MassDamperConfig};
use haptic_run::remote::{RemoteLaw, held};
use haptic_trial::{
    safe_chain::limits_there,
    safety::{GuardedDevice, Safety},
};

/// The push for a serial device, and no law at all: one of a loop on the host.
pub(crate) fn law_of(setup: &TrialSetup) -> RemoteLaw {
    let push_n = setup.plan.push_of_hand_n();
    RemoteLaw {
        held_push_n: setup.plan.push_n,
        push: setup.plan.push_of_motor(),
        ..no_law_there(
            setup.force_and_rate(),
            setup.force_rate_limit_n_per_s,
            &setup.safety(),
            &setup.device,
            push_n,
        )
    }
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
