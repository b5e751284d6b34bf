//! A wall: a device hits it, is pushed into it with a constant force, and settles or not.
//!
//! ```text
//! m·x'' + b·x' + k·x = push + f,   f = −(K·x + B·D^μ x) through the safety chain,   x(0) = 0, x'(0) = impact
//! at rest: x = push/(K + k), and B beside K for μ = 0
//! ```
//! The wall is linear, as theory assumes, unless it is asked to push only. The rule by which a device is at
//! rest is that of [`settling`](super::settling). A device with friction that settles is tried again without:
//! if it then does not, friction alone holds it.
//!
//! Source: O. Tokatlı, *Fractional Order Control in Haptics*, section 4.4, figure 4.3.

mod report;

use super::judge::{Compared, full_history};
use super::kept::{Record, Samples, WHOLE_MOST};
use super::outcome::origin;
use super::preflight::{Dynamics, Preflight, PreflightRequest};
use super::pushed::{
    TrialPlan, VirtualWall, dynamics, encoder_step, force_alone, safe_force_limit, thrown,
    try_wall, wall_at_start,
};
use super::refused::parameter;
use super::remote::{
    Kept, RemoteDevice, RemoteLaw, RemoteRun, device_name, host_limits, no_operator, portable, push,
};
use super::report::{Errors, Files, RunReport, Warnings};
use super::run::{Ran, Supervisor, run_logged};
use super::safety::{GuardChoice, GuardedDevice, Safety};
use super::schedule::{Pace, Schedule};
use super::sensed::{Sensed, Sensors};
use super::settling::{Criterion, Judge, Settling};
use super::thinned::Thinned;
use super::track::{TOLERANCE, Track, operator};
use crate::curves::{Origin, Published, WallCurves};
use crate::failure::Failure;
use crate::folder::FolderRequest;
use crate::named::Named as _;
use fracdiff::full_memory::Kernel;
use fracdiff::{FrequencyResponse as _, Operator, Order, Scheme};
use haptic_link::{LoopMode, Simulation, SimulationKind};
use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_loop::units::{Newtons, NewtonsPerSecond};
use haptic_loop::{Controller, Limits, SafetyChain};
pub use report::WallReport;
use serde::Serialize;
use std::collections::BTreeMap;

/// A wall experiment.
#[derive(Clone, Debug)]
pub struct WallExperiment {
    /// The device, the hand that holds it, and what makes it less than ideal.
    pub device: MassDamperConfig,
    /// Its sensors.
    pub sensors: Sensors,
    /// μ, 0 to 2.
    pub order: Order,
    /// The operator.
    pub scheme: Scheme,
    /// K, N/m, at least 0.
    pub stiffness_n_per_m: f64,
    /// B, N·s^μ/m, at least 0.
    pub dissipation_n_s_mu_per_m: f64,
    /// A wall that pushes but never pulls.
    pub one_sided: bool,
    /// How it is tried and judged.
    pub plan: TrialPlan,
    /// A wall that is not stable by trial and analysis is a failure.
    pub must_be_stable: bool,
    /// Largest rate of the force, N/s; `None` for that of a serial device, and none on the simulated one.
    pub force_rate_limit_n_per_s: Option<f64>,
    /// What else the safety chain does.
    pub safety: Safety,
    /// How time passes.
    pub pace: Pace,
    /// The serial device; `None` for the simulated one.
    pub remote: Option<RemoteDevice>,
    /// Run on a serial device what the analysis calls unstable.
    pub force_unstable: bool,
}

/// A row of the CSV.
#[derive(Serialize)]
struct Row {
    time_s: f64,
    position_m: f64,
    reaction_force_n: f64,
}

/// What becomes of a run that reached its end.
struct Judged {
    csv: String,
    curves: Thinned<2>,
    /// See [`Errors::max_relative_error`].
    operator_error: Compared,
}

/// The wall behind the safety chain and the device behind its sensors: made of good parameters.
struct Parts {
    controller: Controller<f64, 1, VirtualWall>,
    device: Sensed<MassDamper<1>>,
    samples: u64,
    judge: Judge,
    /// See [`Settling::expected_deflection_m`].
    rest_m: Option<f64>,
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
    pub(super) fn run_alone(
        &self,
        request: &FolderRequest,
        supervisor: Supervisor<'_>,
    ) -> Result<Ran, Failure> {
        self.record(self.parts()?, request, supervisor)
    }

    /// Judges a run again.
    #[cfg(test)]
    pub(super) fn report(&self, ran: &Ran) -> Result<(WallReport, Option<WallCurves>), Failure> {
        let parts = self.parts()?;
        self.publish(ran, parts.judge, parts.rest_m)
    }

