//! A controller and a plant, sample by sample.

use crate::{Controller, HeldPlant};
use std::vec::Vec;

/// Reference, measurement and command of a loop, one value of each per sample.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Response {
    /// r, the reference, in the unit of y.
    pub reference: Vec<f64>,
    /// y, as the controller measures it.
    pub measured: Vec<f64>,
    /// u, the command within its limits.
    pub command: Vec<f64>,
}

/// The shape of the response to a step from rest.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct StepShape {
    /// Largest y beyond the step, as a share of it; 0 without overshoot.
    pub overshoot: f64,
    /// Samples from 10 % to 90 % of the step, between samples by straight lines; `None` if y does
    /// not reach that.
    pub rise: Option<f64>,
    /// The sample from which y stays within 2 % of the step; `None` where it does not.
    pub settled: Option<usize>,
    /// |1 − y| at the end, as a share of the step.
    pub final_error: f64,
}

/// Runs the loop from rest: y\[n\] measured, u\[n\] sent, r given for each sample. If the plant
/// answers at once, u\[n\] and y\[n\] are solved together.
/// ```text
/// y = S + G·u,   u = limit(g_r·r − g_y·y + …):   u = limit((…)/(1 + g_y·G))
/// ```
pub fn simulate<C: Controller<f64>>(
    controller: &C,
    plant: &HeldPlant,
    reference: impl Fn(usize) -> f64,
    samples: usize,
) -> Response {
    simulate_loaded(controller, plant, reference, 0.0, samples)
}

/// Runs the loop with a load d that is added to the command before the plant: y = S + G·(u + d).
pub(crate) fn simulate_loaded<C: Controller<f64>>(
    controller: &C,
    plant: &HeldPlant,
    reference: impl Fn(usize) -> f64,
    load: f64,
    samples: usize,
) -> Response {
    let (mut history, mut state) = (controller.at_rest(), plant.at_rest());
    let mut run = Response::default();
    let loop_gain = 1.0 + controller.feedback_gain() * plant.direct_gain();
    for n in 0..samples {
        let r = reference(n);
        let past = plant.past(&state) + plant.direct_gain() * load;
        let free = controller.wanted(&history, r, past) / loop_gain;
        let measured = past + plant.direct_gain() * free;
        let command = controller.output(&history, r, measured);
        // A command at its limit moves the plant less.
        let measured = past + plant.direct_gain() * command;
        let command = controller.output(&history, r, measured);
        controller.advance(&mut history, r, measured, command);
        plant.advance(&mut state, command + load);
        run.reference.push(r);
        run.measured.push(measured);
        run.command.push(command);
    }
    run
}

impl Response {
    /// The shape of y, read as the response to a step of height 1.
    #[must_use]
    pub fn shape(&self) -> StepShape {
        self.shape_of_step(1.0)
    }

    /// The shape of y, read as the response to a step of this height, which must not be 0.
    #[must_use]
    pub fn shape_of_step(&self, height: f64) -> StepShape {
        let y = || self.measured.iter().map(|y| y / height);
        let most = y().fold(f64::NEG_INFINITY, f64::max);
        let outside = y().rposition(|y| (y - 1.0).abs() > 0.02 || y.is_nan());
        let settled = outside.map_or(0, |last| last + 1);
        let reaches = |share: f64| {
            let after = y().position(|y| y >= share)?;
            let before = after.checked_sub(1).and_then(|n| y().nth(n));
            let (before, y) = (before?, y().nth(after)?);
            Some(after as f64 - (y - share) / (y - before))
        };
        // At once is in the first sample.
        let rises = (reaches(0.1).or(Some(0.0))).zip(reaches(0.9));
        StepShape {
            overshoot: (most - 1.0).max(0.0),
            rise: rises.map(|(low, high)| high - low),
            settled: (settled < self.measured.len()).then_some(settled),
            final_error: y().next_back().map_or(f64::NAN, |y| (y - 1.0).abs()),
        }
    }
}
