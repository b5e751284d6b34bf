//! From a run and its theory to files and a report: what relaxation and creep share.

use super::judge::{largest_error, relative_error};
use super::rendering::Rendering;
use super::report::{Files, Report, RunReport, Warnings};
use super::run::{Ran, Record};
use crate::failure::Failure;
use crate::figure::{Conditions, Quantity, TheoryFigure};

/// The comparison with the full history begins here, s after contact.
const FROM_S: f64 = 0.01;

/// A run beside what theory says of it, sample by sample.
#[derive(Debug)]
pub struct Outcome {
    /// What is compared.
    pub quantity: Quantity,
    /// Where the renderer would be with an ideal rig, m.
    pub ideal_position_m: Vec<f64>,
    /// Force by the full history of the position really recorded, N.
    pub full_history_force_n: Vec<f64>,
    /// The quantity as measured.
    pub measured: Vec<f64>,
    /// The quantity in closed form.
    pub theory: Vec<f64>,
    /// See [`Report`].
    pub closed_form_error: Option<f64>,
    /// See [`Report`].
    pub discretisation_error: Option<f64>,
    /// See [`Report`].
    pub rig_error: Option<f64>,
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

/// Force that the tissue opposes to an indentation, N: the negative of what is commanded.
pub fn reaction(record: &Record) -> Vec<f64> {
    // Not a negation, which would make −0 of 0.
    record.force_n.iter().map(|force| 0.0 - force).collect()
}

/// In per cent, without the digits that binary fractions add.
pub fn percent(fraction: f64) -> f64 {
    (fraction * 1e8).round() / 1e6
}

impl Outcome {
    /// |measured/theory − 1|, sample by sample.
    pub fn error(&self) -> Vec<f64> {
        let pairs = self.measured.iter().zip(&self.theory);
        pairs
            .map(|(&have, &want)| relative_error(have, want))
            .collect()
    }

    /// Writes CSV and picture, and reports. A run that was cut short leaves its log alone. `title` and
    /// `remark` are what the picture says of the experiment.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn publish(
        &self,
        rendering: &Rendering,
        ran: &Ran,
        title: &str,
        remark: &str,
    ) -> Result<Report, Failure> {
        let Ran { record, folder, .. } = ran;
        let time = &record.time_s;
        let force = reaction(record);
        let last = self.measured.last().zip(self.theory.last());
        let final_over_theory = last
            .map(|(have, want)| have / want)
            .filter(|r| r.is_finite());
        let duration_s = time.last().copied().unwrap_or(0.0);
        let memory_s = rendering.memory_s();

        let mut warnings = Warnings::default();
        warnings.operator(
            memory_s,
            duration_s,
            final_over_theory,
            self.quantity.word(),
        );
        warnings.limited(record.limited);

        let mut files = Files::default();
        if record.ended.is_none() {
            let error = self.error();
            let rows = (0..force.len()).map(|n| Row {
                time_s: time[n],
                ideal_position_m: self.ideal_position_m[n],
                position_m: record.position_m[n],
                reaction_force_n: force[n],
                full_history_force_n: self.full_history_force_n[n],
                measured: self.measured[n],
                theory: self.theory[n],
                relative_error: error[n],
            });
            files.csv = Some(folder.write_table("csv", rows)?);
            let picture = TheoryFigure {
                title,
                conditions: Conditions {
                    tissue: &rendering.material.name,
                    order: rendering.material.order,
                    scheme: &rendering.scheme.to_string(),
                    remark,
                },
                quantity: self.quantity,
                time_s: time,
                measured: &self.measured,
                theory: &self.theory,
                relative_error: &error,
            };
            files.figure = Some(folder.save_picture(&picture.draw()?)?);
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
            max_relative_error: largest_error(time, &force, &self.full_history_force_n, FROM_S),
            closed_form_error: self.closed_form_error,
            discretisation_error: self.discretisation_error,
            rig_error: self.rig_error,
            memory_s,
            final_over_theory,
            final_strain: (self.quantity == Quantity::Strain)
                .then(|| self.measured.last().copied())
                .flatten(),
            precision: rendering.precision_run(),
            contact: rendering.contact,
        })
    }
}
