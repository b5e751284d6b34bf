//! The best coupler, tried, and the experiment file of it.

use super::{CouplerCandidate, CouplerDesign};
use crate::document::failure::Failure;
use crate::question::asked_device::AskedDevice;
use crate::question::design::trial::{device_keys, plan, trial_keys, until_settled};
use crate::{CouplerExperiment, Imperfections, Settling, TrialPlan, TrialSetup};
use fracdiff::Order;
use serde::Serialize;
use std::sync::atomic::AtomicBool;

/// Answer to a [`CouplerDesign`].
#[derive(Clone, Debug, Serialize)]
pub struct CouplerAnswer {
    /// Mass, damping, hand and sample time of the device.
    #[serde(flatten)]
    pub asked: AskedDevice,
    /// `coupler`.
    pub wish: &'static str,
    /// The criterion.
    pub require: &'static str,
    /// Frequency at which stiffness is compared, Hz.
    pub frequency_hz: f64,
    /// Operator.
    pub scheme: String,
    /// Of the `stiffness` of candidates, the damper.
    pub stiffness_unit: &'static str,
    /// Of their `dissipation`, the spring.
    pub dissipation_unit: &'static str,
    /// The stiffest of each order.
    pub candidates: Vec<CouplerCandidate>,
    /// The stiffest of all as felt at the frequency; null if there is none.
    pub best: Option<CouplerCandidate>,
    /// The trial of the best, on the ideal device.
    pub simulated: Option<Settling>,
    /// The experiment that runs it.
    #[serde(skip)]
    pub experiment_text: Option<String>,
}

impl CouplerDesign {
    /// Answers it: candidates, the best of them, its trial and its experiment file.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn answer(&self) -> Result<CouplerAnswer, Failure> {
        self.answer_unless(&AtomicBool::new(false), &|_| {})
    }

    /// The same; `progress` hears of each order that is done, `stop` ends it before the next.
    ///
    /// # Errors
    /// A parameter outside its range; a stop.
    pub fn answer_unless(
        &self,
        stop: &AtomicBool,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<CouplerAnswer, Failure> {
        let candidates = self.candidates_unless(stop, progress)?;
        let felt = |c: &CouplerCandidate| c.felt_stiffness_n_per_m.unwrap_or(0.0);
        let best = candidates
            .iter()
            .filter(|c| c.dissipation.is_some())
            .max_by(|a, b| felt(a).total_cmp(&felt(b)))
            .cloned();
        let mut answer = CouplerAnswer {
            asked: AskedDevice::of(&self.device),
            wish: "coupler",
            require: self.criterion.name(),
            frequency_hz: self.frequency_hz,
            scheme: self.scheme.to_string(),
            stiffness_unit: "N·s/m",
            dissipation_unit: "N·s^(1−μ)/m",
            candidates,
            best,
            simulated: None,
            experiment_text: None,
        };
        // What can only be analysed cannot be tried.
        if let Some(best) = answer
            .best
            .as_ref()
            .filter(|_| self.scheme != fracdiff::Scheme::Exact)
        {
            let make = |stretch| self.push_into(best, stretch);
            let (coupler, settling) = until_settled(make, CouplerExperiment::try_out)?;
            answer.simulated = Some(settling);
            answer.experiment_text = Some(self.experiment_file(&coupler));
        }
        Ok(answer)
    }

    /// Memory of the operator that runs, samples.
    pub(super) fn horizon(&self) -> f64 {
        let t = self.device.sample_time;
        crate::run::schedule::horizon((self.plan(1.0).duration_s / t.0) as u64)
    }

    fn plan(&self, stretch: f64) -> TrialPlan {
        let limit = TrialPlan::DEFAULT.force_limit_n;
        plan(self.device.sample_time, limit, stretch)
    }

    /// A trial of a candidate, so many times as long as usual.
    fn push_into(
        &self,
        candidate: &CouplerCandidate,
        stretch: f64,
    ) -> Result<CouplerExperiment, Failure> {
        let sensors = Imperfections::NONE.sensors;
        Ok(CouplerExperiment {
            setup: TrialSetup {
                must_be_stable: true,
                ..TrialSetup::new(self.device, sensors, self.plan(stretch))
            },
            order: Order::new(candidate.order).map_err(Failure::input)?,
            scheme: self.scheme,
            coupler_stiffness_n_s_per_m: candidate.stiffness.unwrap_or(0.0),
            coupler_dissipation_n_s_1_minus_mu_per_m: candidate.dissipation.unwrap_or(0.0),
            object: self.object,
        })
    }

    /// The experiment file of a coupler that was tried.
    fn experiment_file(&self, coupler: &CouplerExperiment) -> String {
        format!(
            "# Written by host-cli design: coupler, {criterion}, gain margin 2 in the sampled loop.\n\
             # host-cli run FILE tries it; it ends with 0 only if trial and analysis call it stable and Llewellyn's criterion is met.\n\
             [coupler]\n\
             {device}\
             \n\
             order = {:?}\n\
             scheme = \"{}\"\n\
             coupler_stiffness_n_s_per_m = {:?}\n\
             coupler_dissipation_n_s_1_minus_mu_per_m = {:?}\n\
             \n\
             object_mass_kg = {:?}\n\
             object_damping_n_s_per_m = {:?}\n\
             object_stiffness_n_per_m = {:?}\n\
             \n\
             {trial}",
            coupler.order.get(),
            coupler.scheme,
            coupler.coupler_stiffness_n_s_per_m,
            coupler.coupler_dissipation_n_s_1_minus_mu_per_m,
            coupler.object.mass_kg,
            coupler.object.damping_n_s_per_m,
            coupler.object.stiffness_n_per_m,
            criterion = self.criterion.name(),
            device = device_keys(&coupler.setup),
            trial = trial_keys(&coupler.setup),
        )
    }
}
