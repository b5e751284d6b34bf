//! The experiment that tries a designed wall, and its file.

use super::{Candidate, Design};
use crate::failure::Failure;
use crate::{Pace, Safety, Settling, TrialPlan, TrialVerdict, WallExperiment};
use fracdiff::Order;

/// Push, N, as long as the device can hold four times as much.
const PUSH_N: f64 = 1.0;
/// Length of a run and of its window, s and samples: the larger of the two.
const DURATION: (f64, f64) = (5.0, 2500.0);
const WINDOW: (f64, f64) = (0.4, 200.0);
/// Doublings of the length for a wall that is stable but rings on: up to 256 times as long.
const DOUBLINGS: usize = 8;

impl Design {
    /// A push into a candidate, long enough for it to settle, and how it settled. A wall close to the
    /// edge rings for long, so the run is made longer until it has settled; an unstable one ends in a
    /// vibration against the force limit, which no length makes settle.
    ///
    /// # Errors
    /// A candidate without a wall.
    pub(super) fn trial(
        &self,
        candidate: &Candidate,
    ) -> Result<(WallExperiment, Settling), Failure> {
        let mut stretch = 1.0;
        let mut wall = self.push_into(candidate, stretch)?;
        let mut settling = wall.try_out()?;
        for _ in 0..DOUBLINGS {
            // A device that left or beats against the force limit does not settle later.
            if !matches!(settling.verdict, TrialVerdict::Unstable) {
                break;
            }
            stretch *= 2.0;
            wall = self.push_into(candidate, stretch)?;
            settling = wall.try_out()?;
        }
        Ok((wall, settling))
    }

    /// A trial of a candidate, so many times as long as usual.
    fn push_into(&self, candidate: &Candidate, stretch: f64) -> Result<WallExperiment, Failure> {
        let device = &self.device;
        let t = device.plant.sample_time.0;
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
        Ok(WallExperiment {
            device: device.plant,
            sensors: device.sensors,
            order: Order::new(candidate.order).map_err(Failure::input)?,
            scheme: self.scheme,
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: dissipation,
            one_sided: false,
            plan: TrialPlan {
                push_n,
                duration_s,
                window_s,
                force_limit_n: device.force_limit_n,
                ..TrialPlan::DEFAULT
            },
            must_be_stable: true,
            force_rate_limit_n_per_s: None,
            force_unstable: false,
            remote: None,
            safety: Safety::default(),
            pace: Pace::Virtual,
        })
    }

    /// The experiment file of a wall that was tried.
    pub(super) fn experiment_file(&self, wall: &WallExperiment) -> String {
        let requirement = match self.requirement.gain_margin() {
            Some(margin) => format!("stable with a gain margin of {margin}"),
            None => "passive".to_owned(),
        };
        let device = &wall.device;
        format!(
            "# Written by host-cli design: {wish}, {requirement}.\n\
             # host-cli run FILE tries the wall; it ends with 0 only if trial and analysis call it stable.\n\
             [wall]\n\
             mass_kg = {:?}\n\
             damping_n_s_per_m = {:?}\n\
             hand_stiffness_n_per_m = {:?}\n\
             sample_time_s = {:?}\n\
             delay_s = {:?}\n\
             current_lag_s = {:?}\n\
             friction_n = {:?}\n\
             encoder_resolution_m = {:?}\n\
             sensor_noise_m = {:?}\n\
             seed = {:?}\n\
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
             impact_m_per_s = {:?}\n\
             must_be_stable = {:?}\n",
            device.mass.0,
            device.damping.0,
            device.stiffness.0,
            device.sample_time.0,
            device.delay.0,
            device.lag.0,
            device.friction.0,
            wall.sensors.encoder_resolution_m,
            wall.sensors.noise_m,
            wall.sensors.seed,
            wall.plan.force_limit_n,
            wall.order.get(),
            wall.scheme,
            wall.stiffness_n_per_m,
            wall.dissipation_n_s_mu_per_m,
            wall.plan.push_n,
            wall.plan.duration_s,
            wall.plan.window_s,
            wall.plan.impact_m_per_s,
            wall.must_be_stable,
            wish = self.wish.name(),
        )
    }
}
