//! Loops of a plant and a controller file: judged, run, designed; and plants from records.

pub mod analysis;
pub mod design;
pub mod identification;
pub mod run;

use crate::document::controller_file::ControllerFile;
use fracdiff::Seconds;
use fractional_control::{ControlError, Memory, Plant, Rule, SampledPlant};

/// Tolerance of the plant's own memory, and the samples for which it holds.
const PLANT_TOLERANCE: f64 = 1e-9;
const PLANT_SAMPLES: f64 = 1e6;

/// The plant as the loop of this controller samples it: of second order in the sample time, whatever the rule of the controller is.
///
/// # Errors
/// A measured response, which does not run; a dead time of too many samples; a sample time that does not fit.
pub fn sampled(plant: &Plant, sample_time: Seconds) -> Result<SampledPlant, ControlError> {
    let memory = Memory::new(Rule::Bdf2, PLANT_TOLERANCE, PLANT_SAMPLES * sample_time.0)?;
    SampledPlant::new(plant, memory, sample_time)
}

/// The plant as this controller's loop samples it.
fn sampled_for(file: &ControllerFile, plant: &Plant) -> Result<SampledPlant, ControlError> {
    sampled(plant, file.sample_time())
}

#[cfg(test)]
mod tests;
