//! Claim 6: the peak of the sensitivity.

use super::{Evidence, Formulas, list};
use crate::{DELTA, Kind, ORDERS};
use haptic_analysis::{AnalysisError, Nondimensional, SampledLoop};

/// α and β of the sensitivity, stable for all five orders.
pub(crate) const SENSITIVITY_WALL: (f64, f64) = (0.05, 0.05);

pub(crate) fn sensitivity_rises(kind: Kind, _: &Formulas) -> Result<Evidence, AnalysisError> {
    let peaks = ORDERS
        .iter()
        .map(|&mu| {
            let operator = kind.operator(mu)?;
            let wall = Nondimensional {
                alpha: SENSITIVITY_WALL.0,
                beta: SENSITIVITY_WALL.1,
                delta: DELTA,
                gamma: 0.0,
            };
            let sampled = SampledLoop::new(wall, &operator, 0)?;
            Ok(20.0 * sampled.sensitivity_peak()?.value.log10())
        })
        .collect::<Result<Vec<f64>, AnalysisError>>()?;
    Ok(Evidence {
        holds: peaks.windows(2).all(|pair| pair[1] > pair[0]),
        numbers: format!("peak in dB: {}", list(peaks)),
    })
}
