//! A controller as the law of a trial, whatever its type.

use crate::{
    controller_holder::ControllerHolder, position_controller::PositionController, settling::Judge,
    trial::TrialPlan,
};
use fractional_control::ControlError;
use haptic_loop::Environment;
use nalgebra::Vector1;

/// A controller whose reference stands at 0, from the position, m, to the force, N. It hears what the safety chain left of its force, as on a device.
#[derive(Debug)]
pub struct PositionLaw(ControllerHolder);

impl PositionLaw {
    /// Law with all of the controller's gain this many times as large.
    ///
    /// # Errors
    /// A setup of which no controller can be made.
    pub fn new(controller: &PositionController, scale: f64) -> Result<Self, ControlError> {
        ControllerHolder::new(&controller.scaled(scale)?).map(Self)
    }

    /// The judge of a trial beside a hand's spring, N/m; `None` of a controller that pushes the device away from where it is. `standing` is the
    /// force per displacement that stands, N/m.
    pub fn judge(
        controller: &PositionController,
        [scale, standing]: [f64; 2],
        plan: &TrialPlan,
        hand_n_per_m: f64,
        encoder_step_m: f64,
    ) -> Option<Judge> {
        let spring = scale * standing + hand_n_per_m;
        let step = scale * controller.operator.direct_gain().abs();
        let t = controller.setup.sample_time_s;
        let judge = if !controller.integrates {
            plan.judge(spring, step, encoder_step_m, t)
        } else {
            let judge = plan.judge(0.0, step, encoder_step_m, t);
            judge.balancing(plan.push_n, hand_n_per_m)
        };
        (spring >= 0.0).then_some(judge)
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
