//! Any controller of `fractional-control` as the holder of the indenter.

use crate::controller_file::ControllerFile;
use fractional_control::{
    ControlError, Controller, ControllerParameters, Crone, FractionalPid, FunctionController,
    LeadLag, MODES, Tid,
};
use haptic_loop::plant::Holder;

/// A controller with its history.
#[derive(Clone, Debug)]
pub(crate) struct ControllerHolder {
    running: Kind,
    /// The last command was at a limit.
    pub(crate) limited: bool,
}

#[derive(Clone, Debug)]
enum Kind {
    Pid(Box<Running<FractionalPid<f64, MODES>>>),
    Tid(Box<Running<Tid<f64, MODES>>>),
    Crone(Box<Running<Crone<f64, MODES>>>),
    LeadLag(Box<Running<LeadLag<f64, MODES>>>),
    Function(Box<Running<FunctionController<f64, MODES>>>),
}

#[derive(Clone, Debug)]
struct Running<C: Controller<f64>> {
    controller: C,
    history: C::History,
}

impl<C: Controller<f64>> Running<C> {
    fn boxed(controller: C) -> Box<Self> {
        let history = controller.at_rest();
        Box::new(Self {
            controller,
            history,
        })
    }

    /// The command; `true` if it had to be limited.
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

impl ControllerHolder {
    /// The controller of a file that was checked.
    pub(super) fn new(file: &ControllerFile) -> Result<Self, ControlError> {
        let (actuator, memory, t) = (file.actuator()?, file.memory()?, file.sample_time());
        let weights = file.set_point;
        let running = match &file.law {
            ControllerParameters::Pid(own) => Kind::Pid(Running::boxed(FractionalPid::new(
                *own, weights, actuator, memory, t,
            )?)),
            ControllerParameters::Tid(own) => {
                let tid = Tid::new(*own, weights.derivative, actuator, memory, t)?;
                Kind::Tid(Running::boxed(tid))
            }
            ControllerParameters::Crone(own) => {
                Kind::Crone(Running::boxed(Crone::new(*own, actuator, memory, t)?))
            }
            ControllerParameters::LeadLag(own) => {
                Kind::LeadLag(Running::boxed(LeadLag::new(*own, actuator, memory, t)?))
            }
            ControllerParameters::Function(own) => {
                let function = FunctionController::new(own, actuator, memory, t)?;
                Kind::Function(Running::boxed(function))
            }
            _ => return Err(ControlError::Empty { what: "controller" }),
        };
        Ok(Self {
            running,
            limited: false,
        })
    }
}

impl Holder for ControllerHolder {
    fn force(&mut self, set_point: f64, measured: f64) -> f64 {
        let (command, limited) = match &mut self.running {
            Kind::Pid(own) => own.step(set_point, measured),
            Kind::Tid(own) => own.step(set_point, measured),
            Kind::Crone(own) => own.step(set_point, measured),
            Kind::LeadLag(own) => own.step(set_point, measured),
            Kind::Function(own) => own.step(set_point, measured),
        };
        self.limited = limited;
        command
    }

    fn restart(&mut self) {
        match &mut self.running {
            Kind::Pid(own) => own.reset(),
            Kind::Tid(own) => own.reset(),
            Kind::Crone(own) => own.reset(),
            Kind::LeadLag(own) => own.reset(),
            Kind::Function(own) => own.reset(),
        }
        self.limited = false;
    }
}
