//! A robot behind a virtual body, as a device for any law.

use super::body::VirtualBody;
use super::chain::MotionChain;
use super::state::{AtRest, MotionFault, MotionStartRefused, MotionState};
use super::{MotionReading, MovingDevice};
use crate::device::{Device, Reading};
use crate::safety::{Limiters, SafeForce, SafetyChain};
use core::fmt::Debug;
use fracdiff::{Differintegrator, Real};
use nalgebra::SVector;
use thiserror::Error;

/// A robot that a hand pushes: a [`VirtualBody`] between the hand and the virtual world, as a [`Device`] of D axes.
///
/// ```text
/// read    f_m = the sensed force, checked            position = x, that of the command
/// write   M(D)·v = f_m + f_e ─▶ MotionChain ─▶ robot.command(v)        x ← x + T·v
/// ```
/// - *Exact at the virtual port*: the law sees the command, not the robot; the hand feels the law through robot and sensor.
/// - *Start-up*: at rest, and not armed: [`rest`](Self::rest) for a while, then [`arm`](Self::arm). Before that it reads, and writes no motion.
/// - *Fault of motion*: the command comes to rest by the greatest deceleration while the device is ticked, which gives no error meanwhile; at
///   rest, each `read` gives [`AdmittanceError::Stopped`], whereupon the loop lets the robot go, and the command stays zero until the robot is
///   armed again. Whoever wants to know earlier looks at [`state`](Self::state).
/// - *Fault or stop of the loop*: [`Device::stop`] does the same, without an error.
/// - *Error of the robot*: one that cannot be commanded has let go; one that cannot sense brakes, then gives its error.
/// - *Cost* of a tick: that of body and chain beside the robot's own; no allocation, no panic.
///
/// ```
/// use fracdiff::{Order, Seconds, ShortMemory};
/// use haptic_loop::plant::{RobotHand, RobotLoop, SimulatedRobot, SimulatedRobotConfig};
/// use haptic_loop::units::*;
/// use haptic_loop::{
///     Admittance, Contact, Controller, MotionChain, MotionLimits, SafetyChain, SpringDamper, VirtualBody,
/// };
///
/// let t = Seconds(2e-3);
/// let operator = |order| Ok::<_, haptic_loop::LoopParameterError>(ShortMemory::<f64, 256>::new(Order::new(order)?, t)?);
/// // 2 kg and 20 N·s/m in the hand, on a robot whose speed loop has 10 Hz, in a soft hand that pulls by 3 N.
/// let body = VirtualBody::new(2.0, NewtonSecondsPerMetre(20.0), operator(1.0)?)?;
/// let config = SimulatedRobotConfig::of(t, RobotLoop::second_order(Hertz(10.0), 0.8)?, RobotHand::relaxed());
/// let robot = SimulatedRobot::<1>::new(config)?;
/// let limits = MotionLimits::of(
///     MetresPerSecond(0.5), MetresPerSecondSquared(10.0), [Metres(-0.1)], [Metres(0.1)], Newtons(50.0),
/// );
/// let mut device = Admittance::new(robot, body, MotionChain::new(&limits, t)?);
/// for _ in 0..100 {
///     device.rest()?;
/// }
/// device.arm()?;
/// device.robot_mut().set_hand_force([3.0].into());
/// // A wall of 1 kN/m at 1 cm.
/// let wall = Contact::at(Metres(0.01), SpringDamper::new(1000.0, 5.0, operator(1.0)?)?)?;
/// let chain = SafetyChain::new(Newtons(20.0), NewtonsPerSecond(1e4), t)?;
/// device.accepts(&chain)?;
/// let mut controller = Controller::<f64, 1, _>::new(wall, chain);
/// let mut engaged = controller.engage(&mut device);
/// for _ in 0..2000 {
///     engaged.tick()?;
/// }
/// let depth = engaged.device().state().position_m()[0] - 0.01;
/// assert!((depth - 3.0 / 1000.0).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Admittance<F, const D: usize, O, R>
where
    F: Real,
    O: Differintegrator<F>,
    R: MovingDevice<F, D>,
{
    robot: R,
    body: VirtualBody<F, O>,
    chain: MotionChain<F, D>,
    state: MotionState<F, D>,
    history: [O::History; D],
    /// `f_m` of this tick, N.
    sensed: SVector<F, D>,
    limiters: Limiters,
    /// Tick, time and positions of the last reading.
    last: Option<MotionReading<F, D>>,
    failed: Option<R::Error>,
}

/// A tick that did not reach the robot.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum AdmittanceError<E: Debug> {
    /// The robot is at rest, and stays there until it is armed again.
    #[error("the robot has stopped: {0}")]
    Stopped(MotionFault),
    /// The robot's own.
    #[error("the robot failed: {0:?}")]
    Robot(E),
}

/// A chain with a passivity guard, which promises nothing for a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "a passivity guard needs a device that damps, which a robot does not: its virtual port sees no energy while the robot diverges \
     in a hand. Take the guard off; the limit of the energy to the hand stands in its place"
)]
pub struct GuardRefused;

