//! Creep: push with a constant force, record the strain.
//!
//! The indenter pushes the renderer with σ₀·A from t = 0; the renderer opposes it with the force of
//! the virtual tissue, and both sink in. The closed form is that of the tissue alone; the masses and
//! the damping of the rig, 7 N·s/m together, slow the start down.

use super::rendering::Rendering;
use super::rendering::outcome::{Comparison, TheorySample, publish};
use super::rendering::{Quantity, Report, TheoryCurves};
use crate::document::failure::Failure;
use crate::experiment::drive::DriveVerdict;
use crate::experiment::rendering::keys::STRESS;
use crate::judge::curves::Published;
use crate::judge::reference::ReferenceSeries;
use crate::run::folder::FolderRequest;
use crate::run::samples::Samples;
use crate::run::simulate::Sink;
use crate::run::tick::KeptSample;
use crate::run::{Ran, Supervisor};
use fracdiff::Seconds;
use fracdiff::parameter::Shown;
use haptic_loop::plant::RigDrive;
use haptic_loop::units::{Metres, Pascals};
use std::collections::BTreeMap;

/// The comparison with the closed form begins here, s: before, the rig itself is moving.
const FROM_S: f64 = 1.0;

/// A creep experiment.
///
/// ```
/// use haptic_experiment::{Creep, ModelledTissue, Rendering};
/// use std::ops::ControlFlow;
///
/// let tissue = haptic_tissue::Library::load(None)?.find("prostate-cancerous")?;
/// let creep = Creep {
///     rendering: Rendering::new(ModelledTissue::new(tissue)?)?,
///     stress_pa: 100.0,
///     duration_s: 0.2,
/// };
/// let mut position_m = 0.0;
/// creep.simulate(&mut |sample| {
///     position_m = sample.position_m;
///     ControlFlow::Continue(())
/// })?;
/// assert!(position_m > 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Creep {
    /// The tissue, and how it is rendered.
    pub rendering: Rendering,
    /// σ₀, Pa, above 0.
    pub stress_pa: f64,
    /// Duration, s.
    pub duration_s: f64,
}

impl Creep {
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
        let push = self.rendering.specimen.force(Pascals(self.stress_pa));
        let drive = RigDrive::Force(push);
        let metadata = self.metadata(drive);
        (self.rendering).run(drive, samples, request, metadata, supervisor)
    }

    /// The same on the simulated rig in virtual time, without folder, log or clock: each sample goes to the sink. `true` if it
    /// reached the end without a fault.
    ///
    /// # Errors
    /// Bad parameters.
    pub fn simulate(&self, sink: Sink<'_>) -> Result<bool, Failure> {
        let push = self.rendering.specimen.force(Pascals(self.stress_pa));
        let samples = self.check()?;
        self.rendering
            .simulate(RigDrive::Force(push), samples, sink)
    }

    /// The verdict on the controller that holds the push; `None` without one.
    ///
    /// # Errors
    /// Bad parameters.
    pub fn drive_verdict(&self) -> Result<Option<DriveVerdict>, Failure> {
        let push = self.rendering.specimen.force(Pascals(self.stress_pa));
        let samples = self.check()?;
        self.rendering.drive_verdict(RigDrive::Force(push), samples)
    }

    /// Judges a run; the CSV goes beside its log.
    pub(crate) fn report(&self, ran: &Ran) -> Result<(Report, Option<TheoryCurves>), Failure> {
        let judge = self.judge(ran)?;
        let title = format!("Creep of {}", self.rendering.material.description);
        let remark = format!("{} Pa from t = 0", self.stress_pa);
        let comparison = Comparison {
            quantity: Quantity::Strain,
            drive: RigDrive::Force(self.rendering.specimen.force(Pascals(self.stress_pa))),
            from_s: FROM_S,
            title: &title,
            remark: &remark,
        };
        publish(comparison, &self.rendering, ran, judge)
    }

    /// The number of samples, if all parameters are good.
    ///
    /// # Errors
    /// A stress, duration or sample time outside its range.
    pub fn check(&self) -> Result<u64, Failure> {
        if !(self.stress_pa > 0.0 && self.stress_pa <= 1e9) {
            return Err(Failure::bad_input(format_args!(
                "stress {} Pa is not in (0, 1e9] Pa: give {STRESS}, as in 100",
                Shown(self.stress_pa)
            )));
        }
        self.rendering.samples(self.duration_s)
    }

    /// Judges sample by sample.
    fn judge<'a>(
        &'a self,
        ran: &Ran,
    ) -> Result<impl FnMut(&KeptSample) -> TheorySample + 'a, Failure> {
        let Rendering {
            material, specimen, ..
        } = &self.rendering;
        let samples = Samples::of(&ran.record, &ran.log.paths);
        let mut history = self.rendering.full_history(samples, self.duration_s)?;
        let mut ideal = ReferenceSeries::new(
            samples,
            |x| {
                let mut strain = self.without_rig(x.len() as u64)?;
                Ok(x.iter().map(|_| strain()).collect())
            },
            || {
                let mut strain = self.without_rig(self.rendering.samples(self.duration_s)?)?;
                Ok(Box::new(move |_, _| strain()))
            },
        )?;
        let t = Seconds(self.rendering.sample_time_s);
        let mut strain = material.creep(self.stress_pa, t);
        Ok(move |sample: &KeptSample| {
            let closed_form = strain(sample.tick, sample.time_s);
            let value = specimen.strain(Metres(sample.position_m));
            TheorySample {
                ideal_position_m: specimen.displacement(closed_form).0,
                full_history_force_n: history.at(sample),
                value,
                closed_form,
                ideal: ideal.at(sample),
                with_rig: value,
            }
        })
    }

    /// Strain of the sampled tissue alone, without mass or damping of a rig: at each tick the strain
    /// whose stress is σ₀. The push acts from the first sample on, so the strain is never zero.
    ///
    /// ```text
    /// σ₀ = g·ε[n] + S[n]    ⇒    ε[n] = (σ₀ − S[n])/g
    /// ```
    fn without_rig(&self, samples: u64) -> Result<impl FnMut() -> f64 + use<>, Failure> {
        let Rendering { material, .. } = &self.rendering;
        let t = Seconds(self.rendering.sample_time_s);
        let reference = self.rendering.reference_kernel();
        // A piece of 1 m² and 1 m: stress for force, strain for depth.
        let mut tissue = material.sampled(1.0, reference, t, samples)?;
        let gain = tissue.gain();
        let stress_pa = self.stress_pa;
        Ok(move || {
            // The stress for a strain of zero is the past alone.
            let strain = (stress_pa - tissue.force(0.0)) / gain;
            tissue.advance(strain);
            strain
        })
    }

    /// Everything needed to repeat the run.
    fn metadata(&self, drive: RigDrive) -> BTreeMap<String, String> {
        let mut metadata = self.rendering.metadata("creep", drive);
        let mut add = |key: &str, value: String| metadata.insert(key.to_owned(), value);
        add("stress_pa", self.stress_pa.to_string());
        add("duration_s", self.duration_s.to_string());
        metadata
    }
}
