//! Metadata of the log of a teleoperation.

use super::specification::TeleoperationExperiment;
use std::collections::BTreeMap;

impl TeleoperationExperiment {
    /// Everything needed to repeat the run.
    pub(super) fn metadata(&self) -> BTreeMap<String, String> {
        let entries = [
            ("experiment", "teleoperation".to_owned()),
            ("device", "sim".to_owned()),
            ("architecture", self.architecture.name().to_owned()),
            ("place", self.place.words()),
            ("mass_kg", self.master.mass.0.to_string()),
            ("damping_n_s_per_m", self.master.damping.0.to_string()),
            ("slave_mass_kg", self.slave.mass.0.to_string()),
            ("slave_damping_n_s_per_m", self.slave.damping.0.to_string()),
            (
                "hand_stiffness_n_per_m",
                self.hand.stiffness_n_per_m.to_string(),
            ),
            (
                "hand_damping_n_s_per_m",
                self.hand.damping_n_s_per_m.to_string(),
            ),
            ("press_m", self.motion.press_m.to_string()),
            ("amplitude_m", self.motion.amplitude_m.to_string()),
            (
                "frequencies_hz",
                format!("{:?}", self.motion.frequencies_hz),
            ),
            (
                "coupler_stiffness_n_per_m",
                self.coupler.stiffness_n_per_m.to_string(),
            ),
            (
                "coupler_dissipation_n_s_mu_per_m",
                self.coupler.dissipation_n_s_mu_per_m.to_string(),
            ),
            ("order", self.order.to_string()),
            ("scheme", self.scheme.to_string()),
            (
                "wave_impedance_n_s_per_m",
                self.wave_impedance_n_s_per_m.to_string(),
            ),
            ("playout_samples", self.playout().to_string()),
            ("line_delay_s", self.channel.delay.0.to_string()),
            ("line_jitter", self.channel.jitter.to_string()),
            ("line_loss", self.channel.loss.to_string()),
            ("line_duplication", self.channel.duplication.to_string()),
            ("seed", self.seed.to_string()),
            ("silence_s", self.silence_s.to_string()),
            ("sample_time_s", self.sample_time().0.to_string()),
            ("duration_s", self.duration_s.to_string()),
            ("window_s", self.window_s.to_string()),
            ("force_limit_n", self.force_limit_n.to_string()),
            ("pace", self.pace.to_string()),
        ];
        let mut metadata: BTreeMap<String, String> = (entries.into_iter())
            .map(|(key, value)| (key.to_owned(), value))
            .collect();
        self.safety.describe(&mut metadata);
        metadata
    }
}
