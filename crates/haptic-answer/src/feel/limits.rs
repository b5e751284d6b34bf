//! Limits of a loop that is felt on a simulated device.

use super::settings::FeelSettings;
use haptic_loop::units::{Kilograms, Metres, NewtonSecondsPerMetre, Seconds};
use haptic_loop::{SafetyLimits, Workspace};

/// Ends of the workspace, m, and where braking begins before them.
const WORKSPACE_M: (f64, f64, f64) = (-0.06, 0.06, 0.01);
/// Limits of the safety chain: the usual ones of a desktop device, with its workspace, mass and samples of delay, but no start-up ramp. The
/// device begins in front of the surface, where no force acts, so none can jump; and a wall that grows stiffer while it is pressed would
/// give the hand more than the hand put in.
#[must_use]
pub fn limits(mass: Kilograms, delay: u32, t: Seconds) -> SafetyLimits {
    let (low, high, soft) = WORKSPACE_M;
    let limits = SafetyLimits {
        workspace: Some(Workspace {
            low: Metres(low),
            high: Metres(high),
            soft: Metres(soft),
        }),
        device_mass: Some(mass),
        rise_time: None,
        device_delay_samples: delay,
        ..SafetyLimits::default()
    };
    // A light device bears less braking.
    let most = limits.braking_max(t).0;
    let usual = limits.braking.map(|usual| usual.0.min(most));
    SafetyLimits {
        braking: usual.map(NewtonSecondsPerMetre),
        ..limits
    }
}

impl FeelSettings {
    /// Limits of the safety chain; a lag of the actuator counts as delay.
    #[must_use]
    pub fn limits(&self) -> SafetyLimits {
        let (late_s, t) = (
            self.device.values.delay_s + self.device.values.current_lag_s,
            self.device.sample_time(),
        );
        let samples = (late_s / t.0 - 1e-9).ceil().max(1.0);
        limits(Kilograms(self.device.values.mass_kg), samples as u32, t)
    }
}
