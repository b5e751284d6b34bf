//! From the run of an indentation and its theory to files, a report and curves.

use super::{Indentation, Load};
use crate::Supervisor;
use crate::document::failure::Failure;
use crate::experiment::drive::{DriveJudge, DriveReport, drive_columns};
use crate::experiment::rendering::{Contact, Precision, Rendering};
use crate::judge::decimated::Decimated;
use crate::judge::reference::{ReferenceSeries, TOLERANCE};
use crate::judge::report::{Errors, Files, RunReport};
use crate::judge::warnings::Warnings;
use crate::judge::{Curves, LargestError, Origin, Published, percent, relative_error};
use crate::run::Ran;
use crate::run::folder::{FolderRequest, Table};
use crate::run::samples::Samples;
use crate::run::tick::KeptSample;
use fracdiff::Seconds;
use haptic_loop::plant::RigDrive;
use haptic_loop::units::{Metres, Pascals};
use serde::Serialize;

/// The comparison with the full history begins here, s after contact.
const FROM_S: f64 = 0.01;
/// That of a relaxation with the closed form begins this long after the end of the ramp, s.
const AFTER_RAMP_S: f64 = 0.1;
/// That of creep begins here, s: before, the rig itself is moving.
const CREEP_FROM_S: f64 = 1.0;

/// The result of a relaxation or creep test.
#[derive(Clone, Debug, Serialize)]
pub struct IndentationReport {
    /// Name of the tissue.
    pub tissue: String,
    /// α of the tissue.
    pub order: f64,
    /// Operator.
    pub scheme: String,
    /// Number type of the loop.
    pub precision: Precision,
    /// Contact between indenter and renderer.
    pub(crate) contact: Contact,
    /// Memory of the operator, s; null for everything.
    pub memory_s: Option<f64>,
    /// Of the run.
    #[serde(flatten)]
    pub run: RunReport,
    /// The two errors, each with the samples that it is of.
    #[serde(flatten)]
    pub(crate) errors: Errors,
    /// Relative tolerance of the weights that stand for the full history in a run of more than 10⁶ samples; null
    /// for exact sums.
    pub reference_tolerance: Option<f64>,
    /// Part of `closed_form_error` that is left with an ideal indenter and the full history, over the same samples:
    /// the sampling.
    pub discretisation_error: Option<f64>,
    /// Part of `closed_form_error` that comes from contact, servo, masses and sensors of the rig.
    pub rig_error: Option<f64>,
    /// Final value over its closed form: force in a relaxation, strain in a creep test.
    pub final_over_theory: Option<f64>,
    /// Final strain, in a creep test.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub final_strain: Option<f64>,
    /// Work of the controller that held the indenter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) drive: Option<DriveReport>,
}

/// A sample beside what theory says of it.
#[derive(Clone, Copy, Debug)]
struct TheorySample {
    /// Place of the renderer with an ideal rig, m.
    ideal_position_m: f64,
    /// Force by the full history of the position really recorded, N.
    full_history_force_n: f64,
    /// The quantity as it was rendered or simulated.
    value: f64,
    /// The quantity in closed form.
    closed_form: f64,
    /// The quantity sampled, by its full history, without a rig.
    ideal: f64,
    /// The same with the rig.
    with_rig: f64,
}

/// Says of each sample what theory says.
type Theory<'a> = Box<dyn FnMut(&KeptSample) -> TheorySample + 'a>;

