//! The simulated rig, its indenter held by a controller or by what is built in.

use super::ControllerHolder;
use crate::run::simulate::Instrumented;
use fracdiff::Real;
use haptic_log::record::TickMessage;
use haptic_loop::plant::{HeldRig, IndentationRig};
use haptic_loop::{Device, Reading, SafeForce};
use std::convert::Infallible;

/// The rig of a relaxation or creep test.
#[derive(Debug)]
pub(crate) enum SimulatedRig {
    /// Servo or constant push.
    Plain(Box<IndentationRig>),
    /// A controller.
    Held(Box<HeldRig<ControllerHolder>>),
}

impl<F: Real> Device<F, 1> for SimulatedRig {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<F, 1>, Infallible> {
        match self {
            Self::Plain(rig) => rig.read(),
            Self::Held(rig) => rig.read(),
        }
    }

    fn write(&mut self, force: SafeForce<F, 1>) -> Result<(), Infallible> {
        match self {
            Self::Plain(rig) => rig.write(force),
            Self::Held(rig) => rig.write(force),
        }
    }
}

impl Instrumented for SimulatedRig {
    type Message = TickMessage;

    fn observe(&self) -> TickMessage {
        match self {
            Self::Plain(rig) => rig.observe(),
            Self::Held(held) => {
                let observed = held.rig().observe();
                TickMessage {
                    reference_m: held.reference().map_or(observed.reference_m, Into::into),
                    ..observed
                }
            }
        }
    }
}
