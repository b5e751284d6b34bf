//! The experiment that tries a designed wall, and its file.

use super::{Candidate, Design};
use crate::experiment::{Pace, Safety, Sensors, Settling, Wall};
use crate::failure::Failure;
use fracdiff::{Order, Seconds};
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, NewtonsPerMetre};

/// Push, N, as long as the device can hold four times as much.
const PUSH_N: f64 = 1.0;
/// Length of a run and of its window, s and samples: the larger of the two.
const DURATION: (f64, f64) = (5.0, 2500.0);
const WINDOW: (f64, f64) = (0.4, 200.0);
/// Threshold where the wall is soft, m, and as a share of the deflection where it is stiff.
const THRESHOLD: (f64, f64) = (1e-4, 0.5);
/// A fractional wall creeps to its place; so many times what it still creeps in the window is no
/// motion.
const CREEP: f64 = 4.0;
/// Doublings of the length for a wall that is stable but rings on: up to 256 times as long.
const DOUBLINGS: usize = 8;

impl Design {
    /// A push into a candidate, long enough for it to settle, and how it settled. A wall close to the
    /// edge rings for long, so the run is made longer until it has settled; an unstable one ends in a
    /// vibration against the force limit, which no length makes settle.
    ///
    /// # Errors
    /// A candidate without a wall.
    pub(super) fn trial(&self, candidate: &Candidate) -> Result<(Wall, Settling), Failure> {
        let mut stretch = 1.0;
        let mut wall = self.push_into(candidate, stretch)?;
        let mut settling = wall.try_out()?;
        for _ in 0..DOUBLINGS {
            if settling.stable {
                break;
            }
            stretch *= 2.0;
            wall = self.push_into(candidate, stretch)?;
            settling = wall.try_out()?;
        }
        Ok((wall, settling))
    }

    /// A push into a candidate, with a threshold that fits its deflection.
    ///
    /// ```text
    /// x = push/(K + k + B·D^(−μ))      about where it is after the time D
    /// ```
    fn push_into(&self, candidate: &Candidate, stretch: f64) -> Result<Wall, Failure> {
        let device = &self.device;
        let t = device.sample_time_s;
        let (Some(stiffness), Some(dissipation)) = (candidate.stiffness, candidate.dissipation)
        else {
            return Err(Failure::bad_input(format_args!(
                "order {} has no wall to try",
                candidate.order
            )));
        };
        let push_n = PUSH_N.min(0.25 * device.force_limit_n);
        let larger = |(seconds, samples): (f64, f64)| seconds.max(samples * t);
        let (duration_s, window_s) = (stretch * larger(DURATION), larger(WINDOW));
        let creeping = dissipation * duration_s.powf(-candidate.order);
        let spring = stiffness + device.hand_stiffness_n_per_m + creeping;
        let deflection = push_n / spring;
        // x(D) − x(D − W) ≈ μ·(W/D)·x of what the dissipation holds; a uniform motion deviates by
        // 1/√12 of its length.
        let creep = candidate.order * (window_s / duration_s) * deflection * creeping / spring;
        let settled =
            (CREEP * creep / 12.0_f64.sqrt()).max(THRESHOLD.0.min(THRESHOLD.1 * deflection));
        Ok(Wall {
            device: MassDamperConfig {
                stiffness: NewtonsPerMetre(device.hand_stiffness_n_per_m),
                delay: Seconds(device.delay_samples as f64 * t),
                ..MassDamperConfig::ideal(
                    Kilograms(device.mass_kg),
                    NewtonSecondsPerMetre(device.damping_n_s_per_m),
                    Seconds(t),
                )
            },
            sensors: Sensors {
                encoder_resolution_m: 0.0,
                noise_m: 0.0,
                seed: 1,
            },
            order: Order::new(candidate.order).map_err(Failure::input)?,
            scheme: self.scheme,
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: dissipation,
            one_sided: false,
            push_n,
            duration_s,
            window_s,
            threshold_m: two_digits(settled),
            force_rate_limit_n_per_s: None,
            force_limit_n: device.force_limit_n,
            force_unstable: false,
            remote: None,
            safety: Safety::default(),
            pace: Pace::Virtual,
        })
    }

    /// The experiment file of a wall that was tried.
    pub(super) fn experiment_file(&self, wall: &Wall) -> String {
        let requirement = match self.requirement.gain_margin() {
            Some(margin) => format!("stable with a gain margin of {margin}"),
            None => "passive".to_owned(),
        };
        let device = &wall.device;
        format!(
            "# Written by host-cli design: {wish}, {requirement}.\n\
             # host-cli run FILE pushes the device into the wall and says whether it settles.\n\
             [wall]\n\
             mass_kg = {:?}\n\
             damping_n_s_per_m = {:?}\n\
             hand_stiffness_n_per_m = {:?}\n\
             sample_time_s = {:?}\n\
             delay_s = {:?}\n\
             force_limit_n = {:?}\n\
             \n\
             order = {:?}\n\
             scheme = \"{}\"\n\
             stiffness_n_per_m = {:?}\n\
             dissipation_n_s_mu_per_m = {:?}\n\
             \n\
             push_n = {:?}\n\
             duration_s = {:?}\n\
             window_s = {:?}\n\
             threshold_m = {:?}\n",
            device.mass.0,
            device.damping.0,
            device.stiffness.0,
            device.sample_time.0,
            device.delay.0,
            wall.force_limit_n,
            wall.order.get(),
            wall.scheme,
            wall.stiffness_n_per_m,
            wall.dissipation_n_s_mu_per_m,
            wall.push_n,
            wall.duration_s,
            wall.window_s,
            wall.threshold_m,
            wish = self.wish.name(),
        )
    }
}

/// Rounded to two digits, for a file that people read.
fn two_digits(x: f64) -> f64 {
    format!("{x:.1e}").parse().unwrap_or(x)
}