impl Indentation {
    /// Runs the experiment; log and CSV go into the folder.
    pub(crate) fn run(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Published<IndentationReport>, Failure> {
        let ran = self.record(request, supervisor)?;
        let reported = self.report(&ran)?;
        Ok(Published::new(reported, ran.folder))
    }

    /// Judges a run; the table of one that reached its end goes beside its log. A run that was cut short leaves its log alone.
    pub(crate) fn report(&self, ran: &Ran) -> Result<(IndentationReport, Option<Curves>), Failure> {
        let (rendering, record, own) = (&self.rendering, &ran.record, self.drive()?);
        let is_strain = matches!(self.load, Load::Stress { .. });
        let (from_s, unit, without_rig) = match self.load {
            Load::Strain { ramp_time_s, .. } => {
                let from_s = ramp_time_s + AFTER_RAMP_S;
                (from_s, " N", "the force with an ideal rig")
            }
            Load::Stress { .. } => (CREEP_FROM_S, "", "the strain without a rig"),
        };
        let mut theory = match self.load {
            Load::Strain { .. } => self.relaxed(ran)?,
            Load::Stress { stress_pa } => self.crept(ran, stress_pa)?,
        };
        let mut errors = [
            LargestError::new(FROM_S, "the force by the full history", " N"),
            LargestError::new(from_s, "the closed form", unit),
            LargestError::new(from_s, "the closed form", unit),
            LargestError::new(from_s, without_rig, unit),
        ];
        let mut curves = Decimated::of(record);
        let verdict = self.drive_verdict(record.samples)?;
        let drive = (rendering.drive.as_ref().zip(verdict))
            .map(|(drive, verdict)| DriveJudge::new(drive, own, rendering.sample_time_s, verdict));
        let mut drive = drive.transpose()?;
        let whole = record.ended.is_none();
        let mut csv = whole.then(|| table(ran, is_strain, drive.is_some().then_some(own)));
        let mut last = None;
        Samples::of(record, &ran.log.paths).for_each(|sample| {
            let judged = theory(sample);
            let (value, closed_form) = (judged.value, judged.closed_form);
            let pairs = [
                (sample.reaction_n(), judged.full_history_force_n),
                (value, closed_form),
                (judged.ideal, closed_form),
                (judged.with_rig, judged.ideal),
            ];
            for (largest, (have, want)) in errors.iter_mut().zip(pairs) {
                match sample.is_comparable() {
                    true => largest.add(sample.time_s, have, want),
                    false => largest.pass(sample.time_s),
                }
            }
            last = Some(judged);
            let driven = drive.as_mut().map(|drive| drive.add(sample));
            let Some(csv) = &mut csv else {
                return Ok(());
            };
            let error = relative_error(value, closed_form);
            let (tracking_error, [_, force_n]) = driven.unwrap_or_default();
            let values = [value, closed_form, error, tracking_error, force_n];
            curves.add(sample.time_s, values);
            let mut row = row(is_strain, sample, &judged, error);
            row.extend(
                driven
                    .iter()
                    .flat_map(|(_, columns)| columns)
                    .copied()
                    .map(Some),
            );
            csv.row(row);
            Ok(())
        })?;
        let files = Files::of_run(ran, csv);
        let final_over_theory = (last.map(|last| last.value / last.closed_form))
            .filter(|ratio: &f64| ratio.is_finite());
        let drive = drive.map(DriveJudge::finish);
        let mut warnings = Warnings::default();
        let memory_s = rendering.memory_s();
        warnings.operator(
            memory_s,
            record.duration_s(),
            final_over_theory,
            if is_strain { "strain" } else { "force" },
        );
        warnings.limited(record);
        warnings
            .0
            .extend(drive.iter().flat_map(DriveReport::warnings));
        let [full_history, closed_form, discretisation, rig] = errors.map(LargestError::get);
        let report = IndentationReport {
            tissue: rendering.material.name.clone(),
            order: rendering.material.order().get(),
            scheme: rendering.scheme.to_string(),
            run: RunReport::new(
                ran,
                rendering.device_name(),
                rendering.sample_time_s,
                files,
                warnings,
            ),
            errors: Errors {
                full_history,
                closed_form,
            },
            discretisation_error: discretisation.largest,
            rig_error: rig.largest,
            reference_tolerance: record.whole.is_none().then_some(TOLERANCE),
            memory_s,
            final_over_theory,
            final_strain: last.filter(|_| is_strain).map(|last| last.value),
            precision: rendering.precision_run(),
            contact: rendering.contact,
            drive,
        };
        let held = report
            .drive
            .as_ref()
            .map(|_| ["tracking_error", "drive_force_n"]);
        let [tracking_error, force_n] = held.unwrap_or_default();
        let names = [
            "values",
            "closed_form",
            "relative_error",
            tracking_error,
            force_n,
        ];
        let (what, remark) = match self.load {
            Load::Strain {
                strain,
                ramp_time_s,
            } => {
                let (percent, until) = (percent(strain), self.duration_s);
                let remark = format!("{percent} % strain in {ramp_time_s} s, held until {until} s");
                ("Stress relaxation", remark)
            }
            Load::Stress { stress_pa } => ("Creep", format!("{stress_pa} Pa from t = 0")),
        };
        let (tissue, origin) = (&rendering.material.description, Origin::of(record));
        let title = format!("{what} of {tissue}, {}", origin.word());
        let curves = whole.then(|| curves.named(names, origin, title, remark));
        Ok((report, curves))
    }

    /// Closed form of the force of a relaxation, N; zero for creep, which has one of the strain.
    #[must_use]
    pub fn closed_form(&self, time_s: f64) -> f64 {
        let Rendering {
            material, specimen, ..
        } = &self.rendering;
        match self.load {
            Load::Strain {
                strain,
                ramp_time_s,
            } => {
                let stress = material.relaxation_stress(strain, ramp_time_s, time_s);
                specimen.force(Pascals(stress)).0
            }
            Load::Stress { .. } => 0.0,
        }
    }

    /// Each sample of a relaxation.
    fn relaxed(&self, ran: &Ran) -> Result<Theory<'_>, Failure> {
        let (
            RigDrive::Position(profile),
            Load::Strain {
                strain,
                ramp_time_s,
            },
        ) = (self.drive()?, self.load)
        else {
            return Err(Failure::bad_input("a push is not a relaxation"));
        };
        let rendering = &self.rendering;
        let samples = Samples::of(&ran.record, &ran.log.paths);
        let mut history = self.full_history(samples)?;
        let t = rendering.sample_time_s;
        let mut ideal = ReferenceSeries::new(
            samples,
            |x| {
                let time = (0..x.len()).map(|n| n as f64 * t);
                let imposed: Vec<f64> = time.map(|time| profile.position(time)).collect();
                self.full_history_force(&imposed).map_err(Failure::Run)
            },
            || {
                let mut force = self.full_history_step()?;
                Ok(Box::new(move |tick, _| {
                    force(profile.position(tick as f64 * t))
                }))
            },
        )?;
        let mut stress = rendering
            .material
            .relaxation(strain, ramp_time_s, Seconds(t));
        Ok(Box::new(move |sample| {
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
        }))
    }

