//! A second device that pushes the handle of the first into its law: simulated in virtual time, or at a port beside the first.
//!
//! ```text
//! first    m₁·x₁'' + b₁·x₁' + k₁·x₁ = f₁ + F      f₁ the law through the chain of the first device
//! second   m₂·x₂'' + b₂·x₂'          = f₂ − F      f₂ the push through a chain of its own, from t = 0 on
//! contact  F = max(0, k·p + c·p') while p = x₂ − x₁ > 0;   both at rest at 0, just touching
//! at rest  F = f₂ = −f₁,   x₁ = f₂/(K + k₁)
//! ```
//! - *One-sided and compliant*: as two actuators that face each other really touch; a linear wall that pulls leaves the second behind. The
//!   motion is exact, see [`FacingDevices`].
//! - *Analysis*: while they touch, the wall meets both masses and both dampers, m₁ + m₂ and b₁ + b₂, as one body.
//! - *Letting go*: after a fault or stop of one, the other is stopped before its next force. Until then its force is constant: only the
//!   size of the push is limited, not its rate.
//! - *At ports* each device has a chain and a thread of its own, see `haptic-run`; the second may only push
//!   within its lasting limits of force, workspace and speed.

use crate::{
    robot::PushedRobot,
    trial::{TrialPlan, force_and_rate},
};
use fracdiff::parameter::Shown;
use haptic_document::{Failure, FileError, Table, parameters as p, parameters::Parameter};
use haptic_link::LoopMode;
use haptic_loop::{
    Controller, Device, Environment, Reading, SafeForce, SafetyChain, SafetyLimits, SafetyState,
    plant::{
        FacingConfig, FacingContact, FacingDevices, FacingSide, MassDamper, MassDamperConfig,
        Sensed,
    },
    units::{NewtonSecondsPerMetre, NewtonsPerMetre, Seconds},
};
use haptic_message::TickMessage;
use haptic_trial::{
    DeviceModel, Sensors,
    advice::parameter,
    device_table::device_model_by,
    ending::Ending,
    keys::{
        drive::{CONTACT_DAMPING, CONTACT_STIFFNESS, DRIVE_FORCE_LIMIT},
        trial::{IMPACT, PUSH},
    },
    safe_chain::safe_chain,
    safety::{GuardChoice, Safety},
    simulate::{Instrumented, SimulatedLoop, World},
};
use nalgebra::Vector1;
use std::convert::Infallible;

/// Units of time in a sample, in which contact begins and ends.
const UNITS: u64 = 1_000_000;

/// A device that pushes, and its contact with the one that is pushed.
#[derive(Clone, Debug)]
pub struct SecondDevice {
    /// Mass, damping and friction of the device that pushes.
    pub device: MassDamperConfig,
    /// Spring and damper between both.
    pub contact: FacingContact,
    /// Largest force of its motor, N, at least the push.
    pub force_limit_n: f64,
    /// A device file describes it.
    pub is_known: bool,
    /// Place of its loop, at a port; `None` for the simulated one.
    pub at_port: Option<LoopMode>,
}

