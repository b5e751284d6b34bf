//! A wall that a device hits and is pushed into.

use super::reading::{remote, scheme};
use super::trial::{
    Judged, Parts, TRIAL, TRIAL_LOOP, Theory, Trial, TrialReport, TrialSetup, VirtualWall,
    encoder_step, incomparable, setup, six_digits, times, wall_at_start,
};
use crate::document::error::FileError;
use crate::document::failure::Failure;
use crate::document::parameters::kind::{Parameter, joined, parameters};
use crate::document::parameters::range::{DISSIPATIONS, STIFFNESSES, WALL_ORDERS};
use crate::document::parameters::{
    DAMPING, DEVICE_MODEL, HAND_STIFFNESS, LESS_THAN_IDEAL, MASS, SAMPLE_TIME,
};
use crate::document::reader::Table;
use crate::judge::Reference;
use crate::judge::preflight::Preflight;
use crate::run::Ran;
use crate::run::preflight::{PreflightSubject, PreflightVerdict};
use crate::run::remote::{RemoteDevice, RemoteLaw, portable};
use crate::run::samples::Samples;
use fracdiff::{FrequencyResponse as _, Operator, Order, Scheme};
use haptic_link::LoopMode;
use haptic_loop::Controller;
use haptic_tissue::Model;
use serde::Serialize;

parameters! {
    /// Order of a wall.
    ORDER = optional("order", WALL_ORDERS, "Order of the dissipation: 0 a spring, 1 a damper");
    /// Stiffness of a wall, N/m.
    STIFFNESS = optional("stiffness_n_per_m", STIFFNESSES, "Stiffness K of the wall");
    /// Dissipation of a wall, N·s^μ/m.
    DISSIPATION = optional("dissipation_n_s_mu_per_m", DISSIPATIONS, "Dissipation B of the wall, N·s^μ/m");
    /// True if a wall only pushes.
    ONE_SIDED = flag("one_sided", "Push but never pull; otherwise the wall is linear, as the analysis assumes");
    /// True if an unstable wall is a failure.
    MUST_BE_STABLE = flag("must_be_stable", "Fail unless trial and analysis call the wall stable");
}

/// Of `[wall]` that have to be given in a file.
pub(crate) const WALL_REQUIRED: &[Parameter] =
    &[MASS, DAMPING, SAMPLE_TIME, ORDER, STIFFNESS, DISSIPATION];

/// Of `[wall]`, with defaults.
pub(crate) const WALL: &[Parameter] = &joined::<19>(&[
    &[DEVICE_MODEL, HAND_STIFFNESS],
    LESS_THAN_IDEAL,
    TRIAL_LOOP,
    &[ONE_SIDED],
    TRIAL,
    &[MUST_BE_STABLE],
]);

/// A wall experiment.
#[derive(Clone, Debug)]
pub(crate) struct WallExperiment {
    /// Device, trial, safety and pace.
    pub setup: TrialSetup,
    /// μ, 0 to 2.
    pub order: Order,
    /// The model whose memory the operator is, for slow motion of the order μ; `None` for D^μ.
    pub model: Option<Model>,
    /// The operator.
    pub scheme: Scheme,
    /// K, N/m, at least 0.
    pub stiffness_n_per_m: f64,
    /// B, N·s^μ/m, at least 0.
    pub dissipation_n_s_mu_per_m: f64,
    /// A wall that pushes but never pulls.
    pub one_sided: bool,
}

/// The result. The mean deflection is compared with push/(K + k); the force of a one-sided wall is not compared.
#[derive(Clone, Debug, Serialize)]
pub struct WallReport {
    /// K, N/m.
    pub stiffness_n_per_m: f64,
    /// B, N·s^μ/m.
    pub dissipation_n_s_mu_per_m: f64,
    /// Of the trial.
    #[serde(flatten)]
    pub trial: TrialReport,
}

/// `[wall]`: device, wall and trial.
pub(crate) fn wall(table: &Table<'_>) -> Result<WallExperiment, FileError> {
    let remote = remote(table)?;
    let (sample_time_s, duration_s) = times(table)?;
    let order = table.required(&ORDER)?;
    let order = Order::new(order).map_err(|error| table.fail_at("order", error.to_string()))?;
    let mut setup = setup(table, remote, (sample_time_s, duration_s))?;
    setup.must_be_stable = table.flag(&MUST_BE_STABLE)?;
    let scheme = scheme(table, None, order, sample_time_s, duration_s)?;
    let gains = (table.required(&STIFFNESS)?, table.required(&DISSIPATION)?);
    let wall = WallExperiment {
        one_sided: table.flag(&ONE_SIDED)?,
        ..WallExperiment::linear(setup, (order, scheme), gains)
    };
    (wall.check()).map_err(|error| table.fail(error.to_string()))?;
    Ok(wall)
}

