//! What a relaxation and a creep test leave: their report and their curves.

use super::{Contact, Precision};
use crate::experiment::drive::{DriveCurves, DriveReport};
use crate::judge::curves::Origin;
use crate::judge::report::{Errors, RunReport, Summary};
use serde::Serialize;

/// The result of a relaxation or creep test.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Name of the tissue.
    pub tissue: String,
    /// α of the tissue.
    pub order: f64,
    /// Operator.
    pub scheme: String,
    /// Number type of the loop.
    pub precision: Precision,
    /// Contact between indenter and renderer.
    pub contact: Contact,
    /// Memory of the operator, s; null for everything.
    pub memory_s: Option<f64>,
    /// Of the run.
    #[serde(flatten)]
    pub run: RunReport,
    /// The two errors, each with the samples that it is of.
    #[serde(flatten)]
    pub errors: Errors,
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
    pub drive: Option<DriveReport>,
}

impl Summary for Report {
    fn run(&self) -> &RunReport {
        &self.run
    }

    fn run_mut(&mut self) -> &mut RunReport {
        &mut self.run
    }
}

/// The quantity that is held against its closed form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Force, N.
    Force,
    /// Strain, dimensionless.
    Strain,
}

impl Quantity {
    /// The word for it.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Force => "force",
            Self::Strain => "strain",
        }
    }

    /// Its axis label, with the unit.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::Force => "force / N",
            Self::Strain => "strain",
        }
    }
}

/// A run beside its closed form. The slices belong together point by point; long runs are thinned without losing a
/// peak.
#[derive(Clone, Debug, PartialEq)]
pub struct TheoryCurves {
    /// One line: which experiment, of what, simulated or rendered.
    pub title: String,
    /// Name of the tissue.
    pub tissue: String,
    /// Its order α.
    pub order: f64,
    /// Name of the device.
    pub device: String,
    /// The operator.
    pub scheme: String,
    /// Motion or load of the tissue, in words.
    pub remark: String,
    /// Kind of the quantity.
    pub quantity: Quantity,
    /// Its origin.
    pub origin: Origin,
    /// Time since contact or since the load, s.
    pub time_s: Vec<f64>,
    /// The quantity, N or 1.
    pub values: Vec<f64>,
    /// The quantity in closed form.
    pub closed_form: Vec<f64>,
    /// Its relative error; NaN where it has no meaning.
    pub relative_error: Vec<f64>,
    /// Of the controller that held the indenter.
    pub drive: Option<DriveCurves>,
}
