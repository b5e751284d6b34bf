//! From a run and its theory to files and a report: what relaxation and creep share.

use super::judge::{Compared, LargestError, relative_error};
use super::rendering::Rendering;
use super::report::{Errors, Files, Report, RunReport, Warnings};
use super::run::{Ran, Record};
use crate::failure::Failure;
use crate::figure::{Conditions, Origin, Quantity, TheoryFigure};

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
    /// The quantity as it was rendered or simulated.
    pub values: Vec<f64>,
    /// The quantity in closed form.
    pub closed_form: Vec<f64>,
    /// The comparison of these two.
    pub closed_form_error: Compared,
    /// See [`Report`].
    pub discretisation_error: Option<f64>,
    /// See [`Report`].
    pub rig_error: Option<f64>,
}

/// Where the force of a run comes from: without a link, or with a device that simulates its plant, nothing
/// but a simulation.
#[must_use]
pub fn origin(record: &Record) -> Origin {
    Origin::of_device(record.link.as_ref().map(|link| link.simulated))
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
    /// |value/closed form − 1|, sample by sample; NaN where it has no meaning.
    pub fn error(&self) -> Vec<f64> {
        let pairs = self.values.iter().zip(&self.closed_form);
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
        let last = self.values.last().zip(self.closed_form.last());
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
            files.csv = Some(self.write_csv(ran, &force, &error)?);
            let origin = origin(record);
            let picture = TheoryFigure {
                title: &format!("{title}, {}", origin.word()),
                conditions: Conditions {
                    tissue: &rendering.material.name,
                    order: rendering.material.order,
                    device: &rendering.device_name(),
                    scheme: &rendering.scheme.to_string(),
                    remark,
                },
                quantity: self.quantity,
                origin,
                time_s: time,
                values: &self.values,
                closed_form: &self.closed_form,
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
            errors: Errors::new(
                LargestError::new(FROM_S, "the force by the full history", " N").of(
                    time,
                    &force,
                    &self.full_history_force_n,
                ),
                self.closed_form_error.clone(),
            ),
            discretisation_error: self.discretisation_error,
            rig_error: self.rig_error,
            memory_s,
            final_over_theory,
            final_strain: (self.quantity == Quantity::Strain)
                .then(|| self.values.last().copied())
                .flatten(),
            precision: rendering.precision_run(),
            contact: rendering.contact,
        })
    }

    /// Writes the samples under names that say where the force comes from. A sample without a relative error
    /// has an empty cell.
    fn write_csv(&self, ran: &Ran, force: &[f64], error: &[f64]) -> Result<String, Failure> {
        let Ran { record, folder, .. } = ran;
        let word = origin(record).word();
        let strain = self.quantity == Quantity::Strain;
        let (own_force, own_strain) = (format!("{word}_force_n"), format!("{word}_strain"));
        let mut names = vec![
            "time_s",
            "ideal_position_m",
            "position_m",
            &own_force,
            "full_history_force_n",
        ];
        if strain {
            names.extend([&own_strain, "closed_form_strain"]);
        } else {
            names.push("closed_form_force_n");
        }
        names.push("closed_form_error");
        let rows = (0..force.len()).map(|n| {
            let mut row = vec![
                Some(record.time_s[n]),
                Some(self.ideal_position_m[n]),
                Some(record.position_m[n]),
                Some(force[n]),
                Some(self.full_history_force_n[n]),
            ];
            // The force of a relaxation stands there already.
            row.extend(strain.then(|| Some(self.values[n])));
            row.push(Some(self.closed_form[n]));
            row.push(Some(error[n]).filter(|error| error.is_finite()));
            row
        });
        folder.write_named_table("csv", &names, rows)
    }
}
