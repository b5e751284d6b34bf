//! A rendering as metadata of its log.

use super::specification::Rendering;
use crate::experiment::drive::Drive;
use haptic_loop::plant::{RigConfig, RigContact, RigDrive};
use std::collections::BTreeMap;

/// Parameters of a rig as metadata, each with its unit.
fn rig_values(
    rig: &RigConfig,
    drive: Option<&Drive>,
) -> impl Iterator<Item = (String, String)> + use<> {
    let servo = rig.servo;
    let mut values = vec![
        ("renderer_mass_kg", rig.renderer_mass.0),
        ("renderer_damping_n_s_per_m", rig.renderer_damping.0),
        ("indenter_mass_kg", rig.indenter_mass.0),
        ("indenter_damping_n_s_per_m", rig.indenter_damping.0),
    ];
    if let RigContact::Compliant { stiffness, damping } = rig.contact {
        values.push(("contact_stiffness_n_per_m", stiffness.0));
        values.push(("contact_damping_n_s_per_m", damping.0));
        // An imposed position needs no servo, nor does a force, nor what a controller holds.
        if let (RigDrive::Position(_), None) = (rig.drive, drive) {
            values.push(("servo_stiffness_n_per_m", servo.stiffness.0));
            values.push(("servo_damping_n_s_per_m", servo.damping.0));
            values.push(("servo_integral_time_s", servo.integral_time.0));
        }
    }
    if let Some(saturation) = rig.saturation {
        values.push(("renderer_force_saturation_n", saturation.0));
    }
    let named = |(name, value): (&str, f64)| (format!("rig_{name}"), value.to_string());
    values.into_iter().map(named)
}

impl Rendering {
    /// Everything needed to make this rendering again.
    #[must_use]
    pub(crate) fn metadata(&self, experiment: &str, drive: RigDrive) -> BTreeMap<String, String> {
        let entries = [
            ("experiment", experiment.to_owned()),
            ("device", self.device_name()),
            ("tissue", self.material.name.clone()),
            ("area_m2", self.specimen.area().0.to_string()),
            ("thickness_m", self.specimen.thickness().0.to_string()),
            ("scheme", self.scheme.to_string()),
            (
                "precision",
                format!("{:?}", self.precision_run()).to_lowercase(),
            ),
            ("sample_time_s", self.sample_time_s.to_string()),
            ("contact", format!("{:?}", self.contact).to_lowercase()),
            (
                "encoder_resolution_m",
                self.sensors.encoder_resolution_m.to_string(),
            ),
            ("sensor_noise_m", self.sensors.noise_m.to_string()),
            ("seed", self.sensors.seed.to_string()),
            ("force_limit_n", self.force_limit_n.to_string()),
            (
                "force_rate_limit_n_per_s",
                self.force_rate_limit_n_per_s.to_string(),
            ),
            ("pace", self.pace.to_string()),
        ];
        let mut metadata: BTreeMap<String, String> =
            entries.map(|(key, value)| (key.to_owned(), value)).into();
        metadata.extend(self.material.parameters());
        // The rig and the servo as they are built in.
        if self.remote.is_none() {
            metadata.extend(rig_values(&self.rig(drive), self.drive.as_ref()));
        }
        if let Some(own) = &self.drive {
            own.describe(&mut metadata);
        }
        metadata.insert(
            "tissue_source".to_owned(),
            self.material.source.citation.clone(),
        );
        metadata.insert(
            "tissue_checked".to_owned(),
            self.material.source.checked.to_string(),
        );
        self.safety.describe(&mut metadata);
        metadata
    }
}
