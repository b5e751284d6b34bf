//! A controller in place of a wall: from the position, m, to the force, N, while its reference stands at the start.
//!
//! ```text
//! f = −P(w)·x        P, N/m, in terms of a wall: K = 0, μ = 1 and B = T·1 N/m of B·T^(−μ)·P
//! ```
//! - *Limits* of its command do not count: an actuator has its own.

use fracdiff::{FrequencyResponse as _, Order};
use fractional_control::{ControlError, Controller, ControllerSetup, UseController};
use haptic_analysis::{LoopOperator, NoiseGain};
use haptic_document::Failure;
use haptic_trial::{ControllerFile, advice::refused};
use std::{fmt::Debug, path::Path};

/// Weights of which the noise is summed.
const WEIGHTS: u64 = 4096;

/// A controller of a file, as the loop and its analysis have it.
#[derive(Clone, Debug, PartialEq)]
pub struct PositionController {
    /// The controller, its force without bounds of its own.
    pub setup: ControllerSetup,
    /// P, of order 1.
    pub operator: LoopOperator,
    /// True if a position that stands drives its force on and on.
    pub integrates: bool,
}

impl PositionController {
    /// The controller of a file.
    ///
    /// # Errors
    /// If the file cannot be read, or its controller is no feedback of a position.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let setup = ControllerSetup {
            output_low: None,
            output_high: None,
            ..ControllerFile::read(path)?.setup
        };
        let feedback = setup.feedback().map_err(refused)?;
        let order = Order::new(1.0).map_err(Failure::input)?;
        let both = [feedback.above, feedback.below];
        let operator = LoopOperator::from_controller(order, both, feedback.direct_gain);
        Ok(Self {
            operator: operator.map_err(Failure::input)?,
            integrates: feedback.integrates,
            setup,
        })
    }

    /// Setup with all of its gain this many times as large.
    ///
    /// # Errors
    /// Gains beyond the largest number.
    pub fn scaled(&self, factor: f64) -> Result<ControllerSetup, ControlError> {
        Ok(ControllerSetup {
            law: self.setup.law.scaled(factor)?,
            ..self.setup.clone()
        })
    }

    /// Force per displacement that stands, N/m; of one that integrates after this time.
    ///
    /// # Errors
    /// A law that cannot be sampled.
    pub fn stiffness_n_per_m(&self, time_s: f64) -> Result<f64, Failure> {
        if !self.integrates {
            return Ok(self.operator.response(0.0).re);
        }
        let samples = (time_s / self.setup.sample_time_s).ceil();
        let forces = self.forces_n(samples as u64, |_| 1.0)?;
        Ok(forces.last().copied().unwrap_or(0.0))
    }

    /// Its noise for noise of the position; `None` if it integrates, since that has no end without the loop.
    ///
    /// # Errors
    /// A law that cannot be sampled.
    pub fn noise(&self) -> Result<Option<NoiseGain>, Failure> {
        if self.integrates {
            return Ok(None);
        }
        let t = self.setup.sample_time_s;
        let weights = self.forces_n(WEIGHTS, |n| if n == 0 { 1.0 } else { 0.0 })?;
        let weights = weights.into_iter().map(|force| force / t);
        Ok(Some(NoiseGain::of_weights(weights)))
    }

    /// Forces against positions, m, from rest, N.
    fn forces_n(&self, samples: u64, position_m: fn(u64) -> f64) -> Result<Vec<f64>, Failure> {
        let mut motion = Motion {
            samples,
            position_m,
            forces_n: Vec::new(),
        };
        self.setup.with_controller(&mut motion).map_err(refused)?;
        Ok(motion.forces_n)
    }
}

/// A motion, and the forces against it.
struct Motion {
    samples: u64,
    position_m: fn(u64) -> f64,
    forces_n: Vec<f64>,
}

impl UseController for Motion {
    fn have<C: Controller<f64> + Clone + Debug + 'static>(&mut self, controller: &C) {
        let mut past = controller.at_rest();
        for n in 0..self.samples {
            let x = (self.position_m)(n);
            let command = controller.output(&past, 0.0, x);
            controller.advance(&mut past, 0.0, x, command);
            self.forces_n.push(-command);
        }
    }
}