    /// The loop for the analysis.
    fn preflight(&self, samples: u64) -> Preflight {
        Preflight {
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
            order: self.order,
            scheme: self.scheme,
            sample_time_s: self.device.sample_time.0,
            samples,
        }
    }

    /// Device and hand.
    fn dynamics(&self) -> Dynamics {
        dynamics(&self.device)
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
    fn named(&self, settling: Settling) -> Result<Settling, Failure> {
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

    /// As it is really tried: a serial device cannot be thrown.
    fn plan(&self) -> TrialPlan {
        match self.remote {
            Some(_) => self.plan.from_rest(),
            None => self.plan,
        }
    }

    /// The number of samples, if all parameters are good.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn check(&self) -> Result<u64, Failure> {
        self.parts().map(|parts| parts.samples)
    }

    fn parts(&self) -> Result<Parts, Failure> {
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
                self.safety.acts()?;
                let limits = self.force_and_rate();
                safe_force_limit(limits, &self.device, self.sensors, &self.safety)?
            }
            Some(_) => SafetyChain::from_limits(&self.limits_here(), t).map_err(parameter)?,
        };
        Ok(Parts {
            controller: Controller::new(wall, chain),
            device,
            samples,
            judge,
            rest_m,
        })
    }

    fn force_and_rate(&self) -> Limits {
        let limits = force_alone(self.plan.force_limit_n, self.device.sample_time);
        Limits {
            rate: self
                .force_rate_limit_n_per_s
                .map_or(limits.rate, NewtonsPerSecond),
            ..limits
        }
    }

    /// Limits of the chain of a serial device, without its guard.
    fn limits_there(&self) -> Limits {
        let limits = self.safety.on(self.force_and_rate(), true);
        let delay = limits.device_delay_samples;
        self.safety.braked(limits, self.device.mass.0, delay)
    }

    /// Limits of the chain that runs here with a serial device: in a host loop the device does all but force
    /// and rate, and with its own loop this chain runs only to be checked.
    fn limits_here(&self) -> Limits {
        match &self.remote {
            Some(remote) if remote.loop_mode == LoopMode::Host => host_limits(&self.limits_there()),
            _ => self.limits_there(),
        }
    }

    /// The same wall and push for a serial device.
    fn law(&self, remote: &RemoteDevice, samples: u64) -> Result<RemoteLaw, Failure> {
        let MassDamperConfig {
            mass,
            damping,
            stiffness,
            delay,
            friction,
            lag,
            sample_time: t,
            saturation: _,
        } = self.device;
        if delay.0 > 0.0 || friction.0 > 0.0 || lag.0 > 0.0 {
            return Err(Failure::bad_input(
                "delay_s, friction_n and current_lag_s are of the simulated device: leave them away with a \
                 serial one, which has its own",
            ));
        }
        let operator = match remote.loop_mode {
            LoopMode::Device => {
                let horizon = crate::schedule::horizon(samples);
                let built = self.scheme.build(self.order, t, horizon);
                portable(&built.map_err(Failure::input)?)?
            }
            LoopMode::Host => no_operator(),
        };
        Ok(RemoteLaw {
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
            order: self.order.get(),
            one_sided: self.one_sided,
            operator,
            limits: self.limits_there(),
            kept: Kept {
                rate: self.force_rate_limit_n_per_s.is_none(),
                speed: self.safety.speed_limit_m_per_s.is_none(),
                rise: self.safety.rise_time_s.is_none(),
            },
            guard: (
                self.safety.guard,
                self.safety.guarded(GuardedDevice {
                    mass_kg: Some(mass.0),
                    damping_n_s_per_m: Some(damping.0),
                    ..GuardedDevice::default()
                }),
            ),
            simulation: Simulation {
                kind: SimulationKind::MassDamper,
                mass_kg: mass.0 as f32,
                damping_n_s_per_m: damping.0 as f32,
                hand_stiffness_n_per_m: stiffness.0 as f32,
                ..push(self.plan.push_n)
            },
        })
    }

    /// Judges a recorded run.
    ///
    /// # Errors
    /// A log that cannot be read.
    fn settling(
        &self,
        mut judge: Judge,
        ran: &Ran,
        rest_m: Option<f64>,
    ) -> Result<Settling, Failure> {
        Samples::of(&ran.record, &ran.log.paths).for_each(|sample| {
            judge.see(sample.time_s, sample.position_m, sample.force_n);
            Ok(())
        })?;
        self.named(judge.settling(ran.record.ended.is_none(), rest_m))
    }

    /// push/(K + k + B·T^(−μ)·P(1)), m: P(1), the gain of the operator at rest, is 1 for the identity, 0
    /// for a good derivative, and something else for one that forgets.
    ///
    /// # Errors
    /// A sample time outside its range.
    fn expected_deflection(&self, operator: &Operator<f64>) -> Result<Option<f64>, Failure> {
        let rate = self.device.sample_time.rate_to_the(self.order);
        let at_rest = operator.response(0.0).re * rate.map_err(Failure::input)?;
        let spring = self.stiffness_n_per_m
            + self.device.stiffness.0
            + self.dissipation_n_s_mu_per_m * at_rest;
        Ok(Some(self.plan.push_n / spring).filter(|x| x.is_finite() && spring > 0.0))
    }

    /// D^μ x by the full history of x, or why the force is not −(K·x + B·D^μ x) of it.
    fn derivative(&self, ran: &Ran) -> Result<Result<Track<'_>, &'static str>, Failure> {
        let record = &ran.record;
        let kernel = match self.scheme {
            Scheme::Full { kernel, .. } => kernel,
            _ => Kernel::Grunwald,
        };
        let reason = if self.one_sided {
            Some("a one-sided wall is not compared")
        } else if record.limited > 0 {
            Some("the safety chain limited the force")
        } else if kernel != Kernel::Grunwald && self.order.get() >= 1.0 {
            Some("the weights of this kernel are known in closed form below order 1 only")
        } else if record.largest_force_n() == 0.0 {
            Some("no force was commanded")
        } else {
            None
        };
        if let Some(reason) = reason {
            return Ok(Err(reason));
        }
        let t = self.device.sample_time;
        let samples = Samples::of(&ran.record, &ran.log.paths);
        let derivative = Track::new(
            samples,
            |x| full_history(kernel, self.order, t, x).map_err(Failure::Run),
            || {
                let planned = self.plan().samples(t)?;
                let mut channel = operator(kernel, self.order, t, planned)?;
                Ok(Box::new(move |_, x| channel.step(x)))
            },
        )?;
        Ok(Ok(derivative))
    }

    /// Mean deflection over the window at the end against push/(K + k).
    fn deflection_error(&self, record: &Record, settling: Settling) -> Compared {
        let t = self.device.sample_time.0;
        let judged = ((self.plan.window_s / t).round() as u64).min(record.samples);
        let to_s = record.duration_s();
        let from_s = to_s - judged.saturating_sub(1) as f64 * t;
        match (settling.deflection_m, settling.expected_deflection_m) {
            (Some(have), Some(want)) if settling.stable => {
                Compared::of_window((have / want - 1.0).abs(), [from_s, to_s], judged)
            }
            (Some(_), None) => Compared::without_meaning(
                "no spring holds the push, so there is no place of rest".to_owned(),
            ),
            _ => Compared::without_meaning("the wall did not come to rest".to_owned()),
        }
    }

    fn publish(
        &self,
        ran: &Ran,
        judge: Judge,
        rest_m: Option<f64>,
    ) -> Result<(WallReport, Option<WallCurves>), Failure> {
        let Ran { record, folder, .. } = ran;
        let whole = record.ended.is_none();
        let settling = self.settling(judge, ran, rest_m)?;
        let agrees =
            (ran.preflight.filter(|_| whole)).map(|analysis| analysis.stable == settling.stable);
        let mut warnings = Warnings::default();
        match settling.reason() {
            None => warnings.limited(record.limited),
            Some(reason) if whole => warnings.0.push(format!(
                "the wall is {}: {reason}",
                settling.verdict.words()
            )),
            Some(_) => {}
        }
        if agrees == Some(false) {
            warnings.0.push(format!(
                "trial and analysis disagree: {} by the trial, {} by the analysis; {}",
                settling.verdict.words(),
                if settling.stable { "unstable" } else { "stable" },
                if settling.stable {
                    "what the analysis does not know (friction, encoder, force limit) holds the device, or the \
                     wall grows unstable more slowly than the trial lasts"
                } else {
                    "what the analysis does not know (encoder, force limit, a wall that only pushes) shakes the \
                     device, or the wall settles more slowly than the trial lasts"
                }
            ));
        }
        let mut files = Files::default();
        let mut curves = None;
        let mut operator_error = Compared::without_meaning("the run was cut short".to_owned());
        if whole {
            let judged = self.judge(ran)?;
            operator_error = judged.operator_error;
            files.csv = Some(judged.csv);
            curves = Some(self.drawn(origin(record), judged.curves, settling));
        } else {
            folder.remove_stale_results();
        }
        let report = WallReport {
            tissue: None,
            order: self.order.get(),
            scheme: self.scheme.to_string(),
            run: RunReport::new(
                ran,
                device_name(self.remote.as_ref()),
                self.device.sample_time.0,
                files,
                warnings,
            ),
            errors: Errors::new(operator_error, self.deflection_error(record, settling)),
            reference_tolerance: record.whole.is_none().then_some(TOLERANCE),
            settling,
            analysis_agrees: agrees,
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
        };
        Ok((report, curves))
    }

    /// Writes the table of a run that reached its end, and holds each force against theory.
    fn judge(&self, ran: &Ran) -> Result<Judged, Failure> {
        let record = &ran.record;
        let mut derivative = self.derivative(ran)?;
        let mut table = ran.folder.table_beside_log("csv")?;
        let dense = if record.whole.is_some() {
            WHOLE_MOST
        } else {
            0
        };
        let mut curves = Thinned::new(dense);
        let mut off: f64 = 0.0;
        Samples::of(record, &ran.log.paths).for_each(|sample| {
            let (x, reaction_force_n) = (sample.position_m, sample.reaction_n());
            if let Ok(derivative) = &mut derivative {
                let d = derivative.at(sample);
                let wanted = -(self.stiffness_n_per_m * x + self.dissipation_n_s_mu_per_m * d);
                off = off.max((sample.force_n - wanted).abs());
            }
            curves.add(sample.time_s, [x, reaction_force_n]);
            table.row(&Row {
                time_s: sample.time_s,
                position_m: x,
                reaction_force_n,
            })
        })?;
        curves.finish();
        let operator_error = match derivative {
            Ok(_) => Compared::of_window(
                off / record.largest_force_n(),
                [0.0, record.duration_s()],
                record.samples,
            ),
            Err(reason) => Compared::without_meaning(reason.to_owned()),
        };
        Ok(Judged {
            csv: table.finish()?,
            curves,
            operator_error,
        })
    }

    /// The curves, and what to say of them.
    fn drawn(&self, origin: Origin, curves: Thinned<2>, settling: Settling) -> WallCurves {
        let subtitle = format!(
            "order μ = {} · K = {} N/m · B = {} N·s^μ/m · device {} · scheme {} · push {} N · {}",
            self.order,
            six_digits(self.stiffness_n_per_m),
            six_digits(self.dissipation_n_s_mu_per_m),
            device_name(self.remote.as_ref()),
            self.scheme,
            self.plan.push_n,
            settling.verdict.words()
        ) + &match self.safety.guard {
            GuardChoice::Off => String::new(),
            guard => format!(" · guard {}", guard.name()),
        };
        let [position_m, force_n] = curves.curves;
        WallCurves {
            subtitle,
            origin,
            expected_deflection_m: settling.expected_deflection_m,
            time_s: curves.time_s,
            position_m,
            force_n,
        }
    }

    /// Everything needed to repeat the run.
    fn metadata(&self) -> BTreeMap<String, String> {
        let (device, plan) = (&self.device, self.plan());
        let entries = [
            ("experiment", "wall".to_owned()),
            ("device", device_name(self.remote.as_ref())),
            ("mass_kg", device.mass.0.to_string()),
            ("damping_n_s_per_m", device.damping.0.to_string()),
            ("hand_stiffness_n_per_m", device.stiffness.0.to_string()),
            ("sample_time_s", device.sample_time.0.to_string()),
            ("delay_s", device.delay.0.to_string()),
            ("friction_n", device.friction.0.to_string()),
            ("current_lag_s", device.lag.0.to_string()),
            (
                "encoder_resolution_m",
                self.sensors.encoder_resolution_m.to_string(),
            ),
            ("sensor_noise_m", self.sensors.noise_m.to_string()),
            ("seed", self.sensors.seed.to_string()),
            ("order", self.order.to_string()),
            ("scheme", self.scheme.to_string()),
            ("stiffness_n_per_m", self.stiffness_n_per_m.to_string()),
            (
                "dissipation_n_s_mu_per_m",
                self.dissipation_n_s_mu_per_m.to_string(),
            ),
            ("one_sided", self.one_sided.to_string()),
            ("criterion", plan.criterion.name().name().to_owned()),
            ("impact_m_per_s", plan.impact_m_per_s.to_string()),
            ("push_n", plan.push_n.to_string()),
            ("duration_s", plan.duration_s.to_string()),
            ("window_s", plan.window_s.to_string()),
            ("force_limit_n", plan.force_limit_n.to_string()),
            ("pace", self.pace.to_string()),
        ];
        let mut metadata: BTreeMap<String, String> =
            entries.map(|(key, value)| (key.to_owned(), value)).into();
        if let Criterion::Dissertation { threshold_m } = plan.criterion {
            metadata.insert("threshold_m".to_owned(), threshold_m.to_string());
        }
        self.safety.describe(&mut metadata);
        metadata
    }
}

/// To six significant digits, as a subtitle shows a number.
fn six_digits(value: f64) -> f64 {
    // What a format made of a number is a number.
    format!("{value:.5e}").parse().unwrap_or(value)
}