    /// Each sample of creep.
    fn crept(&self, ran: &Ran, stress_pa: f64) -> Result<Theory<'_>, Failure> {
        let Rendering {
            material, specimen, ..
        } = &self.rendering;
        let samples = Samples::of(&ran.record, &ran.log.paths);
        let mut history = self.full_history(samples)?;
        let mut ideal = ReferenceSeries::new(
            samples,
            |x| {
                let mut strain = self.without_rig(stress_pa, x.len() as u64)?;
                Ok(x.iter().map(|_| strain()).collect())
            },
            || {
                let mut strain = self.without_rig(stress_pa, self.check()?)?;
                Ok(Box::new(move |_, _| strain()))
            },
        )?;
        let mut strain = material.creep(stress_pa, Seconds(self.rendering.sample_time_s));
        Ok(Box::new(move |sample| {
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
        }))
    }

    /// Strain of the sampled tissue alone, without mass or damping of a rig: at each tick the strain
    /// whose stress is σ₀. The push acts from the first sample on, so the strain is never zero.
    ///
    /// ```text
    /// σ₀ = g·ε[n] + S[n]    ⇒    ε[n] = (σ₀ − S[n])/g
    /// ```
    fn without_rig(
        &self,
        stress_pa: f64,
        samples: u64,
    ) -> Result<impl FnMut() -> f64 + use<>, Failure> {
        let t = Seconds(self.rendering.sample_time_s);
        let reference = self.rendering.reference_kernel();
        // A piece of 1 m² and 1 m: stress for force, strain for depth.
        let mut tissue = (self.rendering.material).sampled(1.0, reference, t, samples)?;
        let gain = tissue.gain();
        Ok(move || {
            // The stress for a strain of zero is the past alone.
            let strain = (stress_pa - tissue.force(0.0)) / gain;
            tissue.advance(strain);
            strain
        })
    }

    /// The force that the specimen opposes to an indentation, by the full history of it, N.
    ///
    /// ```text
    /// F = max(0, (A/ℓ)·(E₀·x + η·D^α x))        x ≥ 0
    /// ```
    fn full_history_force(&self, position_m: &[f64]) -> anyhow::Result<Vec<f64>> {
        // The virtual tissue begins at 0 and only pushes.
        let depth: Vec<f64> = position_m.iter().map(|x| x.max(0.0)).collect();
        let (shape, t) = (
            self.rendering.shape(),
            Seconds(self.rendering.sample_time_s),
        );
        let reference = self.rendering.reference_kernel();
        let forces = (self.rendering.material).full_history(shape, reference, t, &depth)?;
        Ok(depth
            .iter()
            .zip(forces)
            .map(|(&x, f)| pushes(x, f))
            .collect())
    }

    /// The same tick by tick, for a run too long to keep: from each position the force.
    fn full_history_step(&self) -> Result<impl FnMut(f64) -> f64 + use<>, Failure> {
        let rendering = &self.rendering;
        let (reference, t) = (
            rendering.reference_kernel(),
            Seconds(rendering.sample_time_s),
        );
        let samples = self.check()?;
        let mut tissue = (rendering.material).sampled(rendering.shape(), reference, t, samples)?;
        Ok(move |x: f64| {
            let depth = x.max(0.0);
            let force = tissue.force(depth);
            tissue.advance(depth);
            pushes(depth, force)
        })
    }

    fn full_history(&self, samples: Samples<'_>) -> Result<ReferenceSeries<'static>, Failure> {
        ReferenceSeries::new(
            samples,
            |x| self.full_history_force(x).map_err(Failure::Run),
            || {
                let mut force = self.full_history_step()?;
                Ok(Box::new(move |_, x| force(x)))
            },
        )
    }
}

