//! Newtons as a device names them, and true ones.
//!
//! ```text
//! f = g·u        u commanded, N; f made, N; g the motor's factor, between g₋ and g₊
//! F = s·r        r shown by the force sensor, N; F true, N; s the sensor's factor
//! ```
//! - *To the device* go u = f/g, K/g, B/g and the gains of a controller over g. A limit L goes as L/g₊: whatever g is, the true force stays
//!   below L.
//! - *From the device* come f = g·u and F = s·r, and a limit L as min(1, g₊)·L: it holds in its own newtons and in true ones. So what
//!   was set on a device is never looser for a device that was calibrated.
//! - *Rounding* of limits is towards tight, of everything else to the nearest. *Cost*: a product for each force.

use fracdiff::parameter::{RangeError, range};
use haptic_link::{
    BatchItem, Capabilities, Configuration, ControllerForm, ControllerLaw, Limits, Sample,
};
use haptic_loop::Limit;

/// Factors between the newtons of a device and true ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceFactors {
    made: f64,
    made_most: f64,
    sensed: f64,
}

impl ForceFactors {
    /// Smallest and largest factor: more is a wrong unit or a wrong supply, to be mended there.
    pub const ENDS: [f64; 2] = [0.05, 20.0];

    /// True force for each newton commanded, the largest that this may be, and true force for each newton shown.
    ///
    /// # Errors
    /// A factor outside [`ENDS`](Self::ENDS); a largest one below the likeliest.
    pub fn new(made: f64, made_most: f64, sensed: f64) -> Result<Self, RangeError> {
        let [least, most] = Self::ENDS;
        let checked = |what, value: f64, least: f64| {
            let fits = (least..=most).contains(&value);
            range(
                what,
                value,
                fits,
                "between 0.05 and 20, the largest not below the likeliest",
                "",
            )
        };
        Ok(Self {
            made: checked("factor of the motor", made, least)?,
            made_most: checked("largest factor of the motor", made_most, made)?,
            sensed: checked("factor of the force sensor", sensed, least)?,
        })
    }

    /// Newtons of the device for a true force.
    pub(super) const fn commanded(&self, true_n: f64) -> f32 {
        (true_n / self.made) as f32
    }

    /// True force for newtons of the device.
    pub(super) fn made(&self, commanded_n: f32) -> f32 {
        (self.made * f64::from(commanded_n)) as f32
    }

    /// A sample in true newtons.
    pub(super) fn read(&self, mut sample: Sample) -> Sample {
        for BatchItem {
            force_n,
            environment_force_n,
            ..
        } in &mut sample.axes
        {
            (*force_n, *environment_force_n) =
                (self.made(*force_n), self.made(*environment_force_n));
        }
        for shown in &mut sample.sensed_force_n {
            *shown = (self.sensed * f64::from(*shown)) as f32;
        }
        sample
    }

    /// Abilities in true newtons.
    pub(super) fn able(&self, can: Capabilities) -> Capabilities {
        let share = self.made_most.min(1.0);
        Capabilities {
            force_max_n: down(share * f64::from(can.force_max_n)),
            force_rate_max_n_per_s: down(share * f64::from(can.force_rate_max_n_per_s)),
            sensed_force_max_n: (self.sensed * f64::from(can.sensed_force_max_n)) as f32,
            ..can
        }
    }

    /// A configuration of the device in true newtons.
    pub(super) fn seen(&self, configuration: Configuration) -> Configuration {
        scaled(configuration, self.made, self.made_most.min(1.0))
    }

    /// A configuration in true newtons as the device takes it.
    pub(super) fn told(&self, configuration: Configuration) -> Configuration {
        scaled(configuration, 1.0 / self.made, 1.0 / self.made_most)
    }

