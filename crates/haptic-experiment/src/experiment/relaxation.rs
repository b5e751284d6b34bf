//! Stress relaxation: indent, hold, record (the dissertation's chapter VII).
//!
//! The indenter follows a ramp to the strain ε₀ in T₀ and holds it; the renderer opposes it with the
//! force of the virtual tissue. That force is the result. Source: O. Tokatlı, *Fractional Order
//! Control in Haptics*, figure 7.2.

use super::rendering::Rendering;
use super::rendering::outcome::{Comparison, TheorySample, publish};
use super::rendering::{Quantity, Report, TheoryCurves};
use crate::document::failure::Failure;
use crate::experiment::drive::DriveVerdict;
use crate::experiment::rendering::keys::{RAMP_TIME, RELAX_DURATION, STRAIN};
use crate::judge::curves::Published;
use crate::judge::percent;
use crate::judge::reference::ReferenceSeries;
use crate::run::folder::FolderRequest;
use crate::run::samples::Samples;
use crate::run::simulate::Sink;
use crate::run::tick::KeptSample;
use crate::run::{Ran, Supervisor};
use fracdiff::Seconds;
use fracdiff::parameter::Shown;
use haptic_loop::plant::{RampHold, RigDrive};
use haptic_loop::units::Pascals;
use std::collections::BTreeMap;

/// The comparison with the closed form begins this long after the end of the ramp, s.
const AFTER_RAMP_S: f64 = 0.1;

/// A relaxation experiment.
///
/// ```
/// use haptic_experiment::{ModelledTissue, Relaxation, Rendering};
///
/// let tissue = haptic_tissue::Library::load(None)?.find("prostate-cancerous")?;
/// let relaxation = Relaxation::of(Rendering::new(ModelledTissue::new(tissue)?)?);
/// assert_eq!(relaxation.check()?, 200_001);
/// // The tissue relaxes: the force falls after the ramp.
/// assert!(relaxation.closed_form(200.0) < relaxation.closed_form(1.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Relaxation {
    /// The tissue, and how it is rendered.
    pub rendering: Rendering,
    /// ε₀, the strain that is held, above 0.
    pub strain: f64,
    /// T₀, s.
    pub ramp_time_s: f64,
    /// Until when, s from the start of the ramp.
    pub duration_s: f64,
}

impl Relaxation {
    /// With the defaults of the parameters.
    #[must_use]
    pub fn of(rendering: Rendering) -> Self {
        Self {
            rendering,
            strain: STRAIN.default_number(),
            ramp_time_s: RAMP_TIME.default_number(),
            duration_s: RELAX_DURATION.default_number(),
        }
    }

    /// Runs the experiment; log and CSV go into the folder.
    ///
    /// # Errors
    /// Bad parameters, before any file is made; a log or CSV that cannot be written.
    pub fn run(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Published<Report, TheoryCurves>, Failure> {
        let ran = self.record(request, supervisor)?;
        let reported = self.report(&ran)?;
        Ok(Published::new(reported, ran.folder))
    }

    /// Runs the loop and writes the log.
    pub(crate) fn record(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Ran, Failure> {
        let samples = self.check()?;
        let drive = RigDrive::Position(self.profile()?);
        let metadata = self.metadata(drive);
        (self.rendering).run(drive, samples, request, metadata, supervisor)
    }

    /// The same on the simulated rig in virtual time, without folder, log or clock: each sample goes to the sink. `true` if it
    /// reached the end without a fault.
    ///
    /// # Errors
    /// Bad parameters.
    pub fn simulate(&self, sink: Sink<'_>) -> Result<bool, Failure> {
        let samples = self.check()?;
        let drive = RigDrive::Position(self.profile()?);
        self.rendering.simulate(drive, samples, sink)
    }

    /// The verdict on the controller that holds the indenter; `None` without one.
    ///
    /// # Errors
    /// Bad parameters.
    pub fn drive_verdict(&self) -> Result<Option<DriveVerdict>, Failure> {
        let drive = RigDrive::Position(self.profile()?);
        self.rendering.drive_verdict(drive, self.check()?)
    }

    /// The way of the indenter.
    fn profile(&self) -> Result<RampHold, Failure> {
        let depth = self.rendering.specimen.displacement(self.strain);
        RampHold::new(depth, Seconds(self.ramp_time_s)).map_err(Failure::input)
    }

    /// Judges a run; the CSV goes beside its log.
    pub(crate) fn report(&self, ran: &Ran) -> Result<(Report, Option<TheoryCurves>), Failure> {
        let judge = self.judge(ran, self.profile()?)?;
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
        let comparison = Comparison {
            quantity: Quantity::Force,
            drive: RigDrive::Position(self.profile()?),
            from_s: self.ramp_time_s + AFTER_RAMP_S,
            title: &title,
            remark: &remark,
        };
        publish(comparison, &self.rendering, ran, judge)
    }

    /// The number of samples, if all parameters are good.
    ///
    /// # Errors
    /// A strain, ramp time, duration or sample time outside its range.
    pub fn check(&self) -> Result<u64, Failure> {
        if !(self.strain > 0.0 && self.strain <= 1.0) {
            return Err(Failure::bad_input(format_args!(
                "strain {} is not in (0, 1]: give {STRAIN}, as in 0.05",
                Shown(self.strain)
            )));
        }
        let samples = self.rendering.samples(self.duration_s)?;
        if self.ramp_time_s > 0.0 && self.ramp_time_s < self.duration_s {
            Ok(samples)
        } else {
            Err(Failure::bad_input(format_args!(
                "ramp time {} s is not above 0 s and below the duration of {} s: give {RAMP_TIME}",
                Shown(self.ramp_time_s),
                Shown(self.duration_s)
            )))
        }
    }

    /// Closed form of the force, N.
    #[must_use]
    pub fn closed_form(&self, time_s: f64) -> f64 {
        let Rendering {
            material, specimen, ..
        } = &self.rendering;
        let stress = material.relaxation_stress(self.strain, self.ramp_time_s, time_s);
        specimen.force(Pascals(stress)).0
    }

    /// Judges sample by sample.
    fn judge<'a>(
        &'a self,
        ran: &Ran,
        profile: RampHold,
    ) -> Result<impl FnMut(&KeptSample) -> TheorySample + 'a, Failure> {
        let rendering = &self.rendering;
        let samples = Samples::of(&ran.record, &ran.log.paths);
        let mut history = rendering.full_history(samples, self.duration_s)?;
        let t = rendering.sample_time_s;
        let mut ideal = ReferenceSeries::new(
            samples,
            |x| {
                let time = (0..x.len()).map(|n| n as f64 * t);
                let imposed: Vec<f64> = time.map(|time| profile.position(time)).collect();
                rendering.full_history_force(&imposed).map_err(Failure::Run)
            },
            || {
                let mut force = rendering.full_history_step(self.duration_s)?;
                Ok(Box::new(move |tick, _| {
                    force(profile.position(tick as f64 * t))
                }))
            },
        )?;
        let tissue = &rendering.material;
        let mut stress = tissue.relaxation(self.strain, self.ramp_time_s, Seconds(t));
        Ok(move |sample: &KeptSample| {
            let full_history_force_n = history.at(sample);
            let stress = Pascals(stress(sample.tick, sample.time_s));
            TheorySample {
                ideal_position_m: profile.position(sample.time_s),
                full_history_force_n,
                value: sample.reaction_n(),
                closed_form: rendering.specimen.force(stress).0,
                ideal: ideal.at(sample),
                with_rig: full_history_force_n,
            }
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
