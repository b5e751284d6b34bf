//! The loop of a wall: made of good parameters, tried alone, or run with a log.

use super::report::WallReport;
use super::specification::WallExperiment;
use crate::curves::{Published, WallCurves};
use crate::failure::Failure;
use crate::folder::FolderRequest;
use crate::preflight::PreflightRequest;
use crate::pushed::{VirtualWall, encoder_step, safe_force_limit, thrown, try_wall, wall_at_start};
use crate::refused::parameter;
use crate::remote::RemoteRun;
use crate::run::{Ran, Supervisor, run_logged};
use crate::schedule::Schedule;
use crate::sensed::Sensed;
use crate::settling::{Criterion, Judge, Settling};
use fracdiff::Operator;
use haptic_loop::plant::MassDamper;
use haptic_loop::units::Newtons;
use haptic_loop::{Controller, SafetyChain};

/// The wall behind the safety chain and the device behind its sensors: made of good parameters.
pub(super) struct Parts {
    pub(super) controller: Controller<f64, 1, VirtualWall>,
    pub(super) device: Sensed<MassDamper<1>>,
    pub(super) samples: u64,
    pub(super) judge: Judge,
    /// See [`Settling::expected_deflection_m`].
    pub(super) rest_m: Option<f64>,
}

impl WallExperiment {
    /// Runs the experiment; log and CSV go into the folder.
    ///
    /// # Errors
    /// Bad parameters, before any file is made; a log or CSV that cannot be written.
    pub fn run(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Published<WallReport, WallCurves>, Failure> {
        let parts = self.parts()?;
        let (judge, rest_m) = (parts.judge, parts.rest_m);
        let ran = self.record(parts, request, supervisor)?;
        let reported = self.publish(&ran, judge, rest_m)?;
        Ok(Published::new(reported, ran.folder))
    }

    /// Runs the loop and writes the log.
    fn record(
        &self,
        mut parts: Parts,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Ran, Failure> {
        let schedule = Schedule {
            samples: parts.samples,
            sample_time_s: self.device.sample_time.0,
            pace: self.pace,
        };
        let mut metadata = self.metadata();
        let preflight = self.preflight(parts.samples);
        match &self.remote {
            None => {
                // Nothing can break, so it is only noted.
                let verdict = preflight.verdict(self.dynamics(), 0)?;
                verdict.describe(&mut metadata);
                let ran = run_logged(
                    &mut parts.controller,
                    &mut parts.device,
                    schedule,
                    request,
                    metadata,
                    supervisor,
                )?;
                Ok(Ran {
                    preflight: Some(verdict),
                    ..ran
                })
            }
            Some(remote) => {
                let run = RemoteRun {
                    device: remote,
                    law: self.law(remote, parts.samples)?,
                    schedule,
                    reference: &|_| 0.0,
                    preflight: Some(preflight),
                    wanted: PreflightRequest {
                        force_unstable: self.force_unstable,
                        dynamics: Some(self.dynamics()),
                    },
                    request,
                    metadata,
                };
                run.run(&mut parts.controller, supervisor)
            }
        }
    }

    /// Runs without a report.
    #[cfg(test)]
    pub(crate) fn run_alone(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Ran, Failure> {
        self.record(self.parts()?, request, supervisor)
    }

    /// The same without log or files: does it settle, and without friction too?
    ///
    /// # Errors
    /// Bad parameters.
    pub fn try_out(&self) -> Result<Settling, Failure> {
        let settling = self.try_once()?;
        self.named(settling)
    }

    fn try_once(&self) -> Result<Settling, Failure> {
        let mut parts = self.parts()?;
        let (samples, judge) = (parts.samples, &mut parts.judge);
        let whole = try_wall(&mut parts.controller, &mut parts.device, samples, judge);
        Ok(judge.settling(whole, parts.rest_m))
    }

    /// The same judgement, unless friction alone holds the device: then it is called that.
    pub(super) fn named(&self, settling: Settling) -> Result<Settling, Failure> {
        let simulated = self.remote.is_none() && self.device.friction.0 > 0.0;
        if !(settling.stable && simulated && self.plan.criterion == Criterion::Settling) {
            return Ok(settling);
        }
        let mut smooth = self.clone();
        smooth.device.friction = Newtons(0.0);
        if smooth.try_once()?.stable {
            Ok(settling)
        } else {
            Ok(settling.by_friction())
        }
    }

    /// The number of samples, if all parameters are good.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn check(&self) -> Result<u64, Failure> {
        self.parts().map(|parts| parts.samples)
    }

    pub(super) fn parts(&self) -> Result<Parts, Failure> {
        let t = self.device.sample_time;
        if self.order.get() < 0.0 {
            return Err(Failure::bad_input(format_args!(
                "order {} is not in [0, 2]: a wall has no integral",
                self.order
            )));
        }
        let plan = self.plan();
        let samples = plan.samples(t)?;
        let device = Sensed::new(thrown(self.device, &plan)?, self.sensors)?;
        // A little more than needed, so that the last weights are not at the very edge.
        let operator: Operator<f64> = self
            .scheme
            .build(self.order, t, crate::schedule::horizon(samples))
            .map_err(Failure::input)?;
        let rate = t.rate_to_the(self.order).map_err(Failure::input)?;
        let judge = plan.judge(
            (
                self.stiffness_n_per_m + self.device.stiffness.0,
                self.dissipation_n_s_mu_per_m * rate,
            ),
            encoder_step(self.sensors),
            t.0,
        );
        let rest_m = self.expected_deflection(&operator)?;
        let wall = wall_at_start(
            self.stiffness_n_per_m,
            self.dissipation_n_s_mu_per_m,
            operator,
            self.one_sided,
        )
        .map_err(Failure::input)?;
        let chain = match &self.remote {
            None => {
                let limits = self.force_and_rate();
                let chain = safe_force_limit(limits, &self.device, self.sensors, &self.safety)?;
                self.safety.acts()?;
                chain
            }
            Some(_) => {
                let chain = SafetyChain::from_limits(&self.limits_here(), t).map_err(parameter)?;
                self.safety.acts_on_device()?;
                chain
            }
        };
        Ok(Parts {
            controller: Controller::new(wall, chain),
            device,
            samples,
            judge,
            rest_m,
        })
    }
}
