//! From a run and its theory to files and a report: what relaxation and creep share.

use super::Rendering;
use super::report::{Quantity, Report, TheoryCurves};
use crate::document::failure::Failure;
use crate::experiment::drive::{DriveJudge, DriveReport, drive_columns};
use crate::judge::curves::Origin;
use crate::judge::decimated::Decimated;
use crate::judge::reference::TOLERANCE;
use crate::judge::report::{Errors, Files, RunReport};
use crate::judge::warnings::Warnings;
use crate::judge::{LargestError, relative_error};
use crate::run::Ran;
use crate::run::folder::Table;
use crate::run::record::Record;
use crate::run::samples::Samples;
use crate::run::tick::KeptSample;
use haptic_loop::plant::RigDrive;

/// The comparison with the full history begins here, s after contact.
pub(crate) const FROM_S: f64 = 0.01;

/// A sample beside what theory says of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TheorySample {
    /// Place of the renderer with an ideal rig, m.
    pub(crate) ideal_position_m: f64,
    /// Force by the full history of the position really recorded, N.
    pub(crate) full_history_force_n: f64,
    /// The quantity as it was rendered or simulated.
    pub(crate) value: f64,
    /// The quantity in closed form.
    pub(crate) closed_form: f64,
    /// The quantity sampled, by its full history, without a rig.
    pub(crate) ideal: f64,
    /// The same with the rig.
    pub(crate) with_rig: f64,
}

impl TheorySample {
    /// The value over its closed form, where that has a meaning.
    fn over_theory(self) -> Option<f64> {
        Some(self.value / self.closed_form).filter(|ratio| ratio.is_finite())
    }
}

/// Quantity to compare, and from when on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Comparison<'a> {
    /// The quantity.
    pub(crate) quantity: Quantity,
    /// Drive of the rig.
    pub(crate) drive: RigDrive,
    /// The comparison with the closed form begins here, s.
    pub(crate) from_s: f64,
    /// Text of the picture about the experiment.
    pub(crate) title: &'a str,
    /// The same, below the title.
    pub(crate) remark: &'a str,
}

/// The errors of a run, sample by sample.
struct Compared {
    full_history: LargestError,
    closed_form: LargestError,
    discretisation: LargestError,
    rig: LargestError,
}

impl Compared {
    const fn new(quantity: Quantity, from_s: f64) -> Self {
        let (unit, ideal) = match quantity {
            Quantity::Force => (" N", "the force with an ideal rig"),
            Quantity::Strain => ("", "the strain without a rig"),
        };
        Self {
            full_history: LargestError::new(FROM_S, "the force by the full history", " N"),
            closed_form: LargestError::new(from_s, "the closed form", unit),
            discretisation: LargestError::new(from_s, "the closed form", unit),
            rig: LargestError::new(from_s, ideal, unit),
        }
    }

    fn add(&mut self, sample: &KeptSample, judged: &TheorySample) {
        let time_s = sample.time_s;
        if !sample.is_comparable() {
            for largest in [
                &mut self.full_history,
                &mut self.closed_form,
                &mut self.discretisation,
                &mut self.rig,
            ] {
                largest.pass(time_s);
            }
            return;
        }
        let pairs = [
            (
                &mut self.full_history,
                sample.reaction_n(),
                judged.full_history_force_n,
            ),
            (&mut self.closed_form, judged.value, judged.closed_form),
            (&mut self.discretisation, judged.ideal, judged.closed_form),
            (&mut self.rig, judged.with_rig, judged.ideal),
        ];
        for (largest, have, want) in pairs {
            largest.add(time_s, have, want);
        }
    }
}

/// Begins the CSV, under names that say where the force comes from.
fn table(ran: &Ran, quantity: Quantity, drive: Option<RigDrive>) -> Table {
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
    match quantity {
        Quantity::Strain => names.extend([&own_strain, "closed_form_strain"]),
        Quantity::Force => names.push("closed_form_force_n"),
    }
    names.push("closed_form_error");
    names.extend(drive.iter().flatten());
    ran.folder.named_table_beside_log("csv", &names)
}

/// A row of it. A sample without a relative error has an empty cell.
fn row(
    quantity: Quantity,
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
    if quantity == Quantity::Strain {
        row.push(Some(judged.value));
    }
    row.push(Some(judged.closed_form));
    row.push(Some(error).filter(|error| error.is_finite()));
    row
}