/// `[drive]` beside the table of a law whose device, `first`, is pushed as planned; both at ports or simulated.
///
/// # Errors
/// A key without effect, or a force limit below the push: with file and line.
pub fn second(
    table: &Table<'_>,
    law: &Table<'_>,
    first: MassDamperConfig,
    [at_port, second_at_port]: [Option<LoopMode>; 2],
    plan: &TrialPlan,
) -> Result<SecondDevice, FileError> {
    if let Some(key) = [&p::PUSH_BY, &IMPACT].into_iter().find(|key| law.has(key)) {
        let key = key.key;
        let reason = format!(
            "{key} has no effect beside [drive], whose device pushes, from rest: omit {key} or [drive]"
        );
        return Err(law.fail_at(key, reason));
    }
    if at_port.is_some() && second_at_port.is_none() {
        let reason = "[drive] beside a device at a port has one of its own: give `drive_device` as serial:PATH, or omit [drive]";
        return Err(table.fail(reason));
    }
    let idle: &[&Parameter] = match second_at_port {
        None => &[&p::CONTROLLER, &p::DRIVE_LOOP],
        Some(_) => &[&p::CONTROLLER, &CONTACT_STIFFNESS, &CONTACT_DAMPING],
    };
    if let Some(key) = idle.iter().find(|key| table.has(key)) {
        let key = key.key;
        let reason = format!(
            "{key} has no effect where the motor of [drive] only pushes, with {PUSH}: omit {key}"
        );
        return Err(table.fail_at(key, reason));
    }
    let force_limit_n = table.number_if(&DRIVE_FORCE_LIMIT)?.unwrap_or(plan.push_n);
    if force_limit_n < plan.push_n {
        let key = DRIVE_FORCE_LIMIT.key;
        let reason = format!(
            "{key} = {} N is below the push of {} N: give at least that, or a smaller {PUSH}",
            Shown(force_limit_n),
            Shown(plan.push_n)
        );
        return Err(table.fail_at(key, reason));
    }
    let model = device_model_by(table, &p::DRIVE_DEVICE_MODEL)?;
    Ok(SecondDevice {
        device: built(model.as_ref(), first),
        contact: FacingContact {
            stiffness: NewtonsPerMetre(table.number(&CONTACT_STIFFNESS)?),
            damping: NewtonSecondsPerMetre(table.number(&CONTACT_DAMPING)?),
            ..FacingContact::COMPLIANT
        },
        force_limit_n,
        is_known: model.is_some(),
        at_port: second_at_port,
    })
}

/// A device as its file says, or else as the first is built, but held by nobody.
fn built(model: Option<&DeviceModel>, first: MassDamperConfig) -> MassDamperConfig {
    let free = MassDamperConfig {
        stiffness: NewtonsPerMetre(0.0),
        ..first
    };
    model.map_or(free, |model| model.values.free(first.sample_time))
}

/// Settings of the chain of a second device: those of the first, without its guard.
pub fn unguarded(safety: &Safety) -> Safety {
    let mut safety = *safety;
    safety.guard = GuardChoice::Off;
    safety
}

/// The motor of a second device, behind a chain of its own.
#[derive(Clone, Debug)]
pub struct Pusher {
    chain: SafetyChain<f64>,
    state: SafetyState<f64, 1>,
    push_n: f64,
}

impl Pusher {
    /// The force of the next tick, at this place, m.
    pub fn push(&mut self, position_m: f64) -> SafeForce<f64, 1> {
        let [position, wanted] = [position_m, self.push_n].map(Vector1::new);
        self.chain.apply(&mut self.state, &position, &wanted).0
    }
}

impl SecondDevice {
    /// Limits of its own chain.
    #[must_use]
    pub fn limits(&self) -> SafetyLimits {
        force_and_rate(self.force_limit_n, None, self.device.sample_time)
    }

    /// Its own chain, without a guard.
    ///
    /// # Errors
    /// As [`safe_chain`].
    pub fn chain(&self, safety: &Safety) -> Result<SafetyChain<f64>, Failure> {
        let (safety, sensors) = (unguarded(safety), Sensors::NONE);
        safe_chain(self.limits(), &self.device, sensors, &safety, self.at_port)
    }

    /// Its motor, at rest.
    ///
    /// # Errors
    /// As [`safe_chain`].
    pub fn pusher(&self, push_n: f64, safety: &Safety) -> Result<Pusher, Failure> {
        Ok(Pusher {
            chain: self.chain(safety)?,
            state: SafetyState::default(),
            push_n,
        })
    }

    /// Both devices at rest, in each other's way, with this push and the first one's limits of motion.
    ///
    /// # Errors
    /// A device outside its ranges.
    pub fn before(
        &self,
        first: MassDamperConfig,
        push_n: f64,
        safety: &Safety,
    ) -> Result<PushedPair, Failure> {
        let t = self.device.sample_time;
        let devices = FacingConfig {
            devices: [first, self.device],
            contact: self.contact,
        };
        Ok(PushedPair {
            world: FacingDevices::new(devices, Seconds(t.0 / UNITS as f64)).map_err(parameter)?,
            pusher: self.pusher(push_n, safety)?,
            sample_time: t,
            tick: 0,
        })
    }
}

/// Two simulated devices, of which the second pushes the one that the loop reads and writes.
#[derive(Clone, Debug)]
pub struct PushedPair {
    world: FacingDevices,
    pusher: Pusher,
    sample_time: Seconds,
    tick: u64,
}

