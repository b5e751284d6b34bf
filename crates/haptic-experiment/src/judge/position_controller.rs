//! A controller in place of a wall: from the position, m, to the force, N, while its reference stands at the start.
//!
//! ```text
//! f = −P(w)·x        P, N/m, in terms of a wall: K = 0, μ = 1 and B = T·1 N/m of B·T^(−μ)·P
//! ```
//! - *Limits* of its command do not count: an actuator has its own.

use crate::document::ControllerFile;
use crate::document::failure::Failure;
use crate::judge::control::refused;
use fracdiff::{FrequencyResponse as _, Order};
use fractional_control::{ControlError, Controller, ControllerSetup, UseController};
use haptic_analysis::LoopOperator;
use std::fmt::Debug;
use std::path::Path;

/// A controller of a file, as the loop and its analysis have it.
#[derive(Clone, Debug)]
pub(crate) struct PositionController {
    pub(crate) setup: ControllerSetup,
    /// P, of order 1.
    pub(crate) operator: LoopOperator,
    /// True if a position that stands drives its force on and on.
    pub(crate) integrates: bool,
}

impl PositionController {
    pub(crate) fn read(path: &Path) -> Result<Self, Failure> {
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

    /// With all of its gain this many times as large.
    pub(crate) fn scaled(&self, factor: f64) -> Result<ControllerSetup, ControlError> {
        Ok(ControllerSetup {
            law: self.setup.law.scaled(factor)?,
            ..self.setup.clone()
        })
    }

    /// Force per displacement that stands, N/m; of one that integrates after so many samples.
    pub(crate) fn stiffness_n_per_m(&self, samples: u64) -> Result<f64, Failure> {
        if !self.integrates {
            return Ok(self.operator.response(0.0).re);
        }
        let mut step = Step {
            samples,
            force_n: 0.0,
        };
        self.setup.with_controller(&mut step).map_err(refused)?;
        Ok(step.force_n)
    }
}

/// The force against a step of 1 m, after some samples.
struct Step {
    samples: u64,
    force_n: f64,
}

impl UseController for Step {
    fn have<C: Controller<f64> + Clone + Debug + 'static>(&mut self, controller: &C) {
        let mut past = controller.at_rest();
        for _ in 0..self.samples {
            let command = controller.output(&past, 0.0, 1.0);
            controller.advance(&mut past, 0.0, 1.0, command);
            self.force_n = -command;
        }
    }
}
