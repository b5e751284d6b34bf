//! A controller as the law of a trial, whatever its type.

use crate::experiment::drive::ControllerHolder;
use crate::judge::position_controller::PositionController;
use fractional_control::ControlError;
use haptic_loop::Environment;
use nalgebra::Vector1;

/// A controller whose reference stands at 0, from the position, m, to the force, N. It hears what the safety chain left of its force, as on a device.
pub(crate) struct PositionLaw(ControllerHolder);

impl PositionLaw {
    /// With all of its gain this many times as large.
    pub(crate) fn new(controller: &PositionController, scale: f64) -> Result<Self, ControlError> {
        ControllerHolder::new(&controller.scaled(scale)?).map(Self)
    }
}

impl Environment<f64, 1> for PositionLaw {
    type History = ControllerHolder;

    fn at_rest(&self) -> ControllerHolder {
        self.0.clone()
    }

    fn force(&self, past: &ControllerHolder, x: &Vector1<f64>) -> Vector1<f64> {
        Vector1::new(past.command(0.0, x[0]))
    }

    fn advance(&self, past: &mut ControllerHolder, x: &Vector1<f64>) {
        past.advance(0.0, x[0], past.command(0.0, x[0]));
    }

    fn advance_applied(
        &self,
        past: &mut ControllerHolder,
        x: &Vector1<f64>,
        applied_n: &Vector1<f64>,
    ) {
        past.advance(0.0, x[0], applied_n[0]);
    }
}