/// The simulated device of a trial.
#[derive(Clone, Debug)]
pub enum Pushed {
    /// A hand or its own motor pushes it.
    Alone(Box<MassDamper<1>>),
    /// A second device pushes it.
    Pair(Box<PushedPair>),
    /// A robot, which a hand pushes.
    Robot(Box<PushedRobot>),
}

impl Pushed {
    /// Reason why a second device pushes no more, or a robot stands still.
    pub(crate) fn ended(&self) -> Option<Ending> {
        match self {
            Self::Alone(_) => None,
            Self::Pair(pair) => pair.pusher.state.fault().map(Ending::Fault),
            Self::Robot(robot) => robot.ended(),
        }
    }

    /// True unless a second device pushes.
    fn is_at_rest(&self) -> bool {
        match self {
            Self::Alone(_) => true,
            Self::Robot(robot) => !robot.moves(),
            Self::Pair(pair) => pair.pusher.state.is_at_rest(),
        }
    }

    /// Lets the force of a second device fall to zero, and a robot come to rest.
    fn stop(&mut self) {
        match self {
            Self::Alone(_) => {}
            Self::Robot(robot) => Device::stop(robot.as_mut()),
            Self::Pair(pair) => pair.pusher.state.stop(),
        }
    }
}

impl Device<f64, 1> for Pushed {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<f64, 1>, Infallible> {
        match self {
            Self::Alone(device) => device.read(),
            Self::Robot(robot) => robot.read(),
            Self::Pair(pair) => Ok(Reading {
                tick: pair.tick,
                time_s: pair.tick as f64 * pair.sample_time.0,
                position_m: Vector1::new(pair.world.position(FacingSide::Renderer)),
            }),
        }
    }

    fn write(&mut self, force: SafeForce<f64, 1>) -> Result<(), Infallible> {
        let pair = match self {
            Self::Alone(device) => return device.write(force),
            Self::Robot(robot) => return robot.write(force),
            Self::Pair(pair) => pair,
        };
        let push = pair.pusher.push(pair.world.position(FacingSide::Indenter));
        let commands = [(FacingSide::Renderer, force), (FacingSide::Indenter, push)];
        for (side, force) in commands {
            pair.world.command(side, force.newtons()[0]);
        }
        pair.world.advance_to(pair.world.now() + UNITS);
        pair.tick += 1;
        Ok(())
    }

    fn stop(&mut self) {
        if let Self::Robot(robot) = self {
            robot.stop();
        }
    }

    fn moves(&self) -> bool {
        matches!(self, Self::Robot(robot) if robot.moves())
    }
}

impl Instrumented for Pushed {
    type Message = TickMessage;

    /// Values of a device alone; of a pair, the place of the second device and the force between both; of a robot, its own place and the force of
    /// the hand.
    fn observe(&self) -> TickMessage {
        match self {
            Self::Alone(device) => device.observe(),
            Self::Robot(robot) => robot.observe(),
            Self::Pair(pair) => TickMessage {
                reference_m: 0.0.into(),
                indenter_position_m: pair.world.position(FacingSide::Indenter).into(),
                contact_force_n: pair.world.contact_force().into(),
                ..TickMessage::unknown(1)
            },
        }
    }
}

/// The loop of a trial on simulated devices: whichever lets go, the other does too.
#[derive(Debug)]
pub struct PushedLoop<'a, E: Environment<f64, 1>>(SimulatedLoop<'a, f64, E, Pushed, 1>);

impl<'a, E: Environment<f64, 1>> PushedLoop<'a, E> {
    /// A loop of this law on these devices.
    pub fn new(controller: &'a mut Controller<f64, 1, E>, device: &'a mut Sensed<Pushed>) -> Self {
        Self(SimulatedLoop::new(controller, device))
    }
}

impl<E: Environment<f64, 1>> World for PushedLoop<'_, E> {
    type Message = TickMessage;

    fn tick(&mut self) -> TickMessage {
        if self.ended().is_some() {
            self.stop();
        }
        self.0.tick()
    }

    fn ended(&self) -> Option<Ending> {
        self.0.ended().or_else(|| self.0.device().ended())
    }

    fn stop(&mut self) {
        self.0.stop();
        self.0.device_mut().stop();
    }

    fn is_at_rest(&self) -> bool {
        self.0.is_at_rest() && self.0.device().is_at_rest()
    }
}

#[cfg(test)]
mod tests;
