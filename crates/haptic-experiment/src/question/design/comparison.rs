//! A wall that was designed for an ideal device, tried with what the device `laboratory` has.

use super::candidate::{Candidate, RealisticTrial};
use super::question::Design;
use crate::document::failure::Failure;
use crate::document::parameters::LABORATORY;
use crate::run::plant_file::DeviceModel;
use fracdiff::Order;
use std::path::Path;

impl Design {
    /// The same candidate on a realistic device.
    ///
    /// # Errors
    /// A candidate without a wall.
    pub(super) fn beside(&self, best: &Candidate) -> Result<RealisticTrial, Failure> {
        let mut real = self.clone();
        let laboratory = DeviceModel::find(Path::new(LABORATORY));
        let imperfections = laboratory.map_err(Failure::input)?.imperfections();
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
