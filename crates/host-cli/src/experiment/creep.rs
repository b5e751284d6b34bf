//! Creep: push with a constant force, record the strain.
//!
//! The indenter pushes the renderer with σ₀·A from t = 0; the renderer opposes it with the force of
//! the virtual tissue, and both sink in. The closed form is that of the tissue alone; the masses and
//! the damping of the rig, 7 N·s/m together, slow the start down.

use super::judge::{LargestError, creep_strain};
use super::outcome::Outcome;
use super::rendering::Rendering;
use super::report::Report;
use super::run::{Record, Supervisor};
use crate::failure::Failure;
use crate::figure::Quantity;
use crate::folder::FolderRequest;
use fracdiff::{Channel, Differintegrator as _, Operator, Scheme, Seconds};
use haptic_loop::plant::RigDrive;
use haptic_loop::units::{Metres, Pascals};
use std::collections::BTreeMap;

/// The comparison with the closed form begins here, s: before, the rig itself is moving.
const FROM_S: f64 = 1.0;
/// Tolerance of the operator that stands for the full history where an equation must be solved.
const REFERENCE_TOLERANCE: f64 = 1e-9;

/// A creep experiment.
#[derive(Clone, Debug)]
pub struct Creep {
    /// What is rendered, and how.
    pub rendering: Rendering,
    /// σ₀, Pa, above 0.
    pub stress_pa: f64,
    /// How long, s.
    pub duration_s: f64,
}

impl Creep {
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
        let push = self.rendering.specimen.force(Pascals(self.stress_pa));
        let ran = self.rendering.run(
            RigDrive::Force(push),
            samples,
            request,
            self.metadata(RigDrive::Force(push)),
            supervisor,
        )?;
        let outcome = self.judge(&ran.record)?;
        let title = format!("Creep of {}", self.rendering.material.description);
        let remark = format!("{} Pa from t = 0", self.stress_pa);
        outcome.publish(&self.rendering, &ran, &title, &remark)
    }

    /// The number of samples, if all parameters are good.
    ///
    /// # Errors
    /// A stress, duration or sample time outside its range.
    pub fn check(&self) -> Result<u64, Failure> {
        if !(self.stress_pa > 0.0 && self.stress_pa <= 1e9) {
            return Err(Failure::bad_input(format_args!(
                "stress {} Pa is not in (0, 1e9] Pa: give --stress, as in 100Pa",
                self.stress_pa
            )));
        }
        self.rendering.samples(self.duration_s)
    }

    fn judge(&self, record: &Record) -> Result<Outcome, Failure> {
        let Rendering {
            material, specimen, ..
        } = &self.rendering;
        let time = &record.time_s;
        let strain_at = |x: &f64| specimen.strain(Metres(*x));
        let strain: Vec<f64> = record.position_m.iter().map(strain_at).collect();
        let closed_form: Vec<f64> = (time.iter())
            .map(|&t| creep_strain(&material.tissue, self.stress_pa, t))
            .collect();
        let ideal = record.of_every_tick(|x| self.without_rig(x.len()))?;
        let history = record
            .of_every_tick(|x| self.rendering.full_history_force(x))
            .map_err(Failure::Run)?;
        let compare = |have: &[f64], want: &[f64], wanted| {
            LargestError::new(FROM_S, wanted, "").of(time, have, want)
        };
        Ok(Outcome {
            quantity: Quantity::Strain,
            ideal_position_m: (closed_form.iter())
                .map(|&strain| specimen.displacement(strain).0)
                .collect(),
            full_history_force_n: history,
            closed_form_error: compare(&strain, &closed_form, "the closed form"),
            discretisation_error: compare(&ideal, &closed_form, "the closed form").largest,
            rig_error: compare(&strain, &ideal, "the strain without a rig").largest,
            values: strain,
            closed_form,
        })
    }

    /// Strain of the sampled tissue alone, without mass or damping of a rig: at each tick the strain
    /// whose stress is σ₀. The push acts from the first sample on, so the strain is never zero.
    ///
    /// ```text
    /// σ₀ = E₀·ε[n] + η·(g·ε[n] + S[n])    ⇒    ε[n] = (σ₀ − η·S[n])/(E₀ + η·g)
    /// ```
    fn without_rig(&self, samples: usize) -> Result<Vec<f64>, Failure> {
        let tissue = &self.rendering.material.tissue;
        let scheme = Scheme::Full {
            kernel: self.rendering.reference_kernel(),
            tolerance: REFERENCE_TOLERANCE,
        };
        let t = Seconds(self.rendering.sample_time_s);
        let operator: Operator<f64> = scheme
            .build(tissue.order(), t, 1.05 * samples as f64)
            .map_err(Failure::input)?;
        let (modulus, viscosity) = (tissue.elastic_modulus().0, tissue.viscosity_pa_s_alpha());
        let stiffness = modulus + viscosity * operator.direct_gain();
        let mut channel = Channel::new(operator);
        let strains = (0..samples).map(|_| {
            // The output for a strain of zero is the past alone.
            let strain = (self.stress_pa - viscosity * channel.output(0.0)) / stiffness;
            channel.advance(strain);
            strain
        });
        Ok(strains.collect())
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
