//! Any controller of a file as the holder of the indenter.

use fractional_control::{ControlError, Controller, ControllerSetup, UseController};
use haptic_loop::plant::Holder;
use std::fmt::Debug;

/// A controller with its history.
#[derive(Debug)]
pub(crate) struct ControllerHolder {
    running: Box<dyn Running>,
    /// The last command was at a limit.
    pub(crate) limited: bool,
}

/// A controller of any type.
trait Running: Debug {
    /// The command; `true` if it had to be limited.
    fn step(&mut self, r: f64, y: f64) -> (f64, bool);

    fn reset(&mut self);
}

#[derive(Debug)]
struct Own<C: Controller<f64>> {
    controller: C,
    history: C::History,
}

impl<C: Controller<f64> + Debug> Running for Own<C> {
    fn step(&mut self, r: f64, y: f64) -> (f64, bool) {
        let wanted = self.controller.wanted(&self.history, r, y);
        let command = self.controller.output(&self.history, r, y);
        self.controller.advance(&mut self.history, r, y, command);
        (command, wanted.to_bits() != command.to_bits())
    }

    fn reset(&mut self) {
        self.history = self.controller.at_rest();
    }
}

/// Keeps the controller that a setup makes.
#[derive(Default)]
struct Maker(Option<Box<dyn Running>>);

impl UseController for Maker {
    fn have<C: Controller<f64> + Clone + Debug + 'static>(&mut self, controller: &C) {
        self.0 = Some(Box::new(Own {
            controller: controller.clone(),
            history: controller.at_rest(),
        }));
    }
}

impl ControllerHolder {
    /// The controller at rest.
    pub(super) fn new(setup: &ControllerSetup) -> Result<Self, ControlError> {
        let mut maker = Maker::default();
        setup.with_controller(&mut maker)?;
        let running = maker.0.ok_or(ControlError::Empty { what: "controller" })?;
        Ok(Self {
            running,
            limited: false,
        })
    }
}

impl Holder for ControllerHolder {
    fn force(&mut self, set_point: f64, measured: f64) -> f64 {
        let (command, limited) = self.running.step(set_point, measured);
        self.limited = limited;
        command
    }

    fn restart(&mut self) {
        self.running.reset();
        self.limited = false;
    }
}
