//! Options that say how several records belong together.

use crate::parse::one_of;
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::question::tissue::{RecordQuestion, Several, temperature};
use haptic_tissue::identify::ShiftBy;

/// Options of several records.
#[derive(Debug, Args)]
#[command(next_help_heading = "Several records")]
pub(super) struct SeveralArguments {
    /// The records are of several specimens: fit each by itself, and take the mean
    #[arg(long, conflicts_with = "master_curve")]
    replicates: bool,
    /// The records, or segments, are at several temperatures: shift them to this one, as in 20degC or 293.15K
    #[arg(long, value_name = "TEMPERATURE", value_parser = temperature, allow_hyphen_values = true)]
    master_curve: Option<f64>,
    /// Temperatures of the files that have no column of it, one for each in their order
    #[arg(long, value_name = "TEMPERATURE", value_delimiter = ',', value_parser = temperature, allow_hyphen_values = true, requires = "master_curve")]
    pub(super) temperature: Vec<f64>,
    /// Modulus of a sweep that decides the shift [default: both]
    #[arg(long, value_parser = one_of(ShiftBy::CHOICES.to_vec()), requires = "master_curve")]
    shift_by: Option<ShiftBy>,
}

impl SeveralArguments {
    pub(super) fn several(&self) -> Result<Several, Failure> {
        RecordQuestion::several(self.replicates, self.master_curve, self.shift_by)
    }
}
