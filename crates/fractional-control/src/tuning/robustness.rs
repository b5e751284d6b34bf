//! Steps of the loop that is really run while the gain of the plant changes.

use crate::records::MODES;
use crate::{
    Actuator, ControlError, FractionalPid, Memory, PidParameters, Plant, Response, SampledPlant,
    SetPoint, simulate,
};
use fracdiff::Seconds;
use std::vec::Vec;

/// Gains of the plant over the nominal one: ± 6 dB in five steps.
pub const GAINS: [f64; 5] = [
    0.501_187_233_627_272_2,
    0.707_945_784_384_137_9,
    1.0,
    1.412_537_544_622_754_3,
    1.995_262_314_968_879_5,
];

/// Steps of the sampled loop, unlimited, all on the error, one for each of [`GAINS`]: `samples` samples each. The command is that for the
/// nominal plant times the gain.
///
/// ```
/// use fracdiff::Seconds;
/// use fractional_control::tuning::steps;
/// use fractional_control::{Memory, PidParameters, Plant, Rule};
///
/// let plant: Plant = "1/(s^1.3+0.1)".parse()?;
/// let gains = PidParameters { proportional: 1.0, ..PidParameters::NONE };
/// let memory = Memory::new(Rule::Bdf2, 1e-5, 100.0)?;
/// let steps = steps(&gains, &plant, memory, Seconds(0.02), 2000)?;
/// // A loop of about 1/s^1.3 overshoots alike at any gain.
/// assert!(steps.iter().all(|step| step.shape().overshoot < 0.1));
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
/// # Errors
/// A plant that does not run, parameters outside their range.
pub fn steps(
    parameters: &PidParameters,
    plant: &Plant,
    memory: Memory,
    sample_time: Seconds,
    samples: usize,
) -> Result<Vec<Response>, ControlError> {
    let plant = SampledPlant::new(plant, memory, sample_time)?;
    let one = |gain: f64| {
        // The gain of the plant is that of the controller, as far as y goes.
        let scaled = PidParameters {
            proportional: gain * parameters.proportional,
            integral: gain * parameters.integral,
            derivative: gain * parameters.derivative,
            ..*parameters
        };
        let pid = FractionalPid::<f64, MODES>::new(
            scaled,
            SetPoint::ERROR,
            Actuator::UNLIMITED,
            memory,
            sample_time,
        )?;
        Ok(simulate(&pid, &plant, |_| 1.0, samples))
    };
    GAINS.into_iter().map(one).collect()
}
