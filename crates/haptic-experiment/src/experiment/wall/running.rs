//! The loop of a wall: made of good parameters, tried alone, or run with a log.

use super::report::{WallCurves, WallReport};
use super::specification::WallExperiment;
use crate::document::failure::Failure;
use crate::experiment::trial;
use crate::experiment::trial::{Trial, TrialSetup, VirtualWall, encoder_step, wall_at_start};
use crate::judge::curves::Published;
use crate::judge::modelled_tissue::operator;
use crate::judge::settling::Settling;
use crate::run::folder::FolderRequest;
use crate::run::preflight::PreflightSubject;
use crate::run::remote::{RemoteDevice, RemoteLaw, portable};
use crate::run::{Ran, Supervisor};
use fracdiff::{Operator, Order, Real, Scheme};
use haptic_link::LoopMode;
use haptic_loop::Controller;

/// The wall behind the safety chain and the device behind its sensors.
pub(super) type Parts = trial::Parts<VirtualWall>;

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
        let report = |ran: &Ran, judge, rest_m| self.publish(ran, judge, rest_m);
        self.published(request, supervisor, report)
    }

    /// The same without log or files: does it settle, and without friction too?
    ///
    /// # Errors
    /// Bad parameters.
    pub fn try_out(&self) -> Result<Settling, Failure> {
        self.named(self.tried()?)
    }

    /// The number of samples, if all parameters are good.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn check(&self) -> Result<u64, Failure> {
        self.parts().map(|parts| parts.samples)
    }

    /// The operator, for so many samples.
    pub(super) fn operator<F: Real>(&self, samples: u64) -> Result<Operator<F>, Failure> {
        let t = self.setup.device.sample_time;
        // A little more than needed, so that the last weights are not at the very edge.
        let horizon = crate::run::schedule::horizon(samples);
        operator(self.model.as_ref(), self.scheme, self.order, t, horizon)
    }
}

impl Trial for WallExperiment {
    type Law = VirtualWall;
    const KIND: &'static str = "wall";
    const NO_REST: &'static str = "no spring holds the push, so there is no place of rest";

    fn setup(&self) -> &TrialSetup {
        &self.setup
    }

    fn setup_mut(&mut self) -> &mut TrialSetup {
        &mut self.setup
    }

    fn subject(&self, samples: u64) -> impl PreflightSubject {
        self.preflight(samples)
    }

    fn law_there(&self, remote: &RemoteDevice, samples: u64) -> Result<RemoteLaw, Failure> {
        let law = self.setup.law();
        let operator = match remote.loop_mode {
            LoopMode::Device => portable(&self.operator(samples)?)?,
            LoopMode::Host => law.operator,
        };
        Ok(RemoteLaw {
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
            order: self.order.get(),
            one_sided: self.one_sided,
            operator,
            ..law
        })
    }

    fn operator_choice(&self) -> (Order, Scheme) {
        (self.order, self.scheme)
    }

    fn law_in_numbers(&self) -> Vec<(&'static str, String)> {
        vec![
            ("stiffness_n_per_m", self.stiffness_n_per_m.to_string()),
            (
                "dissipation_n_s_mu_per_m",
                self.dissipation_n_s_mu_per_m.to_string(),
            ),
            ("one_sided", self.one_sided.to_string()),
        ]
    }

    fn parts(&self) -> Result<Parts, Failure> {
        let t = self.setup.device.sample_time;
        if self.order.get() < 0.0 {
            return Err(Failure::bad_input(format_args!(
                "order {} is not in [0, 2]: a wall has no integral",
                self.order
            )));
        }
        let plan = self.setup.plan();
        let samples = plan.samples(t)?;
        let device = self.setup.sensed()?;
        let operator = self.operator::<f64>(samples)?;
        let rate = t.rate_to_the(self.order).map_err(Failure::input)?;
        let judge = plan.judge(
            (
                self.stiffness_n_per_m + self.setup.device.stiffness.0,
                self.dissipation_n_s_mu_per_m * rate,
            ),
            encoder_step(self.setup.sensors),
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
        let chain = self.setup.chain()?;
        Ok(Parts {
            controller: Controller::new(wall, chain),
            device,
            samples,
            judge,
            rest_m,
        })
    }
}
