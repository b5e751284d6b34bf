//! A wall that was designed for an ideal device, tried on a realistic one.

use super::{Candidate, Design};
use crate::failure::Failure;
use crate::{Imperfections, Settling};
use fracdiff::Order;
use serde::Serialize;

/// The best candidate on a realistic device. Keys of the report.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RealisticTrial {
    /// What is less than ideal about the device.
    #[serde(flatten)]
    pub imperfections: Imperfections,
    /// Whether the analysis, which knows delay and current lag, calls it stable.
    pub analysis_stable: bool,
    /// Factor by which the wall may grow until it is unstable (below 1: must shrink); null if no factor does.
    pub margin: Option<f64>,
    /// Noise of the force that the encoder makes, rms N.
    pub force_noise_rms_n: f64,
    /// How the trial came out.
    pub simulated: Settling,
}

impl Design {
    /// The same candidate on a realistic device.
    ///
    /// # Errors
    /// A candidate without a wall.
    pub(super) fn beside(&self, best: &Candidate) -> Result<RealisticTrial, Failure> {
        let mut real = self.clone();
        let imperfections = Imperfections::realistic(self.device.plant.sample_time.0);
        real.device.plant = imperfections.on(self.device.plant);
        real.device.sensors = imperfections.sensors;
        let bench = real.bench(Order::new(best.order).map_err(Failure::input)?)?;
        let (alpha, beta) = (best.alpha.unwrap_or(0.0), best.beta.unwrap_or(0.0));
        let (stable, margin) = bench
            .stable_and_margin(alpha, beta)
            .map_err(|error| Failure::Run(error.into()))?;
        Ok(RealisticTrial {
            imperfections,
            analysis_stable: stable,
            margin,
            force_noise_rms_n: beta * bench.noise_unit_n,
            simulated: real.trial(best)?.1,
        })
    }
}