impl<F, const D: usize, O, R> Admittance<F, D, O, R>
where
    F: Real,
    O: Differintegrator<F>,
    R: MovingDevice<F, D>,
{
    /// A robot that stands still until it is armed.
    pub fn new(robot: R, body: VirtualBody<F, O>, chain: MotionChain<F, D>) -> Self {
        Self {
            robot,
            history: body.at_rest(),
            body,
            chain,
            state: MotionState::default(),
            sensed: SVector::from([F::ZERO; D]),
            limiters: Limiters::NONE,
            last: None,
            failed: None,
        }
    }

    /// Checks that a loop with this safety chain may run on a robot.
    ///
    /// # Errors
    /// It has a passivity guard.
    pub const fn accepts(&self, chain: &SafetyChain<F>) -> Result<(), GuardRefused> {
        if chain.has_guard() {
            Err(GuardRefused)
        } else {
            Ok(())
        }
    }

    /// One tick at rest, in which the sensor is watched: see [`MotionChain::rest`].
    ///
    /// # Errors
    /// The robot's own; it has let go.
    pub fn rest(&mut self) -> Result<(), AdmittanceError<R::Error>> {
        if self.take_reading()
            && let Some(reading) = &self.last
        {
            self.chain.rest(&mut self.state, reading);
        }
        self.move_on(&SVector::from([F::ZERO; D]))
    }

    /// Arms the robot where it stands: see [`MotionChain::arm`]. The body forgets its past.
    ///
    /// # Errors
    /// As [`MotionChain::arm`]; a robot that cannot sense is [`MotionFault::RobotFailed`].
    pub fn arm(&mut self) -> Result<AtRest<F, D>, MotionStartRefused> {
        let failed = MotionStartRefused::Fault(MotionFault::RobotFailed);
        let reading = self.robot.sense().map_err(|_| failed)?;
        let at_rest = self.chain.arm(&mut self.state, &reading)?;
        for history in &mut self.history {
            self.body.operator().rest(history);
        }
        self.failed = None;
        Ok(at_rest)
    }

    /// Command, fault and books of the motion.
    pub const fn state(&self) -> &MotionState<F, D> {
        &self.state
    }

    /// The motion's state, to latch a fault that something else has found.
    pub const fn state_mut(&mut self) -> &mut MotionState<F, D> {
        &mut self.state
    }

    /// The limiters of motion that acted in the last tick.
    pub const fn limiters(&self) -> Limiters {
        self.limiters
    }

    /// The last reading of the robot, with what its sensors really showed.
    pub const fn reading(&self) -> Option<&MotionReading<F, D>> {
        self.last.as_ref()
    }

    /// The virtual body.
    pub const fn body(&self) -> &VirtualBody<F, O> {
        &self.body
    }

    /// The robot, to look at it between ticks.
    pub const fn robot(&self) -> &R {
        &self.robot
    }

    /// The robot, for functions outside the loop.
    pub const fn robot_mut(&mut self) -> &mut R {
        &mut self.robot
    }

    /// A reading, and `f_m` with it; false for a robot that cannot sense, which is a fault and gives no force.
    #[inline]
    fn take_reading(&mut self) -> bool {
        match self.robot.sense() {
            Ok(reading) => {
                let reading = self.last.insert(reading);
                self.sensed = self.chain.sense(&mut self.state, reading);
                true
            }
            Err(error) => {
                self.fail(error);
                false
            }
        }
    }

    #[inline(never)]
    fn fail(&mut self, error: R::Error) {
        self.state.trip(MotionFault::RobotFailed);
        self.failed.get_or_insert(error);
        self.sensed = SVector::from([F::ZERO; D]);
        // Blind: the command does not need the sensors to come to rest.
        if let Some(last) = &mut self.last {
            last.tick += 1;
        }
    }

    /// The second half of a tick: body, chain, command, history.
    #[inline]
    fn move_on(&mut self, force_n: &SVector<F, D>) -> Result<(), AdmittanceError<R::Error>> {
        let force = SVector::from(core::array::from_fn(|axis| {
            self.sensed[axis] + force_n[axis]
        }));
        let wanted = self.body.velocity(&self.history, &force);
        let (motion, limiters) = self.chain.apply(&mut self.state, &wanted);
        self.limiters = limiters;
        let commanded = self.robot.command(motion);
        self.body
            .advance(&mut self.history, motion.metres_per_second());
        if let Err(error) = commanded {
            self.state.trip(MotionFault::RobotFailed);
            self.let_robot_go();
            return Err(AdmittanceError::Robot(error));
        }
        Ok(())
    }

    #[inline(never)]
    fn let_robot_go(&mut self) {
        self.state.let_go();
        self.robot.let_go();
    }
}

impl<F, const D: usize, O, R> Device<F, D> for Admittance<F, D, O, R>
where
    F: Real,
    O: Differintegrator<F>,
    R: MovingDevice<F, D>,
{
    type Error = AdmittanceError<R::Error>;

    #[inline]
    fn read(&mut self) -> Result<Reading<F, D>, Self::Error> {
        self.take_reading();
        if let Some(fault) = self.state.fault()
            && self.state.is_at_rest()
        {
            let failed = self.failed.take().map(AdmittanceError::Robot);
            return Err(failed.unwrap_or(AdmittanceError::Stopped(fault)));
        }
        let last = self.last.as_ref();
        let (tick, time_s) = last.map_or((0, 0.0), |last| (last.tick, last.time_s));
        Ok(Reading {
            tick,
            time_s,
            position_m: *self.state.position_m(),
        })
    }

    #[inline]
    fn write(&mut self, force: SafeForce<F, D>) -> Result<(), Self::Error> {
        self.move_on(force.newtons())
    }

    fn let_go(&mut self) {
        self.let_robot_go();
    }

    fn stop(&mut self) {
        self.state.stop();
    }

    fn moves(&self) -> bool {
        self.state.is_driven() || !self.state.is_at_rest()
    }
}

impl<F, const D: usize, O, R> Drop for Admittance<F, D, O, R>
where
    F: Real,
    O: Differintegrator<F>,
    R: MovingDevice<F, D>,
{
    fn drop(&mut self) {
        if !self.state.is_at_rest() {
            self.robot.let_go();
        }
    }
}
