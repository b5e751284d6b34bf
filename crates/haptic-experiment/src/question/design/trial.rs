//! The experiment that tries a designed wall, and its file.

use super::{Candidate, Design};
use crate::document::failure::Failure;
use crate::{Settling, TrialPlan, TrialSetup, TrialVerdict, WallExperiment};
use fracdiff::{Order, Seconds};

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
        until_settled(
            |stretch| self.push_into(candidate, stretch),
            WallExperiment::try_out,
        )
    }

    /// A trial of a candidate, so many times as long as usual.
    fn push_into(&self, candidate: &Candidate, stretch: f64) -> Result<WallExperiment, Failure> {
        let device = &self.device;
        let (Some(stiffness), Some(dissipation)) = (candidate.stiffness, candidate.dissipation)
        else {
            return Err(Failure::bad_input(format_args!(
                "order {} has no wall to try",
                candidate.order
            )));
        };
        let order = Order::new(candidate.order).map_err(Failure::input)?;
        let plan = plan(device.plant.sample_time, device.force_limit_n, stretch);
        Ok(WallExperiment {
            setup: TrialSetup {
                must_be_stable: true,
                ..TrialSetup::new(device.plant, device.sensors, plan)
            },
            order,
            model: self.model(order).cloned(),
            scheme: self.scheme,
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: dissipation,
            one_sided: false,
        })
    }

    /// The experiment file of a wall that was tried.
    pub(super) fn experiment_file(&self, wall: &WallExperiment) -> String {
        let requirement = match self.requirement.gain_margin() {
            Some(margin) => format!("stable with a gain margin of {margin}"),
            None => "passive".to_owned(),
        };
        format!(
            "# Written by host-cli design: {wish}, {requirement}.\n\
             # host-cli run FILE tries the wall; it ends with 0 only if trial and analysis call it stable.\n\
             [wall]\n\
             {device}\
             \n\
             order = {:?}\n\
             scheme = \"{}\"\n\
             stiffness_n_per_m = {:?}\n\
             dissipation_n_s_mu_per_m = {:?}\n\
             \n\
             {trial}",
            wall.order.get(),
            wall.scheme,
            wall.stiffness_n_per_m,
            wall.dissipation_n_s_mu_per_m,
            wish = self.wish.name(),
            device = device_keys(&wall.setup),
            trial = trial_keys(&wall.setup),
        )
    }
}

/// Tries an experiment, and makes it longer until it has settled.
///
/// # Errors
/// Those of making or trying it.
pub(super) fn until_settled<E>(
    make: impl Fn(f64) -> Result<E, Failure>,
    try_out: impl Fn(&E) -> Result<Settling, Failure>,
) -> Result<(E, Settling), Failure> {
    let mut stretch = 1.0;
    let mut experiment = make(stretch)?;
    let mut settling = try_out(&experiment)?;
    for _ in 0..DOUBLINGS {
        // A device that left or beats against the force limit does not settle later.
        if !matches!(settling.verdict, TrialVerdict::Unstable) {
            break;
        }
        stretch *= 2.0;
        experiment = make(stretch)?;
        settling = try_out(&experiment)?;
    }
    Ok((experiment, settling))
}

/// A push and how long it is looked at, so many times as long as usual.
pub(super) fn plan(sample_time: Seconds, force_limit_n: f64, stretch: f64) -> TrialPlan {
    let larger = |(seconds, samples): (f64, f64)| seconds.max(samples * sample_time.0);
    TrialPlan {
        push_n: PUSH_N.min(0.25 * force_limit_n),
        duration_s: stretch * larger(DURATION),
        window_s: larger(WINDOW),
        force_limit_n,
        ..TrialPlan::DEFAULT
    }
}

/// The device as keys of an experiment file.
pub(super) fn device_keys(setup: &TrialSetup) -> String {
    let TrialSetup {
        device,
        sensors,
        plan,
        ..
    } = setup;
    format!(
        "mass_kg = {:?}\n\
         damping_n_s_per_m = {:?}\n\
         hand_stiffness_n_per_m = {:?}\n\
         sample_time_s = {:?}\n\
         delay_s = {:?}\n\
         current_lag_s = {:?}\n\
         friction_n = {:?}\n\
         encoder_resolution_m = {:?}\n\
         sensor_noise_m = {:?}\n\
         seed = {:?}\n\
         force_limit_n = {:?}\n",
        device.mass.0,
        device.damping.0,
        device.stiffness.0,
        device.sample_time.0,
        device.delay.0,
        device.lag.0,
        device.friction.0,
        sensors.encoder_resolution_m,
        sensors.noise_m,
        sensors.seed,
        plan.force_limit_n,
    )
}

/// The trial as keys of an experiment file.
pub(super) fn trial_keys(setup: &TrialSetup) -> String {
    let TrialSetup {
        plan,
        must_be_stable,
        ..
    } = setup;
    format!(
        "push_n = {:?}\n\
         duration_s = {:?}\n\
         window_s = {:?}\n\
         impact_m_per_s = {:?}\n\
         must_be_stable = {must_be_stable:?}\n",
        plan.push_n, plan.duration_s, plan.window_s, plan.impact_m_per_s,
    )
}
