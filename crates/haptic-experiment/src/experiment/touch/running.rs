//! The loop of a touch: made of good parameters, tried alone, or run with a log.

use super::device::{HandEnergy, HeldAxes, depth};
use super::hand::{Grip, HandPath};
use super::report::{TouchCurves, TouchReport};
use super::shape::Touched;
use super::specification::TouchExperiment;
use crate::document::advice::parameter;
use crate::document::failure::Failure;
use crate::document::parameters::TOUCH_AXES;
use crate::experiment::touch::keys::{TOUCH_CIRCLE_START, TOUCH_HAND, TOUCH_ORDER, TOUCH_WAY};
use crate::judge::curves::Published;
use crate::run::folder::FolderRequest;
use crate::run::schedule::{Schedule, horizon};
use crate::run::simulate::Simulated;
use crate::run::{Ran, Supervisor, run_logged};
use haptic_loop::Controller;
use haptic_loop::plant::{Axes, Sensed};

/// A loop made of good parameters.
struct Parts<const D: usize> {
    controller: Controller<f64, D, Touched<D>>,
    device: Sensed<HeldAxes<D>>,
    samples: u64,
}

/// Deeper than this at the start is a blow, m: more than rounding.
const START_MOST_M: f64 = 1e-9;

impl TouchExperiment {
    /// Runs the experiment; log and CSV go into the folder.
    ///
    /// # Errors
    /// Bad parameters, before any file is made; a log or CSV that cannot be written.
    pub fn run(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Published<TouchReport, TouchCurves>, Failure> {
        match self.axes {
            3 => self.run_in::<3>(request, supervisor),
            _ => self.run_in::<2>(request, supervisor),
        }
    }

    /// The number of samples, if all parameters are good.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn check(&self) -> Result<u64, Failure> {
        match self.axes {
            2 => self.checked::<2>(),
            3 => self.checked::<3>(),
            axes => Err(Failure::bad_input(format_args!(
                "{} is not 2 or 3: one axis is [wall]",
                TOUCH_AXES.set_to(axes)
            ))),
        }
    }

    /// Checks that the simulated device begins outside the shape; on a device only the device knows.
    ///
    /// # Errors
    /// A start inside, which would be a blow; a parameter outside its range.
    pub fn check_start(&self) -> Result<(), Failure> {
        match self.axes {
            _ if self.remote.is_some() => Ok(()),
            3 => self.outside(&self.parts::<3>()?),
            _ => self.outside(&self.parts::<2>()?),
        }
    }

    fn outside<const D: usize>(&self, parts: &Parts<D>) -> Result<(), Failure> {
        let shape = self.shape.of::<D>()?;
        let begins = depth(&shape, parts.device.device().place().as_slice());
        if begins <= START_MOST_M {
            return Ok(());
        }
        Err(Failure::bad_input(format_args!(
            "the device begins {begins:.3e} m deep in the shape, which would be a blow: let the hand begin outside, \
             by {TOUCH_WAY} or {TOUCH_CIRCLE_START}, or move the shape"
        )))
    }

    fn run_in<const D: usize>(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Published<TouchReport, TouchCurves>, Failure> {
        if let Some(remote) = &self.remote {
            return self.run_on::<D>(remote, request, supervisor);
        }
        let mut parts = self.parts::<D>()?;
        self.outside(&parts)?;
        let postures = self.postures::<D>(parts.samples)?;
        let (verdict, posture) = postures.worse(self.dynamics(), 0)?;
        let mut metadata = self.metadata();
        verdict.describe(&mut metadata);
        posture.describe(&mut metadata);
        let schedule = Schedule {
            samples: parts.samples,
            sample_time_s: self.sample_time().0,
            pace: self.pace,
        };
        let mut world = Simulated::new(&mut parts.controller, &mut parts.device);
        let ran = run_logged(&mut world, schedule, (request, metadata), supervisor)?;
        drop(world);
        let ran = Ran {
            // Nothing can break, so it is only noted.
            preflight: Some(verdict),
            ..ran
        };
        let energy: HandEnergy = parts.device.device().energy();
        let reported = self.publish::<D>(&ran, Some(energy), posture)?;
        Ok(Published::new(reported, ran.folder))
    }

    fn checked<const D: usize>(&self) -> Result<u64, Failure> {
        match &self.remote {
            Some(remote) => {
                self.check_on::<D>(remote)?;
                Ok(self.loop_of::<D>()?.1)
            }
            None => Ok(self.parts::<D>()?.samples),
        }
    }

    /// The loop, and its number of samples.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub(super) fn loop_of<const D: usize>(
        &self,
    ) -> Result<(Controller<f64, D, Touched<D>>, u64), Failure> {
        let samples = self.samples()?;
        if self.law.order().get() < 0.0 {
            return Err(Failure::bad_input(format_args!(
                "{TOUCH_ORDER} {} is not in [0, 2]: a shape has no integral",
                self.law.order()
            )));
        }
        let shape = self.shape.of::<D>()?;
        let (t, horizon) = (self.sample_time(), horizon(samples));
        let touched = self.law.behind(shape, self.scheme, t, horizon)?;
        Ok((Controller::new(touched, self.chain()?), samples))
    }

    fn parts<const D: usize>(&self) -> Result<Parts<D>, Failure> {
        let t = self.sample_time();
        self.path.check(D)?;
        if let (Grip::Force, HandPath::Circle { .. }) = (self.grip, &self.path) {
            return Err(Failure::bad_input(format_args!(
                "a hand that is a force goes {TOUCH_WAY} in N: a circle is one of places; give those, or {hand_spring}",
                hand_spring = TOUCH_HAND.set_to("spring")
            )));
        }
        let (controller, samples) = self.loop_of::<D>()?;
        let shape = self.shape.of::<D>()?;
        let axes = Axes::new(self.axes_of::<D>()?).map_err(parameter)?;
        let device = HeldAxes::new(axes, (self.path.clone(), self.grip), shape, t.0);
        Ok(Parts {
            controller,
            device: self.sensors.before(device)?,
            samples,
        })
    }
}
