//! A touch as metadata of its log.

use super::hand::{Grip, HandPath};
use super::shape::{TouchLaw, TouchShape};
use super::specification::TouchExperiment;
use crate::judge::modelled_tissue::TissuePiece;
use crate::run::remote::device_name;
use std::collections::BTreeMap;

/// Numbers with a space between them.
fn list(numbers: &[f64]) -> String {
    let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
    numbers.join(" ")
}

impl TouchExperiment {
    /// Everything needed to repeat the run, as its log has it in the record `experiment`.
    #[must_use]
    pub fn metadata(&self) -> BTreeMap<String, String> {
        let (k, b) = self.law.spring_and_damper();
        let mut entries = vec![
            ("experiment", "touch".to_owned()),
            ("device", device_name(self.remote.as_ref())),
            ("axes", self.axes.to_string()),
            ("stiffness_n_per_m", k.to_string()),
            ("dissipation_n_s_mu_per_m", b.to_string()),
            ("order", self.law.order().to_string()),
            ("scheme", self.scheme.to_string()),
            ("mass_kg", list(&self.mass_kg)),
            ("damping_n_s_per_m", self.device.damping.0.to_string()),
            ("delay_s", self.device.delay.0.to_string()),
            ("friction_n", self.device.friction.0.to_string()),
            ("current_lag_s", self.device.lag.0.to_string()),
            (
                "encoder_resolution_m",
                self.sensors.encoder_resolution_m.to_string(),
            ),
            ("sensor_noise_m", self.sensors.noise_m.to_string()),
            ("seed", self.sensors.seed.to_string()),
            ("sample_time_s", self.sample_time().0.to_string()),
            ("duration_s", self.duration_s.to_string()),
            ("force_limit_n", self.force_limit_n.to_string()),
            ("pace", self.pace.to_string()),
        ];
        entries.extend(self.describe_shape());
        if self.remote.is_none() {
            entries.extend(self.describe_hand());
        }
        if let Some(workspace) = &self.workspace {
            entries.push(("box_low_m", list(&workspace.low_m)));
            entries.push(("box_high_m", list(&workspace.high_m)));
        }
        if let Some(rate) = self.force_rate_limit_n_per_s {
            entries.push(("force_rate_limit_n_per_s", rate.to_string()));
        }
        let mut metadata: BTreeMap<String, String> = (entries.into_iter())
            .map(|(key, value)| (key.to_owned(), value))
            .collect();
        self.safety.describe(&mut metadata);
        metadata
    }

    fn describe_shape(&self) -> Vec<(&'static str, String)> {
        let mut entries = match &self.shape {
            TouchShape::Plane { normal, surface_m } => vec![
                ("shape", "plane".to_owned()),
                ("normal", list(normal)),
                ("surface_m", surface_m.to_string()),
            ],
            TouchShape::Ball {
                centre_m,
                radius_m,
                hollow,
            } => {
                let name = if *hollow { "hollow-ball" } else { "ball" };
                vec![
                    ("shape", name.to_owned()),
                    ("centre_m", list(centre_m)),
                    ("radius_m", radius_m.to_string()),
                ]
            }
        };
        if let TouchLaw::Tissue(TissuePiece { material, specimen }) = &self.law {
            entries.push(("tissue", material.name.clone()));
            entries.push(("area_m2", specimen.area().0.to_string()));
            entries.push(("thickness_m", specimen.thickness().0.to_string()));
        }
        entries
    }

    fn describe_hand(&self) -> Vec<(&'static str, String)> {
        let mut entries = match self.grip {
            Grip::Spring(stiffness) => vec![
                ("hand", "spring".to_owned()),
                ("hand_stiffness_n_per_m", stiffness.to_string()),
            ],
            Grip::Force => vec![("hand", "force".to_owned())],
        };
        match &self.path {
            HandPath::WayPoints(rows) => {
                let rows = rows.iter();
                let rows: Vec<String> = rows
                    .map(|(time_s, place)| format!("{time_s} {}", list(place)))
                    .collect();
                entries.push(("way_points", rows.join("; ")));
            }
            HandPath::Circle {
                centre,
                start_radius,
                radius,
                period_s,
            } => entries.extend([
                ("circle_centre_m", list(centre)),
                ("circle_start_radius_m", start_radius.to_string()),
                ("circle_radius_m", radius.to_string()),
                ("circle_period_s", period_s.to_string()),
            ]),
        }
        entries
    }
}
