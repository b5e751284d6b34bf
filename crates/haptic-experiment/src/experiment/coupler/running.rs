//! The loop of a coupler: made of good parameters, tried alone, or run with a log.

use super::report::{CouplerCurves, CouplerReport};
use super::specification::CouplerExperiment;
use crate::document::failure::Failure;
use crate::document::parameters::{COUPLER_DISSIPATION, COUPLER_STIFFNESS, LOOP};
use crate::experiment::coupler::keys::{OBJECT_DAMPING, OBJECT_MASS, OBJECT_STIFFNESS};
use crate::experiment::trial;
use crate::experiment::trial::{Trial, TrialSetup, encoder_step};
use crate::judge::curves::Published;
use crate::judge::settling::Settling;
use crate::run::folder::FolderRequest;
use crate::run::preflight::{PreflightSubject, PreflightVerdict};
use crate::run::remote::{RemoteDevice, RemoteLaw};
use crate::run::safety::GuardChoice;
use crate::run::{Ran, Supervisor};
use fracdiff::{Operator, Order, Scheme};
use haptic_link::LoopMode;
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre, NewtonsPerMetre};
use haptic_loop::{Controller, VirtualCoupler, VirtualObject, deflection_order};

/// The coupler of an experiment.
pub(super) type Law = VirtualCoupler<f64, Operator<f64>>;
/// The coupler behind the safety chain and the device behind its sensors.
pub(super) type Parts = trial::Parts<Law>;

impl CouplerExperiment {
    /// Runs the experiment; log and CSV go into the folder.
    ///
    /// # Errors
    /// Bad parameters, before any file is made; a log or CSV that cannot be written.
    pub fn run(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Published<CouplerReport, CouplerCurves>, Failure> {
        self.check_loop()?;
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

    /// What the analysis says of it on the simulated device.
    ///
    /// # Errors
    /// Bad parameters.
    pub fn look(&self) -> Result<PreflightVerdict, Failure> {
        let samples = self.check()?;
        self.preflight(samples).verdict(self.setup.dynamics(), 0)
    }

    /// The number of samples, if all parameters are good.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn check(&self) -> Result<u64, Failure> {
        self.parts().map(|parts| parts.samples)
    }

    /// Refuses a loop on a device, which cannot carry it.
    ///
    /// # Errors
    /// If the loop is closed there.
    pub(crate) fn check_loop(&self) -> Result<(), Failure> {
        match self.setup.remote.as_ref().map(|remote| remote.loop_mode) {
            Some(LoopMode::Device) => Err(Failure::bad_input(format_args!(
                "a loop on the device cannot carry a coupler, its firmware renders walls: give {loop_host}",
                loop_host = LOOP.set_to("host")
            ))),
            _ => Ok(()),
        }
    }

    /// The coupler with its object, for a run of so many samples.
    pub(super) fn law(&self, samples: u64) -> Result<Law, Failure> {
        let t = self.setup.device.sample_time;
        let order = deflection_order(self.order).map_err(Failure::input)?;
        let horizon = crate::run::schedule::horizon(samples);
        let operator = self.scheme.build(order, t, horizon);
        let object = VirtualObject::new(
            Kilograms(self.object.mass_kg),
            NewtonSecondsPerMetre(self.object.damping_n_s_per_m),
            NewtonsPerMetre(self.object.stiffness_n_per_m),
        );
        let object = object.map_err(|error| {
            Failure::input_with_advice(
                error,
                format_args!("give {OBJECT_MASS}, {OBJECT_DAMPING} or {OBJECT_STIFFNESS} above 0"),
            )
        })?;
        VirtualCoupler::new(
            self.coupler_stiffness_n_s_per_m,
            self.coupler_dissipation_n_s_1_minus_mu_per_m,
            operator.map_err(Failure::input)?,
            object,
            t,
        )
        .map_err(|error| {
            Failure::input_with_advice(
                error,
                format_args!("give {COUPLER_STIFFNESS} or {COUPLER_DISSIPATION} above 0"),
            )
        })
    }
}

impl Trial for CouplerExperiment {
    type Law = Law;
    const KIND: &'static str = "coupler";
    const NO_REST: &'static str =
        "the coupler creeps or nothing holds the object, so there is no place of rest";

    fn setup(&self) -> &TrialSetup {
        &self.setup
    }

    fn setup_mut(&mut self) -> &mut TrialSetup {
        &mut self.setup
    }

    /// The analysis has its say here on the simulated device alone: a serial one heard it before it was armed.
    fn warning(&self, ran: &Ran) -> Option<String> {
        let analysis = ran.preflight.filter(|_| self.setup.remote.is_none());
        // Energy bounding promises passivity for the damping of the device.
        let guarded = self.setup.safety.guard == GuardChoice::EnergyBounding;
        analysis.and_then(|analysis| analysis.warning(guarded))
    }

    fn subject(&self, samples: u64) -> impl PreflightSubject {
        self.preflight(samples)
    }

    /// Only a loop on the host carries a coupler: the device renders nothing.
    fn law_there(&self, _: &RemoteDevice, _: u64) -> Result<RemoteLaw, Failure> {
        Ok(self.setup.law())
    }

    fn operator_choice(&self) -> (Order, Scheme) {
        (self.order, self.scheme)
    }

    fn law_in_numbers(&self) -> Vec<(&'static str, String)> {
        vec![
            (
                "coupler_stiffness_n_s_per_m",
                self.coupler_stiffness_n_s_per_m.to_string(),
            ),
            (
                "coupler_dissipation_n_s_1_minus_mu_per_m",
                self.coupler_dissipation_n_s_1_minus_mu_per_m.to_string(),
            ),
            ("object_mass_kg", self.object.mass_kg.to_string()),
            (
                "object_damping_n_s_per_m",
                self.object.damping_n_s_per_m.to_string(),
            ),
            (
                "object_stiffness_n_per_m",
                self.object.stiffness_n_per_m.to_string(),
            ),
        ]
    }

    fn parts(&self) -> Result<Parts, Failure> {
        let setup = &self.setup;
        let plan = setup.plan();
        let samples = plan.samples(self.setup.device.sample_time)?;
        let device = setup.sensed()?;
        let law = self.law(samples)?;
        let holding = self.holding_stiffness();
        // A coupler that creeps has no place of rest, whatever the hand: the force alone is judged.
        let spring = match holding > 0.0 {
            true => holding + self.setup.device.stiffness.0,
            false => 0.0,
        };
        let judge = plan.judge(
            (spring, law.step_stiffness_n_per_m()),
            encoder_step(self.setup.sensors),
            self.setup.device.sample_time.0,
        );
        Ok(Parts {
            controller: Controller::new(law, setup.chain()?),
            device,
            samples,
            judge,
            rest_m: (spring > 0.0).then(|| self.setup.plan.push_n / spring),
        })
    }
}
