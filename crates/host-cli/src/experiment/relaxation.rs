//! Stress relaxation: indent, hold, record (the dissertation's chapter VII).
//!
//! The indenter follows a ramp to the strain ε₀ in T₀ and holds it; the renderer opposes it with the
//! force of the virtual tissue. That force is the result. Source: O. Tokatlı, *Fractional Order
//! Control in Haptics*, figure 7.2.

use super::judge::LargestError;
use super::outcome::{Outcome, percent, reaction};
use super::rendering::Rendering;
use super::report::Report;
use super::run::{Record, Supervisor};
use crate::failure::Failure;
use crate::figure::Quantity;
use crate::folder::FolderRequest;
use fracdiff::Seconds;
use haptic_loop::plant::{RampHold, RigDrive};
use std::collections::BTreeMap;

/// The comparison with the closed form begins this long after the end of the ramp, s.
const AFTER_RAMP_S: f64 = 0.1;

/// A relaxation experiment.
#[derive(Clone, Debug)]
pub struct Relaxation {
    /// What is rendered, and how.
    pub rendering: Rendering,
    /// ε₀, the strain that is held, above 0.
    pub strain: f64,
    /// T₀, s.
    pub ramp_time_s: f64,
    /// Until when, s from the start of the ramp.
    pub duration_s: f64,
}

impl Relaxation {
    /// Runs the experiment; log, CSV and picture go into the folder.
    ///
    /// # Errors
    /// Bad parameters, before any file is made; a log, CSV or picture that cannot be written.
    pub fn run(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Report, Failure> {
        let samples = self.check()?;
        let depth = self.rendering.specimen.displacement(self.strain);
        let profile = RampHold::new(depth, Seconds(self.ramp_time_s)).map_err(Failure::input)?;
        let ran = self.rendering.run(
            RigDrive::Position(profile),
            samples,
            request,
            self.metadata(RigDrive::Position(profile)),
            supervisor,
        )?;
        let outcome = self.judge(&ran.record, profile)?;
        let title = format!(
            "Stress relaxation of {}",
            self.rendering.material.description
        );
        let remark = format!(
            "{} % strain in {} s, held until {} s",
            percent(self.strain),
            self.ramp_time_s,
            self.duration_s
        );
        outcome.publish(&self.rendering, &ran, &title, &remark)
    }

    /// The number of samples, if all parameters are good.
    ///
    /// # Errors
    /// A strain, ramp time, duration or sample time outside its range.
    pub fn check(&self) -> Result<u64, Failure> {
        if !(self.strain > 0.0 && self.strain <= 1.0) {
            return Err(Failure::bad_input(format_args!(
                "strain {} is not in (0, 1]: give --strain, as in 5%",
                self.strain
            )));
        }
        let samples = self.rendering.samples(self.duration_s)?;
        if self.ramp_time_s > 0.0 && self.ramp_time_s < self.duration_s {
            Ok(samples)
        } else {
            Err(Failure::bad_input(format_args!(
                "ramp time {} s is not above 0 s and below the duration of {} s: give --ramp-time",
                self.ramp_time_s, self.duration_s
            )))
        }
    }

    /// Closed form of the force, N.
    fn closed_form(&self, time_s: f64) -> f64 {
        let Rendering {
            material, specimen, ..
        } = &self.rendering;
        let stress = material
            .tissue
            .relaxation_stress(self.strain, self.ramp_time_s, time_s);
        specimen.force(stress).0
    }

    fn judge(&self, record: &Record, profile: RampHold) -> Result<Outcome, Failure> {
        let rendering = &self.rendering;
        let time = &record.time_s;
        let force = reaction(record);
        let closed_form: Vec<f64> = time.iter().map(|&t| self.closed_form(t)).collect();
        let history = record
            .of_every_tick(|x| rendering.full_history_force(x))
            .map_err(Failure::Run)?;
        let imposed: Vec<f64> = time.iter().map(|&t| profile.position(t)).collect();
        let ideal = record
            .of_every_tick(|x| {
                let time = (0..x.len()).map(|n| n as f64 * rendering.sample_time_s);
                let imposed: Vec<f64> = time.map(|t| profile.position(t)).collect();
                rendering.full_history_force(&imposed)
            })
            .map_err(Failure::Run)?;
        let hold = self.ramp_time_s + AFTER_RAMP_S;
        let compare = |have: &[f64], want: &[f64], wanted| {
            LargestError::new(hold, wanted, " N").of(time, have, want)
        };
        Ok(Outcome {
            quantity: Quantity::Force,
            closed_form_error: compare(&force, &closed_form, "the closed form"),
            discretisation_error: compare(&ideal, &closed_form, "the closed form").largest,
            rig_error: compare(&history, &ideal, "the force with an ideal rig").largest,
            ideal_position_m: imposed,
            full_history_force_n: history,
            values: force,
            closed_form,
        })
    }

    /// Everything needed to repeat the run.
    fn metadata(&self, drive: RigDrive) -> BTreeMap<String, String> {
        let mut metadata = self.rendering.metadata("relax", drive);
        let mut add = |key: &str, value: String| metadata.insert(key.to_owned(), value);
        add("strain", self.strain.to_string());
        add("ramp_time_s", self.ramp_time_s.to_string());
        add("duration_s", self.duration_s.to_string());
        metadata
    }
}
