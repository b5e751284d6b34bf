//! The program's device as the loop sees it: a position that was handed over, and a force that is handed back.

use crate::{description::Description, motion::Motion};
use haptic_link::{Capabilities, ControllerCost, Refusal, SerialNumber};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_remote::{CONTROLLER_COST, Hardware};
use nalgebra::SVector;

#[derive(Debug)]
pub(crate) struct Program<const D: usize> {
    capabilities: Capabilities,
    serial_number: SerialNumber,
    /// Ends of each axis, m.
    workspace_m: [[f32; 2]; D],
    /// `None` if the program gave none that can be used.
    position_m: Option<[f32; D]>,
    /// Reading of the force sensor, for the next tick alone; NaN without one.
    sensed_n: [f32; D],
    force_n: [f32; D],
    /// The robot, if the program takes a velocity.
    motion: Option<Box<Motion<D>>>,
}

impl<const D: usize> Program<D> {
    pub(crate) fn new(
        description: &Description,
        capabilities: Capabilities,
        serial_number: SerialNumber,
        motion: Option<Box<Motion<D>>>,
    ) -> Self {
        Self {
            capabilities,
            serial_number,
            workspace_m: std::array::from_fn(|axis| description.workspace(axis)),
            position_m: None,
            sensed_n: [f32::NAN; D],
            force_n: [0.0; D],
            motion,
        }
    }

    /// The next tick comes, after some that did not.
    pub(crate) fn goes_on(&mut self, skipped: u32) {
        if let Some(motion) = &mut self.motion {
            motion.robot_mut().goes_on(skipped);
        }
    }

    /// True if the program takes a velocity.
    pub(crate) const fn takes_motion(&self) -> bool {
        self.motion.is_some()
    }

    /// The fault of its motion.
    pub(crate) fn motion_fault(&self) -> Option<Fault> {
        self.motion.as_ref().and_then(|motion| motion.fault())
    }

    /// The robot with the readings of this tick.
    fn robot(&mut self) -> Option<&mut Motion<D>> {
        let motion = self.motion.as_deref_mut()?;
        motion.robot_mut().hand(self.position_m, self.sensed_n);
        Some(motion)
    }

    /// Takes over the position of this call, m; false if it is missing or not finite.
    pub(crate) fn take(&mut self, position_m: Option<&[f64; 3]>) -> bool {
        let single = position_m.map(|axes| std::array::from_fn(|axis| axes[axis] as f32));
        self.position_m = single.filter(|axes: &[f32; D]| axes.iter().all(|axis| axis.is_finite()));
        self.position_m.is_some()
    }

    /// Takes over the force at the sensor, N, for the next tick. A program that gives none any more has a sensor without a reading, not
    /// one that stands still.
    pub(crate) fn senses(&mut self, force_n: &[f64; 3]) {
        self.sensed_n = std::array::from_fn(|axis| force_n[axis] as f32);
    }

    /// The time from one tick to the next, µs, as it was measured.
    pub(crate) const fn declare(&mut self, period_us: u32) {
        self.capabilities.tick_period_min_us = period_us;
        self.capabilities.tick_period_max_us = period_us;
    }

    /// The position of this call is not to be believed.
    pub(crate) const fn forget(&mut self) {
        self.position_m = None;
    }

    /// The force of the last tick, N, or the velocity of a robot, m/s; zero on axes that the device does not have.
    pub(crate) fn output(&self) -> [f64; 3] {
        let velocity = self.motion.as_ref().map(|motion| motion.robot().command());
        let output = velocity.map_or(&self.force_n[..], |velocity| velocity.as_slice());
        std::array::from_fn(|axis| output.get(axis).copied().map_or(0.0, f64::from))
    }

    fn is_outside(&self) -> bool {
        let outside = |axes: &[f32; D]| {
            let mut ends = axes.iter().zip(&self.workspace_m);
            ends.any(|(axis, [low, high])| axis < low || axis > high)
        };
        self.position_m.as_ref().is_some_and(outside)
    }
}

impl<const D: usize> Device<f32, D> for Program<D> {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, D>, Fault> {
        if let Some(robot) = self.robot() {
            return robot.read();
        }
        let position_m = self.position_m.ok_or(Fault::BoardFailed)?;
        if self.is_outside() {
            return Err(Fault::Workspace);
        }
        Ok(Reading {
            tick: 0,
            time_s: 0.0,
            position_m: SVector::from(position_m),
        })
    }

    fn write(&mut self, force: SafeForce<f32, D>) -> Result<(), Fault> {
        if let Some(motion) = &mut self.motion {
            return motion.write(force);
        }
        self.force_n = (*force.newtons()).into();
        Ok(())
    }

    fn let_go(&mut self) {
        self.force_n = [0.0; D];
        self.stop();
    }

    fn stop(&mut self) {
        if let Some(motion) = &mut self.motion {
            motion.stop();
        }
    }

    fn moves(&self) -> bool {
        self.motion.as_ref().is_some_and(|motion| motion.moves())
    }
}

impl<const D: usize> Hardware<D> for Program<D> {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        let mut capabilities = self.capabilities;
        if let Some(motion) = &self.motion {
            motion.declare(&mut capabilities);
        }
        capabilities
    }

    fn serial_number(&self) -> SerialNumber {
        self.serial_number
    }

    fn controller_cost(&self) -> Option<ControllerCost> {
        Some(CONTROLLER_COST)
    }

    fn install(&mut self, (): (), _: u32) {}

    fn restart(&mut self) {}

    fn drive(&mut self) -> Result<(), Refusal> {
        self.robot().map_or(Ok(()), Motion::drive)
    }

    fn idle(&mut self) -> Result<Reading<f32, D>, Fault> {
        if let Some(robot) = self.robot() {
            return robot.idle();
        }
        self.force_n = [0.0; D];
        self.read()
    }

    fn sense(&mut self) -> [f32; D] {
        std::mem::replace(&mut self.sensed_n, [f32::NAN; D])
    }

    fn persisting_fault(&self) -> Option<Fault> {
        // A robot outside is refused when it is to be driven.
        (self.is_outside() && self.motion.is_none()).then_some(Fault::Workspace)
    }
}
