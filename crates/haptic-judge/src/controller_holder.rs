//! A controller of any type with its history, as the holder of a device.

use fractional_control::{ControlError, Controller, ControllerSetup, UseController};
use haptic_loop::plant::Holder;
use std::fmt::Debug;

/// A controller with its history.
#[derive(Debug)]
pub struct ControllerHolder {
    running: Box<dyn Running>,
    /// The last command was at a limit.
    pub limited: bool,
}

/// A controller of any type.
trait Running: Debug {
    /// The command; `true` if it had to be limited.
    fn command(&self, r: f64, y: f64) -> (f64, bool);

    /// Takes in what was really commanded.
    fn advance(&mut self, r: f64, y: f64, command: f64);

    fn reset(&mut self);

    fn copy(&self) -> Box<dyn Running>;
}

#[derive(Clone, Debug)]
struct Own<C: Controller<f64>> {
    controller: C,
    history: C::History,
}

impl<C: Controller<f64> + Clone + Debug + 'static> Running for Own<C> {
    fn command(&self, r: f64, y: f64) -> (f64, bool) {
        let wanted = self.controller.wanted(&self.history, r, y);
        let command = self.controller.output(&self.history, r, y);
        (command, wanted.to_bits() != command.to_bits())
    }

    fn advance(&mut self, r: f64, y: f64, command: f64) {
        self.controller.advance(&mut self.history, r, y, command);
    }

    fn copy(&self) -> Box<dyn Running> {
        Box::new(self.clone())
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
    /// The controller of this setup, at rest.
    ///
    /// # Errors
    /// A setup of which no controller can be made.
    pub fn new(setup: &ControllerSetup) -> Result<Self, ControlError> {
        let mut maker = Maker::default();
        setup.with_controller(&mut maker)?;
        let running = maker.0.ok_or(ControlError::Empty { what: "controller" })?;
        Ok(Self {
            running,
            limited: false,
        })
    }

    /// The command; leaves the history alone.
    pub fn command(&self, set_point: f64, measured: f64) -> f64 {
        self.running.command(set_point, measured).0
    }

    /// Takes in what was really applied.
    pub fn advance(&mut self, set_point: f64, measured: f64, applied: f64) {
        self.running.advance(set_point, measured, applied);
    }
}

impl Holder for ControllerHolder {
    fn force(&mut self, set_point: f64, measured: f64) -> f64 {
        let (command, limited) = self.running.command(set_point, measured);
        self.advance(set_point, measured, command);
        self.limited = limited;
        command
    }

    fn restart(&mut self) {
        self.running.reset();
        self.limited = false;
    }
}

impl Clone for ControllerHolder {
    fn clone(&self) -> Self {
        Self {
            running: self.running.copy(),
            limited: self.limited,
        }
    }
}