/// The force of a tissue that only pushes, N, and only at a depth above 0, m.
fn pushes(depth: f64, force: f64) -> f64 {
    if depth > 0.0 { force.max(0.0) } else { 0.0 }
}

/// Begins the CSV, under names that say where the force comes from.
fn table(ran: &Ran, is_strain: bool, drive: Option<RigDrive>) -> Table {
    let word = Origin::of(&ran.record).word();
    let (own_force, own_strain) = (format!("{word}_force_n"), format!("{word}_strain"));
    let drive = drive.map(drive_columns);
    let mut names = vec![
        "time_s",
        "ideal_position_m",
        "position_m",
        &own_force,
        "full_history_force_n",
    ];
    match is_strain {
        true => names.extend([&own_strain, "closed_form_strain"]),
        false => names.push("closed_form_force_n"),
    }
    names.push("closed_form_error");
    names.extend(drive.iter().flatten());
    ran.folder.named_table_beside_log("csv", &names)
}

/// A row of it. A sample without a relative error has an empty cell.
fn row(
    is_strain: bool,
    sample: &KeptSample,
    judged: &TheorySample,
    error: f64,
) -> Vec<Option<f64>> {
    let mut row = vec![
        Some(sample.time_s),
        Some(judged.ideal_position_m),
        Some(sample.position_m),
        Some(sample.reaction_n()),
        Some(judged.full_history_force_n),
    ];
    // The force of a relaxation stands there already.
    if is_strain {
        row.push(Some(judged.value));
    }
    row.push(Some(judged.closed_form));
    row.push(Some(error).filter(|error| error.is_finite()));
    row
}
