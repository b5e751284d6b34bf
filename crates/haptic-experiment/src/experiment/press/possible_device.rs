//! The device of a press, as far as its file knows it.

use crate::document::parameters::{DAMPING, FRICTION, MASS, Parameter};
use crate::document::reader::Interval;
use haptic_loop::plant::MassDamperConfig;

/// Shares of friction at the beginning and at the end of a hold, of which nobody knows more than their size.
const FRICTIONS: [[f64; 2]; 4] = [[1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]];

/// A device that the motor may have moved.
#[derive(Clone, Copy, Debug)]
pub(super) struct PossibleDevice {
    pub mass_kg: f64,
    pub damping_n_s_per_m: f64,
    /// Friction at the beginning and at the end of a hold, N.
    pub friction_n: [f64; 2],
}

impl PossibleDevice {
    /// The likeliest, with no friction in a hold; then those that differ in friction, mass or damping, as far as its file leaves them open.
    pub(super) fn all(device: &MassDamperConfig, intervals: &[Interval]) -> Vec<Self> {
        let ends = |parameter: Parameter, value: f64| {
            let mut found = intervals.iter().filter(|ends| ends.key == parameter.key);
            let found = found.find(|ends| (ends.low..=ends.high).contains(&value));
            found.map(|ends| [ends.low, ends.high])
        };
        let (mass_kg, damping) = (device.mass.0, device.damping.0);
        let friction_n =
            ends(FRICTION, device.friction.0).map_or(device.friction.0, |ends| ends[1]);
        let likeliest = Self {
            mass_kg,
            damping_n_s_per_m: damping,
            friction_n: [0.0; 2],
        };
        let rubbing = FRICTIONS.iter().filter(|_| friction_n > 0.0);
        let rubbing = rubbing.map(|shares| Self {
            friction_n: shares.map(|share| share * friction_n),
            ..likeliest
        });
        let heavy = ends(MASS, mass_kg).into_iter().flatten();
        let heavy = heavy.map(|mass_kg| Self {
            mass_kg,
            ..likeliest
        });
        let damped = ends(DAMPING, damping).into_iter().flatten();
        let damped = damped.map(|damping_n_s_per_m| Self {
            damping_n_s_per_m,
            ..likeliest
        });
        let others = rubbing.chain(heavy).chain(damped);
        [likeliest].into_iter().chain(others).collect()
    }
}