/// Results of judging a run.
struct Seen {
    compared: Compared,
    curves: Decimated<3>,
    drive: Option<DriveJudge>,
    last: Option<TheorySample>,
    /// The table; none of a run that was cut short.
    files: Files,
}

/// Judges every sample, and writes the table of a run that reached its end.
fn see(
    comparison: Comparison<'_>,
    rendering: &Rendering,
    ran: &Ran,
    mut judge: impl FnMut(&KeptSample) -> TheorySample,
) -> Result<Seen, Failure> {
    let Comparison {
        quantity,
        drive: own,
        from_s,
        ..
    } = comparison;
    let record = &ran.record;
    let mut compared = Compared::new(quantity, from_s);
    let mut curves = Decimated::of(record);
    let mut drive = rendering.drive_judge(own, record)?;
    let whole = record.ended.is_none();
    let mut csv = whole.then(|| table(ran, quantity, drive.is_some().then_some(own)));
    let mut last = None;
    Samples::of(record, &ran.log.paths).for_each(|sample| {
        let judged = judge(sample);
        compared.add(sample, &judged);
        last = Some(judged);
        let driven = drive.as_mut().map(|drive| drive.add(sample));
        let Some(csv) = &mut csv else {
            return Ok(());
        };
        let (value, closed_form) = (judged.value, judged.closed_form);
        let error = relative_error(value, closed_form);
        curves.add(sample.time_s, [value, closed_form, error]);
        let mut row = row(quantity, sample, &judged, error);
        row.extend(driven.iter().flatten().copied().map(Some));
        csv.row(row);
        Ok(())
    })?;
    curves.finish();
    Ok(Seen {
        compared,
        curves,
        drive,
        last,
        files: Files::of_run(ran, csv),
    })
}

/// Judges a run and reports. A run that was cut short leaves its log alone.
///
/// # Errors
/// A log that cannot be read again, a file that cannot be written.
pub(crate) fn publish(
    comparison: Comparison<'_>,
    rendering: &Rendering,
    ran: &Ran,
    judge: impl FnMut(&KeptSample) -> TheorySample,
) -> Result<(Report, Option<TheoryCurves>), Failure> {
    let quantity = comparison.quantity;
    let record = &ran.record;
    let Seen {
        compared,
        curves,
        drive,
        last,
        files,
    } = see(comparison, rendering, ran, judge)?;
    let final_over_theory = last.and_then(TheorySample::over_theory);
    let strain = last.filter(|_| quantity == Quantity::Strain);
    let (drive, drive_curves) = drive.map(DriveJudge::finish).unzip();
    let warnings = warned(
        rendering,
        record,
        final_over_theory,
        quantity,
        drive.as_ref(),
    );
    let curves = record.ended.is_none().then(|| TheoryCurves {
        drive: drive_curves,
        ..drawn(comparison, rendering, Origin::of(record), curves)
    });
    let report = Report {
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
        errors: Errors::new(compared.full_history.get(), compared.closed_form.get()),
        discretisation_error: compared.discretisation.get().largest,
        rig_error: compared.rig.get().largest,
        reference_tolerance: record.whole.is_none().then_some(TOLERANCE),
        memory_s: rendering.memory_s(),
        final_over_theory,
        final_strain: strain.map(|last| last.value),
        precision: rendering.precision_run(),
        contact: rendering.contact,
        drive,
    };
    Ok((report, curves))
}

/// What a user should know of these numbers.
fn warned(
    rendering: &Rendering,
    record: &Record,
    over_theory: Option<f64>,
    quantity: Quantity,
    drive: Option<&DriveReport>,
) -> Warnings {
    let mut warnings = Warnings::default();
    let (memory_s, word) = (rendering.memory_s(), quantity.word());
    warnings.operator(memory_s, record.duration_s(), over_theory, word);
    warnings.limited(record);
    if let Some(drive) = drive {
        warnings.0.extend(drive.warnings());
    }
    warnings
}

fn drawn(
    comparison: Comparison<'_>,
    rendering: &Rendering,
    origin: Origin,
    curves: Decimated<3>,
) -> TheoryCurves {
    let [values, closed_form, relative_error] = curves.curves;
    TheoryCurves {
        title: format!("{}, {}", comparison.title, origin.word()),
        tissue: rendering.material.name.clone(),
        order: rendering.material.order().get(),
        device: rendering.device_name(),
        scheme: rendering.scheme.to_string(),
        remark: comparison.remark.to_owned(),
        quantity: comparison.quantity,
        origin,
        time_s: curves.time_s,
        values,
        closed_form,
        relative_error,
        drive: None,
    }
}