    /// A controller whose command is a true force, as the device takes it.
    pub(super) fn told_controller(&self, law: &ControllerLaw, values: &mut [f32]) -> ControllerLaw {
        let mut at = 1;
        for part in &law.parts {
            if let Some(gain) = values.get_mut(at) {
                *gain = self.commanded(f64::from(*gain));
            }
            if law.form != ControllerForm::Parallel {
                break;
            }
            at += 2 + usize::from(part.values) + usize::from(part.filter);
        }
        ControllerLaw {
            low_n: self.commanded(f64::from(law.low_n)),
            high_n: self.commanded(f64::from(law.high_n)),
            ..law.clone()
        }
    }
}

/// The law times one factor, the limits times another.
fn scaled(mut configuration: Configuration, law: f64, limits: f64) -> Configuration {
    let Configuration {
        stiffness_n_per_m,
        dissipation_n_s_mu_per_m,
        own_push_n,
        ..
    } = &mut configuration;
    for value in [stiffness_n_per_m, dissipation_n_s_mu_per_m, own_push_n] {
        *value = (law * f64::from(*value)) as f32;
    }
    let Limits { guard, .. } = &mut configuration.limits;
    guard.damping_n_s_per_m = down(limits * f64::from(guard.damping_n_s_per_m));
    for limit in Limit::ALL {
        if of_force(limit) {
            let (value, _) = configuration.limits.number(limit);
            *value = down(limits * f64::from(*value));
        }
    }
    configuration
}

/// True of a limit in newtons, and of what makes newtons of a motion.
const fn of_force(limit: Limit) -> bool {
    match limit {
        Limit::Force
        | Limit::ForceRate
        | Limit::StartForce
        | Limit::Braking
        | Limit::BrakeForce
        | Limit::StuckForce
        | Limit::DeviceMass => true,
        Limit::Speed
        | Limit::RiseTime
        | Limit::VelocityBandwidth
        | Limit::StopTime
        | Limit::StuckTime
        | Limit::Jump => false,
    }
}

/// The largest number in single precision that is not above this one.
fn down(value: f64) -> f32 {
    let near = value as f32;
    if f64::from(near) > value {
        near.next_down()
    } else {
        near
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Whatever the factor: what was set holds in both newtons, goes back to the device no looser than it was, and a limit in true
        /// newtons bounds the true force.
        #[test]
        fn no_limit_is_looser_for_a_device_that_was_calibrated(
            made in 0.06..15.0_f64, wider in 1.0..1.3_f64, set_n in 1e-3..1e3_f32, asked_n in 1e-3..1e3_f32
        ) {
            let most = made * wider;
            let factors = ForceFactors::new(made, most, 1.0).expect("in range");
            let limited = |force_n| Configuration { limits: Limits::bare(force_n, 10.0 * force_n), ..Configuration::PASSIVE };
            let seen = factors.seen(limited(set_n));
            prop_assert!(seen.limits.force_n <= set_n && f64::from(seen.limits.force_n) <= most * f64::from(set_n));
            let back = factors.told(seen).limits;
            prop_assert!(back.force_n <= set_n && back.force_rate_n_per_s <= 10.0 * set_n);
            let told = factors.told(limited(asked_n)).limits;
            for factor in [made, most] {
                prop_assert!(factor * f64::from(told.force_n) <= f64::from(asked_n) * (1.0 + 1e-12));
            }
            // The law is what was asked for: one division and one product, each rounded once.
            let law = Configuration { stiffness_n_per_m: asked_n, ..Configuration::PASSIVE };
            let known = factors.seen(factors.told(law)).stiffness_n_per_m;
            prop_assert!((known / asked_n - 1.0).abs() < 2.0 * f32::EPSILON);
        }
    }

    #[test]
    fn a_factor_that_no_motor_has_is_refused() {
        for [made, most, sensed] in [
            [0.01, 1.0, 1.0],
            [1.0, 0.9, 1.0],
            [1.0, 1.0, -1.0],
            [f64::NAN, 1.0, 1.0],
        ] {
            assert!(
                ForceFactors::new(made, most, sensed).is_err(),
                "{made} {most} {sensed}"
            );
        }
    }
}
