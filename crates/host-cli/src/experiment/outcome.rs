//! From a run and its theory to files and a report: what relaxation and creep share.

use super::judge::{LargestError, relative_error};
use super::kept::{Sample, Samples, WHOLE_MOST};
use super::rendering::Rendering;
use super::report::{Files, Report, RunReport, Warnings};
use super::run::Ran;
use super::thinned::Thinned;
use super::track::TOLERANCE;
use crate::failure::Failure;
use crate::figure::{Conditions, FigureError, Picture, Quantity, TheoryFigure};

/// The comparison with the full history begins here, s after contact.
pub(super) const FROM_S: f64 = 0.01;

/// A sample beside what theory says of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judged {
    /// Where the renderer would be with an ideal rig, m.
    pub(super) ideal_position_m: f64,
    /// Force by the full history of the position really recorded, N.
    pub(super) full_history_force_n: f64,
    /// The quantity as measured.
    pub(super) measured: f64,
    /// The quantity in closed form.
    pub(super) theory: f64,
    /// The quantity sampled, by its full history, without a rig.
    pub(super) ideal: f64,
    /// The same with the rig.
    pub(super) with_rig: f64,
}

/// What is compared, and from when on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Comparison<'a> {
    /// The quantity.
    pub(super) quantity: Quantity,
    /// The comparison with the closed form begins here, s.
    pub(super) from_s: f64,
    /// What the picture says of the experiment.
    pub(super) title: &'a str,
    /// The same, below the title.
    pub(super) remark: &'a str,
}

/// A row of the CSV.
#[derive(serde::Serialize)]
struct Row {
    time_s: f64,
    ideal_position_m: f64,
    position_m: f64,
    reaction_force_n: f64,
    full_history_force_n: f64,
    measured: f64,
    theory: f64,
    relative_error: f64,
}

/// In per cent, without the digits that binary fractions add.
pub fn percent(fraction: f64) -> f64 {
    (fraction * 1e8).round() / 1e6
}

/// The errors of a run, sample by sample.
struct Errors {
    full_history: LargestError,
    closed_form: LargestError,
    discretisation: LargestError,
    rig: LargestError,
}

impl Errors {
    const fn new(from_s: f64) -> Self {
        Self {
            full_history: LargestError::new(FROM_S),
            closed_form: LargestError::new(from_s),
            discretisation: LargestError::new(from_s),
            rig: LargestError::new(from_s),
        }
    }

    fn add(&mut self, sample: &Sample, judged: &Judged) {
        let time_s = sample.time_s;
        let pairs = [
            (
                &mut self.full_history,
                sample.reaction_n(),
                judged.full_history_force_n,
            ),
            (&mut self.closed_form, judged.measured, judged.theory),
            (&mut self.discretisation, judged.ideal, judged.theory),
            (&mut self.rig, judged.with_rig, judged.ideal),
        ];
        for (largest, have, want) in pairs {
            largest.add(time_s, have, want);
        }
    }
}

/// Judges every sample, writes CSV and picture, and reports. A run that was cut short leaves its log alone.
///
/// # Errors
/// A log that cannot be read again, a file that cannot be written.
pub(super) fn publish(
    comparison: Comparison<'_>,
    rendering: &Rendering,
    ran: &Ran,
    mut judge: impl FnMut(&Sample) -> Judged,
) -> Result<Report, Failure> {
    let Comparison {
        quantity, from_s, ..
    } = comparison;
    let Ran { record, folder, .. } = ran;
    let mut errors = Errors::new(from_s);
    let whole = record.whole.is_some();
    let mut curves = Thinned::new(if whole { WHOLE_MOST } else { 0 });
    let finished = record.ended.is_none();
    let mut table = match finished {
        true => Some(folder.table("csv")?),
        false => None,
    };
    let mut last = None;
    Samples::of(record, &ran.log.paths).for_each(|sample| {
        let judged = judge(sample);
        errors.add(sample, &judged);
        last = Some(judged);
        let Some(table) = &mut table else {
            return Ok(());
        };
        let Judged {
            measured, theory, ..
        } = judged;
        let relative_error = relative_error(measured, theory);
        curves.add(sample.time_s, [measured, theory, relative_error]);
        table.row(&Row {
            time_s: sample.time_s,
            ideal_position_m: judged.ideal_position_m,
            position_m: sample.position_m,
            reaction_force_n: sample.reaction_n(),
            full_history_force_n: judged.full_history_force_n,
            measured,
            theory,
            relative_error,
        })
    })?;
    curves.finish();

    let final_over_theory = last
        .map(|last| last.measured / last.theory)
        .filter(|ratio| ratio.is_finite());
    let memory_s = rendering.memory_s();
    let mut warnings = Warnings::default();
    warnings.operator(
        memory_s,
        record.duration_s(),
        final_over_theory,
        quantity.word(),
    );
    warnings.limited(record.limited);

    let mut files = Files::default();
    if let Some(table) = table {
        files.csv = Some(table.finish()?);
        let picture = draw(comparison, rendering, &curves)?;
        files.figure = Some(folder.save_picture(&picture)?);
    } else {
        folder.remove_stale_results();
    }
    Ok(Report {
        tissue: rendering.material.name.clone(),
        order: rendering.material.order,
        scheme: rendering.scheme.to_string(),
        run: RunReport::new(
            ran,
            rendering.device_name(),
            rendering.sample_time_s,
            files,
            warnings,
        ),
        max_relative_error: errors.full_history.get(),
        closed_form_error: errors.closed_form.get(),
        discretisation_error: errors.discretisation.get(),
        rig_error: errors.rig.get(),
        reference_tolerance: (!whole).then_some(TOLERANCE),
        memory_s,
        final_over_theory,
        final_strain: (quantity == Quantity::Strain)
            .then(|| last.map(|last| last.measured))
            .flatten(),
        precision: rendering.precision_run(),
        contact: rendering.contact,
    })
}

fn draw(
    comparison: Comparison<'_>,
    rendering: &Rendering,
    curves: &Thinned<3>,
) -> Result<Picture, FigureError> {
    let [measured, theory, relative_error] = &curves.curves;
    TheoryFigure {
        title: comparison.title,
        conditions: Conditions {
            tissue: &rendering.material.name,
            order: rendering.material.order,
            scheme: &rendering.scheme.to_string(),
            remark: comparison.remark,
        },
        quantity: comparison.quantity,
        time_s: &curves.time_s,
        measured,
        theory,
        relative_error,
    }
    .draw()
}
