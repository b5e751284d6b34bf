//! A trial in words: the metadata of its log, the line below its picture, its warnings.

use super::setup::TrialSetup;
use crate::document::named::Named as _;
use crate::judge::settling::Settling;
use crate::judge::warnings::Warnings;
use crate::run::record::Record;
use crate::run::remote::device_name;
use crate::run::safety::GuardChoice;
use fracdiff::{Order, Scheme};
use std::collections::BTreeMap;

impl TrialSetup {
    /// Everything of it that is needed to repeat the run of this law.
    pub(crate) fn metadata(
        &self,
        kind: &str,
        (order, scheme): (Order, Scheme),
        law: Vec<(&'static str, String)>,
    ) -> BTreeMap<String, String> {
        let (device, plan) = (&self.device, self.plan());
        let entries = [
            ("experiment", kind.to_owned()),
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
            ("order", order.to_string()),
            ("scheme", scheme.to_string()),
            ("impact_m_per_s", plan.impact_m_per_s.to_string()),
            ("push_n", plan.push_n.to_string()),
            ("duration_s", plan.duration_s.to_string()),
            ("window_s", plan.window_s.to_string()),
            ("force_limit_n", plan.force_limit_n.to_string()),
            ("pace", self.pace.to_string()),
        ];
        let mut metadata: BTreeMap<String, String> = entries
            .into_iter()
            .chain(law)
            .map(|(key, value)| (key.to_owned(), value))
            .collect();
        self.safety().describe(&mut metadata);
        metadata
    }

    /// Device, operator, push, verdict and guard for the line below a picture.
    pub(crate) fn words(&self, scheme: Scheme, settling: &Settling) -> String {
        let guard = match self.safety.guard {
            GuardChoice::Off => String::new(),
            guard => format!(" · guard {}", guard.name()),
        };
        format!(
            "device {} · scheme {scheme} · push {} N · {}{guard}",
            device_name(self.remote.as_ref()),
            self.plan.push_n,
            settling.verdict.words()
        )
    }
}

/// Warnings about a trial of a wall or a coupler, and about the analysis beside it.
pub(super) fn warnings(
    what: &str,
    settling: &Settling,
    agrees: Option<bool>,
    record: &Record,
) -> Warnings {
    let mut warnings = Warnings::default();
    match settling.reason() {
        None => warnings.limited(record),
        Some(reason) if record.ended.is_none() => warnings.0.push(format!(
            "the {what} is {}: {reason}",
            settling.verdict.words()
        )),
        Some(_) => {}
    }
    if agrees == Some(false) {
        let why = if settling.stable {
            format!(
                "what the analysis does not know (friction, encoder, limits of the force and of its rate) holds the device, or the \
                 {what} grows unstable more slowly than the trial lasts"
            )
        } else {
            let contact = match what {
                "wall" => ", a wall that only pushes",
                _ => "",
            };
            format!(
                "what the analysis does not know (encoder, limits of the force and of its rate{contact}) shakes the \
                 device, or the {what} settles more slowly than the trial lasts"
            )
        };
        warnings.0.push(format!(
            "trial and analysis disagree: {} by the trial, {} by the analysis; {why}",
            settling.verdict.words(),
            if settling.stable {
                "unstable"
            } else {
                "stable"
            },
        ));
    }
    warnings
}

/// To six significant digits, as a subtitle shows a number.
pub(crate) fn six_digits(value: f64) -> f64 {
    // A formatted number is a number again.
    format!("{value:.5e}").parse().unwrap_or(value)
}
