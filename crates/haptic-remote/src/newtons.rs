//! Newtons as a device names them, and true ones.
//!
//! ```text
//! f = g·u        u commanded, N; f made, N; g the motor's factor, between g₋ and g₊
//! F = s·r        r shown by the force sensor, N; F true, N; s the sensor's factor
//! ```
//! - *To the device* go u = f/g, K/g, B/g and the gains of a controller over g. A limit L goes as L/g₊: whatever g is, the true force stays
//!   below L. Damping that brakes or that a guard counts on goes as 2ᵏ times itself, the largest power of 2 up to 1/g₊: what is set on a device
//!   has to stay to the last bit.
//! - *From the device* come f = g·u and F = s·r, and a limit L as min(1, g₊)·L: it holds in its own newtons and in true ones. So what
//!   was set on a device is never looser for a device that was calibrated.
//! - *Rounding* of limits is towards tight, of everything else to the nearest. *Cost*: a product for each force.

use fracdiff::parameter::{RangeError, range};
use haptic_link::{Capabilities, Configuration, ControllerForm, ControllerLaw, Sample};
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

    /// Newtons of the device, whatever they are.
    pub(crate) const OWN: Self = Self {
        made: 1.0,
        made_most: 1.0,
        sensed: 1.0,
    };

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
    pub(crate) const fn commanded(&self, true_n: f64) -> f32 {
        (true_n / self.made) as f32
    }

    /// True force for newtons of the device.
    pub(crate) fn made(&self, commanded_n: f32) -> f32 {
        (self.made * f64::from(commanded_n)) as f32
    }

    /// A sample in true newtons.
    pub(crate) fn read(&self, mut sample: Sample) -> Sample {
        for item in &mut sample.axes {
            item.force_n = self.made(item.force_n);
            item.environment_force_n = self.made(item.environment_force_n);
        }
        for shown in &mut sample.sensed_force_n {
            *shown = (self.sensed * f64::from(*shown)) as f32;
        }
        sample
    }

    /// Abilities of the device in true newtons; those of its motor are rounded down.
    pub(crate) fn able(&self, can: Capabilities) -> Capabilities {
        let share = self.made_most.min(1.0);
        Capabilities {
            force_max_n: down(share * f64::from(can.force_max_n)),
            force_rate_max_n_per_s: down(share * f64::from(can.force_rate_max_n_per_s)),
            sensed_force_max_n: (self.sensed * f64::from(can.sensed_force_max_n)) as f32,
            ..can
        }
    }

    /// A configuration of the device in true newtons.
    pub(crate) fn seen(&self, configuration: Configuration) -> Configuration {
        let damping = 1.0 / self.damping();
        scaled(configuration, self.made, self.made_most.min(1.0), damping)
    }

    /// A configuration in true newtons as the device takes it.
    pub(crate) fn told(&self, configuration: Configuration) -> Configuration {
        scaled(
            configuration,
            1.0 / self.made,
            1.0 / self.made_most,
            self.damping(),
        )
    }

    /// The largest power of 2 that is not above 1/g₊.
    fn damping(&self) -> f64 {
        // Its exponent alone.
        f64::from_bits((1.0 / self.made_most).to_bits() & 0x7ff0_0000_0000_0000)
    }

    /// A controller whose command is a true force, as the device takes it.
    pub(crate) fn told_controller(&self, law: &ControllerLaw, values: &mut [f32]) -> ControllerLaw {
        let told = |own: f32| self.commanded(own.into());
        let mut at = 1;
        for part in &law.parts {
            if let Some(gain) = values.get_mut(at) {
                *gain = told(*gain);
            }
            if law.form != ControllerForm::Parallel {
                break;
            }
            at += 2 + usize::from(part.values) + usize::from(part.filter);
        }
        ControllerLaw {
            low_n: told(law.low_n),
            high_n: told(law.high_n),
            ..law.clone()
        }
    }
}

