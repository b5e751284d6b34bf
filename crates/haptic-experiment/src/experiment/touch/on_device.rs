//! A touch on a device at a port: the shape is felt in a real hand, or in that of an emulated board.

use super::device::TouchTick;
use super::hand::{Grip, HandPath};
use super::report::{TouchCurves, TouchReport};
use super::specification::TouchExperiment;
use crate::document::failure::Failure;
use crate::document::parameters::{DEVICE, LOOP};
use crate::experiment::touch::keys::TOUCH_MUST_BE_PASSIVE;
use crate::judge::curves::Published;
use crate::run::Supervisor;
use crate::run::folder::FolderRequest;
use crate::run::preflight::PreflightRequest;
use crate::run::remote::{RemoteDevice, RemoteLaw, RemoteRun, held};
use crate::run::safety::GuardedDevice;
use crate::run::schedule::Schedule;
use haptic_analysis::Dynamics;
use haptic_link::LoopMode;

impl TouchExperiment {
    /// Refuses what a device at a port cannot do.
    ///
    /// # Errors
    /// A loop on the device; a question for the simulated device alone; a box that the arms of a 2DIY do not reach.
    pub(super) fn check_on<const D: usize>(&self, remote: &RemoteDevice) -> Result<(), Failure> {
        if remote.loop_mode == LoopMode::Device {
            return Err(Failure::bad_input(format_args!(
                "a loop on the device cannot carry a shape, it renders walls of one axis: give {loop_host}",
                loop_host = LOOP.set_to("host")
            )));
        }
        if self.must_be_passive {
            return Err(Failure::bad_input(format_args!(
                "{TOUCH_MUST_BE_PASSIVE} is for the simulated device, whose hand is known to the last joule: leave it out with {DEVICE}"
            )));
        }
        match self.plane().filter(|_| D == 2) {
            Some(plane) => self.reached(&plane).map(drop),
            None => Ok(()),
        }
    }

    /// Runs it there: the shape here, limits on both sides.
    ///
    /// # Errors
    /// A device that cannot be used, parameters that it refuses; a log or CSV that cannot be written.
    pub(super) fn run_on<const D: usize>(
        &self,
        remote: &RemoteDevice,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Published<TouchReport, TouchCurves>, Failure> {
        self.check_on::<D>(remote)?;
        let (mut controller, samples) = self.loop_of::<D>()?;
        let shape = self.shape.of::<D>()?;
        let postures = self.postures::<D>(samples)?;
        // A hand that may let go at any time counts as none.
        let dynamics = Dynamics {
            hand_stiffness_n_per_m: 0.0,
            ..self.dynamics()
        };
        let (_, posture) = postures.worse(dynamics, 0)?;
        let mut metadata = self.metadata();
        posture.describe(&mut metadata);
        let run = RemoteRun {
            device: remote,
            law: self.law_there()?,
            schedule: Schedule {
                samples,
                sample_time_s: self.sample_time().0,
                pace: self.pace,
            },
            blank: &|_| TouchTick::unknown(shape),
            preflight: Some(postures),
            wanted: PreflightRequest {
                force_unstable: self.force_unstable,
                dynamics: Some(dynamics),
            },
            request,
            metadata,
        };
        let ran = run.run(&mut controller, supervisor)?;
        let reported = self.publish::<D>(&ran, None, posture)?;
        Ok(Published::new(reported, ran.folder))
    }

    /// What the device is told: limits, no law, and the plant of an emulated one. Its hand is the one of the file as far as a board has
    /// one: a spring to 0, or a push along the first axis.
    fn law_there(&self) -> Result<RemoteLaw, Failure> {
        let push_n = match (self.grip, &self.path) {
            (Grip::Force, HandPath::WayPoints(rows)) => {
                let last = rows.last().and_then(|(_, force)| force.first());
                last.copied().unwrap_or(0.0)
            }
            _ => 0.0,
        };
        let lightest = self.axis(self.masses()[0]);
        Ok(RemoteLaw::none(
            self.limits_there()?,
            (self.force_rate_limit_n_per_s, &self.safety),
            GuardedDevice::given(&lightest),
            held(&lightest, push_n),
        ))
    }
}
