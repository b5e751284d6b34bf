//! The loop on a simulated device in virtual time: no folder, no log, no clock.
//!
//! ```text
//! instruments ─▶ engaged.tick() ─▶ message ─▶ sink        n = 0, 1, …, samples − 1
//! ```
//! What simulates a relaxation or creep goes through here; a trial of a wall needs no messages, its judge sees the ticks themselves. A run
//! with a log (`run`) makes the same messages from the same ticks and differs in who paces it and who listens.

use crate::{
    ending::Ending,
    tick::{TickRecord, by_loop},
};
use fracdiff::Real;
use haptic_loop::{
    Controller, Device, Engaged, Environment,
    plant::{IndentationRig, MassDamper, PressedDevice, Sensed},
};
use haptic_message::{EventMessage, TickMessage};
use std::{convert::Infallible, ops::ControlFlow};

/// A system that runs tick by tick: a loop on a simulated device, or both sides of a teleoperation.
pub trait World<const D: usize = 1> {
    /// Record of a tick, which a sink takes.
    type Message: TickRecord;

    /// Does the next tick of the world, and returns its record.
    fn tick(&mut self) -> Self::Message;

    /// The tick before counts: no fault and no silence ended the run in it.
    fn counted(&mut self) {}

    /// Why the world does not go on by itself.
    fn ended(&self) -> Option<Ending>;

    /// Lets the force fall to zero.
    fn stop(&mut self);

    /// True if there is no force any more.
    fn is_at_rest(&self) -> bool;

    /// An event for the log besides the tick.
    fn event(&mut self) -> Option<EventMessage> {
        None
    }

    /// True of one that has no number of ticks beforehand, and whose last has been.
    fn is_over(&self) -> bool {
        false
    }
}

/// Receiver of each sample; it may end the simulation.
pub type Sink<'a, M = TickMessage> = &'a mut dyn FnMut(&M) -> ControlFlow<()>;

/// A simulated device with instruments of its own, beside the sensors that the loop reads. A force sensor shows its contact force, unless it says
/// what is sensed.
pub trait Instrumented<const D: usize = 1> {
    /// Record of a tick, as that of its world.
    type Message: TickRecord;

    /// Readings at the start of a tick: a message without what the loop itself knows.
    fn observe(&self) -> Self::Message;
}

/// Runs a loop for `samples` ticks, or until the sink breaks; `true` if it reached the end without a fault. When it returns, the force is
/// zero.
pub fn simulate<F, E, V, const D: usize>(
    controller: &mut Controller<F, D, E>,
    device: &mut Sensed<V>,
    samples: u64,
    sink: Sink<'_, V::Message>,
) -> bool
where
    F: Real,
    E: Environment<F, D>,
    V: Device<F, D, Error = Infallible> + Instrumented<D>,
{
    let mut simulated = SimulatedLoop::new(controller, device);
    for _ in 0..samples {
        let message = simulated.tick();
        if sink(&message).is_break() || simulated.ended().is_some() {
            return false;
        }
    }
    true
}

/// Runs a world to its last sample, or until the sink breaks; one that ends early goes on until its force is zero, as a run with a log
/// does. Why it ended early, if it did.
pub fn to_the_end<W: World<D>, const D: usize>(
    world: &mut W,
    samples: u64,
    sink: Sink<'_, W::Message>,
) -> Option<Ending> {
    let (mut tick, mut ended) = (0, None);
    while tick < samples || ended.is_some() {
        if sink(&world.tick()).is_break() {
            break;
        }
        tick += 1;
        if ended.is_some() {
            if world.is_at_rest() {
                break;
            }
            continue;
        }
        ended = world.ended();
        if ended.is_some() {
            world.stop();
        }
    }
    ended
}

/// A loop on a simulated device. Whatever ends it, no force stays.
#[derive(Debug)]
pub struct SimulatedLoop<'a, F: Real, E: Environment<F, D>, V, const D: usize>
where
    V: Device<F, D, Error = Infallible>,
{
    engaged: Engaged<F, D, E, &'a mut Sensed<V>, &'a mut Controller<F, D, E>>,
}

impl<'a, F: Real, E: Environment<F, D>, V, const D: usize> SimulatedLoop<'a, F, E, V, D>
where
    V: Device<F, D, Error = Infallible>,
{
    /// Engages the device; it is let go when this is dropped.
    pub fn new(controller: &'a mut Controller<F, D, E>, device: &'a mut Sensed<V>) -> Self {
        let engaged = controller.engage(device);
        Self { engaged }
    }

    /// The device behind its sensors.
    pub fn device(&self) -> &V {
        self.engaged.device().device()
    }

    /// The device behind its sensors.
    pub fn device_mut(&mut self) -> &mut V {
        self.engaged.device_mut().device_mut()
    }
}

impl<F: Real, E: Environment<F, D>, V, const D: usize> World<D> for SimulatedLoop<'_, F, E, V, D>
where
    V: Device<F, D, Error = Infallible> + Instrumented<D>,
{
    type Message = V::Message;

    fn tick(&mut self) -> V::Message {
        let mut message = self.engaged.device().device().observe();
        let sample = match self.engaged.tick() {
            Ok(sample) => sample,
            Err(never) => match never {},
        };
        let guarded_energy_j = self.engaged.controller().guarded_energy_j();
        let logged = message.logged_mut();
        let mut sensed = logged.sensed_force_n.unwrap_or(logged.contact_force_n);
        let senses = self.engaged.device_mut().sense(sensed.values_mut());
        logged.sensed_force_n = senses.then_some(sensed);
        *logged = by_loop(*logged, &sample, guarded_energy_j);
        message
    }

    fn ended(&self) -> Option<Ending> {
        let fault = self.engaged.controller().safety().fault();
        fault.map(Ending::Fault)
    }

    fn stop(&mut self) {
        self.engaged.controller_mut().stop();
    }

    fn is_at_rest(&self) -> bool {
        self.engaged.controller().safety().is_at_rest()
    }
}

impl Instrumented for IndentationRig {
    type Message = TickMessage;

    fn observe(&self) -> TickMessage {
        TickMessage {
            // A force drive has no position to follow.
            reference_m: (self.reference())
                .unwrap_or_else(|| self.indenter_position())
                .into(),
            indenter_position_m: self.indenter_position().into(),
            contact_force_n: self.contact_force().into(),
            ..TickMessage::unknown(1)
        }
    }
}

impl Instrumented for MassDamper<1> {
    type Message = TickMessage;

    /// The true position, and the force that the actuator really makes.
    fn observe(&self) -> TickMessage {
        TickMessage {
            reference_m: 0.0.into(),
            indenter_position_m: self.position()[0].into(),
            contact_force_n: self.applied_force()[0].into(),
            ..TickMessage::unknown(1)
        }
    }
}

impl Instrumented for PressedDevice {
    type Message = TickMessage;

    fn observe(&self) -> TickMessage {
        TickMessage {
            indenter_position_m: self.position().into(),
            contact_force_n: self.contact_force().into(),
            ..TickMessage::unknown(1)
        }
    }
}