/// Law, limits and damping, each times its factor.
fn scaled(mut known: Configuration, law: f64, limits: f64, damping: f64) -> Configuration {
    for value in [
        &mut known.stiffness_n_per_m,
        &mut known.dissipation_n_s_mu_per_m,
        &mut known.own_push_n,
        &mut known.tap_n,
    ] {
        *value = (law * f64::from(*value)) as f32;
    }
    known.limits.guard.damping_n_s_per_m *= damping as f32;
    known.limits.braking_n_s_per_m *= damping as f32;
    for limit in Limit::ALL.into_iter().filter(|limit| of_force(*limit)) {
        let (value, _) = known.limits.number(limit);
        *value = down(limits * f64::from(*value));
    }
    known
}

/// True of a limit in newtons.
const fn of_force(limit: Limit) -> bool {
    match limit {
        Limit::Force
        | Limit::ForceRate
        | Limit::StartForce
        | Limit::BrakeForce
        | Limit::StuckForce
        | Limit::DeviceMass => true,
        Limit::Speed
        | Limit::RiseTime
        | Limit::VelocityBandwidth
        | Limit::StopTime
        | Limit::StuckTime
        | Limit::Jump
        | Limit::Braking => false,
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
    use haptic_link::Limits;
    use proptest::prelude::*;

    /// Limits that say so much, with braking and a guard.
    fn limited(force_n: f32) -> Configuration {
        let mut limits = Limits::bare(force_n, 10.0 * force_n);
        limits.braking_n_s_per_m = 3.0 * force_n;
        limits.guard.damping_n_s_per_m = 0.7 * force_n;
        Configuration {
            limits,
            stiffness_n_per_m: force_n,
            ..Configuration::PASSIVE
        }
    }

    proptest! {
        /// Whatever the factor: what was set holds in both newtons, goes back to the device no looser than it was, and a limit in true
        /// newtons bounds the true force. A law is what was asked for, with its sign.
        #[test]
        fn no_limit_is_looser_for_a_device_that_was_calibrated(
            made in 0.05..15.0_f64, wider in 1.0..1.3_f64, set_n in 1e-3..1e3_f32, asked_n in 1e-3..1e3_f32, force_n in -1e3..1e3_f64
        ) {
            let most = made * wider;
            let factors = ForceFactors::new(made, most, 1.0).expect("in range");
            let (set, seen) = (limited(set_n).limits, factors.seen(limited(set_n)));
            prop_assert!(seen.limits.force_n <= set_n && f64::from(seen.limits.force_n) <= most * f64::from(set_n));
            let back = factors.told(seen).limits;
            prop_assert!(back.force_n <= set_n && back.force_rate_n_per_s <= 10.0 * set_n);
            // What has no order stays as it was set.
            prop_assert_eq!((back.braking_n_s_per_m.to_bits(), back.guard), (set.braking_n_s_per_m.to_bits(), set.guard));
            let told = factors.told(limited(asked_n));
            for factor in [made, most] {
                let more = |told: f32, asked: f32| factor * f64::from(told) > f64::from(asked) * (1.0 + 1e-12);
                let (told, asked) = (told.limits, limited(asked_n).limits);
                prop_assert!(!more(told.force_n, asked.force_n) && !more(told.force_rate_n_per_s, asked.force_rate_n_per_s));
                prop_assert!(!more(told.braking_n_s_per_m, asked.braking_n_s_per_m));
                prop_assert!(!more(told.guard.damping_n_s_per_m, asked.guard.damping_n_s_per_m));
            }
            // One division and one product, each rounded once.
            let known = factors.seen(told).stiffness_n_per_m;
            prop_assert!((known / asked_n - 1.0).abs() < 2.0 * f32::EPSILON);
            let commanded = factors.commanded(force_n);
            prop_assert!(commanded.is_finite() && f64::from(commanded) * force_n >= 0.0);
            prop_assert!((f64::from(factors.made(commanded)) - force_n).abs() <= 2e-7 * force_n.abs());
        }
    }

    #[test]
    fn own_newtons_change_no_bit() {
        for value in [0.0, -0.1, 1e-40, f32::MAX, f32::INFINITY, f32::NAN] {
            let own = ForceFactors::OWN;
            assert_eq!(own.made(value).to_bits(), value.to_bits());
            assert_eq!(own.commanded(value.into()).to_bits(), value.to_bits());
            assert_eq!(down(value.into()).to_bits(), value.to_bits());
        }
        let known = limited(0.1);
        assert_eq!(
            (ForceFactors::OWN.told(known), ForceFactors::OWN.seen(known)),
            (known, known)
        );
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
