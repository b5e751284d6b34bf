//! Any controller of `fractional-control` as the holder of the indenter.

use fracdiff::Seconds;
use fractional_control::{
    Actuator, ControlError, Controller, ControllerParameters, Crone, FractionalPid, LeadLag, MODES,
    Memory, SetPoint, Tid,
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
    pub(super) fn new(
        parameters: &ControllerParameters,
        set_point: SetPoint,
        actuator: Actuator,
        memory: Memory,
        t: Seconds,
    ) -> Result<Self, ControlError> {
        let running = match *parameters {
            ControllerParameters::Pid(own) => Kind::Pid(Running::boxed(FractionalPid::new(
                own, set_point, actuator, memory, t,
            )?)),
            ControllerParameters::Tid(own) => {
                let weight = set_point.derivative;
                Kind::Tid(Running::boxed(Tid::new(own, weight, actuator, memory, t)?))
            }
            ControllerParameters::Crone(own) => {
                Kind::Crone(Running::boxed(Crone::new(own, actuator, memory, t)?))
            }
            ControllerParameters::LeadLag(own) => {
                Kind::LeadLag(Running::boxed(LeadLag::new(own, actuator, memory, t)?))
            }
            _ => {
                return Err(ControlError::NotFound {
                    what: "a way to run this kind of controller",
                    why: "take a PID, TID, CRONE or lead–lag",
                });
            }
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
        }
        self.limited = false;
    }
}
