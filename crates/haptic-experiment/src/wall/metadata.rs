//! A wall experiment as metadata of its log.

use super::specification::WallExperiment;
use crate::named::Named as _;
use crate::remote::device_name;
use crate::settling::Criterion;
use std::collections::BTreeMap;

impl WallExperiment {
    /// Everything needed to repeat the run.
    pub(super) fn metadata(&self) -> BTreeMap<String, String> {
        let (device, plan) = (&self.device, self.plan());
        let entries = [
            ("experiment", "wall".to_owned()),
            ("device", device_name(self.remote.as_ref())),
            ("mass_kg", device.mass.0.to_string()),
            ("damping_n_s_per_m", device.damping.0.to_string()),
            ("hand_stiffness_n_per_m", device.stiffness.0.to_string()),
            ("sample_time_s", device.sample_time.0.to_string()),
            ("delay_s", device.delay.0.to_string()),
            ("friction_n", device.friction.0.to_string()),
            ("current_lag_s", device.lag.0.to_string()),
            (
                "encoder_resolution_m",
                self.sensors.encoder_resolution_m.to_string(),
            ),
            ("sensor_noise_m", self.sensors.noise_m.to_string()),
            ("seed", self.sensors.seed.to_string()),
            ("order", self.order.to_string()),
            ("scheme", self.scheme.to_string()),
            ("stiffness_n_per_m", self.stiffness_n_per_m.to_string()),
            (
                "dissipation_n_s_mu_per_m",
                self.dissipation_n_s_mu_per_m.to_string(),
            ),
            ("one_sided", self.one_sided.to_string()),
            ("criterion", plan.criterion.name().name().to_owned()),
            ("impact_m_per_s", plan.impact_m_per_s.to_string()),
            ("push_n", plan.push_n.to_string()),
            ("duration_s", plan.duration_s.to_string()),
            ("window_s", plan.window_s.to_string()),
            ("force_limit_n", plan.force_limit_n.to_string()),
            ("pace", self.pace.to_string()),
        ];
        let mut metadata: BTreeMap<String, String> =
            entries.map(|(key, value)| (key.to_owned(), value)).into();
        if let Criterion::Dissertation { threshold_m } = plan.criterion {
            metadata.insert("threshold_m".to_owned(), threshold_m.to_string());
        }
        self.safety.describe(&mut metadata);
        metadata
    }
}