impl WallExperiment {
    /// A linear wall of K in N/m and B in N·s^μ/m, and nothing else.
    pub(crate) const fn linear(
        setup: TrialSetup,
        (order, scheme): (Order, Scheme),
        (stiffness_n_per_m, dissipation_n_s_mu_per_m): (f64, f64),
    ) -> Self {
        Self {
            setup,
            order,
            model: None,
            scheme,
            stiffness_n_per_m,
            dissipation_n_s_mu_per_m,
            one_sided: false,
        }
    }

    fn look(&self, samples: u64) -> Preflight<'_> {
        Preflight {
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
            order: self.order,
            model: self.model.as_ref(),
            scheme: self.scheme,
            sample_time_s: self.setup.device.sample_time.0,
            samples,
            map: None,
        }
    }

    /// push/(K + k + B·T^(−μ)·P(1)), m: P(1), the gain of the operator at rest, is 1 for the identity, 0
    /// for a good derivative, and something else for one that forgets.
    fn expected_deflection(&self, operator: &Operator<f64>) -> Result<Option<f64>, Failure> {
        let rate = self.setup.device.sample_time.rate_to_the(self.order);
        let at_rest = operator.response(0.0).re * rate.map_err(Failure::input)?;
        let spring = self.stiffness_n_per_m
            + self.setup.device.stiffness.0
            + self.dissipation_n_s_mu_per_m * at_rest;
        Ok(Some(self.setup.plan.push_n / spring).filter(|x| x.is_finite() && spring > 0.0))
    }
}

impl Trial for WallExperiment {
    type Law = VirtualWall;
    type Report = WallReport;
    const KIND: &'static str = "wall";
    const NO_REST: &'static str = "no spring holds the push, so there is no place of rest";

    fn setup(&self) -> &TrialSetup {
        &self.setup
    }

    fn setup_mut(&mut self) -> &mut TrialSetup {
        &mut self.setup
    }

    fn subject(&self, samples: u64) -> impl PreflightSubject<Findings = PreflightVerdict> {
        self.look(samples)
    }

    fn law_there(&self, remote: &RemoteDevice, samples: u64) -> Result<RemoteLaw, Failure> {
        let law = self.setup.law();
        let operator = match remote.loop_mode {
            LoopMode::Device => portable(&self.look(samples).operator()?)?,
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

    fn law_in_words(&self) -> String {
        format!(
            "order μ = {} · K = {} N/m · B = {} N·s^μ/m",
            self.order,
            six_digits(self.stiffness_n_per_m),
            six_digits(self.dissipation_n_s_mu_per_m)
        )
    }

    fn parts(&self) -> Result<Parts<VirtualWall>, Failure> {
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
        let operator = self.look(samples).operator()?;
        let rate = t.rate_to_the(self.order).map_err(Failure::input)?;
        let (k, b) = (self.stiffness_n_per_m, self.dissipation_n_s_mu_per_m);
        let judge = plan.judge(
            (k + self.setup.device.stiffness.0, k + b * rate),
            encoder_step(self.setup.sensors),
            t.0,
        );
        let rest_m = self.expected_deflection(&operator)?;
        let wall = wall_at_start(k, b, operator, self.one_sided).map_err(Failure::input)?;
        Ok(Parts {
            controller: Controller::new(wall, self.setup.chain()?),
            device,
            samples,
            judge,
            rest_m,
        })
    }

    /// The force is −(K·x + B·D^μ x) by the full history of x.
    fn theory(&self, ran: &Ran) -> Result<Theory<'_>, Failure> {
        let kernel = Reference::of(self.scheme);
        let reason = (self.one_sided.then_some("a one-sided wall is not compared"))
            .or_else(|| incomparable(kernel, self.order, &ran.record));
        if let Some(reason) = reason {
            return Ok(Theory {
                off_n: Err(reason),
                object_m: None,
            });
        }
        let planned = self.setup.plan().samples(self.setup.device.sample_time)?;
        let samples = Samples::of(&ran.record, &ran.log.paths);
        let mut derivative = self.look(planned).felt_of(samples)?;
        Ok(Theory {
            off_n: Ok(Box::new(move |sample| {
                let (x, d) = (sample.position_m, derivative.at(sample));
                let wanted = -(self.stiffness_n_per_m * x + self.dissipation_n_s_mu_per_m * d);
                (sample.force_n - wanted).abs()
            })),
            object_m: None,
        })
    }

    fn reported(&self, judged: &Judged) -> WallReport {
        WallReport {
            trial: judged.trial.clone(),
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
        }
    }
}
