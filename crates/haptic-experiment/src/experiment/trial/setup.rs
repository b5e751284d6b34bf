//! All of an experiment on a pushed device but the law that it feels: what a wall and a coupler share.

use super::{TrialPlan, delay_ticks, dynamics, force_alone, safe_force_limit, thrown, try_out};
use crate::document::advice::parameter;
use crate::document::failure::Failure;
use crate::judge::Compared;
use crate::judge::settling::{Criterion, Judge, Settling};
use crate::run::folder::FolderRequest;
use crate::run::preflight::{PreflightRequest, PreflightSubject};
use crate::run::record::Record;
use crate::run::remote::{RemoteDevice, RemoteLaw, RemoteRun, blank, held, host_limits};
use crate::run::safety::{GuardedDevice, Safety};
use crate::run::samples::Samples;
use crate::run::schedule::{Pace, Schedule};
use crate::run::sensors::Sensors;
use crate::run::simulate::Simulated;
use crate::run::{Ran, Supervisor, run_logged};
use fracdiff::parameter::Shown;
use haptic_analysis::Dynamics;
use haptic_link::LoopMode;
use haptic_loop::plant::{MassDamper, MassDamperConfig, Sensed};
use haptic_loop::units::{Newtons, NewtonsPerSecond};
use haptic_loop::{Controller, Environment, Limits, SafetyChain};
use std::collections::BTreeMap;

/// All of an experiment on a pushed device but the law that it feels.
#[derive(Clone, Debug)]
pub struct TrialSetup {
    /// The device, the hand that holds it, and what makes it less than ideal: simulated here, or known of a serial one.
    pub device: MassDamperConfig,
    /// Its sensors.
    pub sensors: Sensors,
    /// Plan of the trial.
    pub plan: TrialPlan,
    /// A trial that does not end well is a failure: one that is not stable by itself and by the analysis, or a coupler that
    /// Llewellyn refuses.
    pub must_be_stable: bool,
    /// Largest rate of the force, N/s; `None` for that of a serial device, and none on the simulated one.
    pub force_rate_limit_n_per_s: Option<f64>,
    /// Further settings of the safety chain.
    pub safety: Safety,
    /// Pace of time.
    pub pace: Pace,
    /// The serial device; `None` for the simulated one.
    pub remote: Option<RemoteDevice>,
    /// The speed of the impact was asked for: of a serial device, which cannot be thrown, it is warned then.
    pub impact_was_given: bool,
    /// What its device file says for the guard of a serial device.
    pub known: GuardedDevice,
    /// Run on a serial device what the analysis refuses.
    pub force_unstable: bool,
}

/// A loop made of good parameters: the law behind the safety chain, and the device behind its sensors.
pub(crate) struct Parts<E: Environment<f64, 1>> {
    pub(crate) controller: Controller<f64, 1, E>,
    pub(crate) device: Sensed<MassDamper<1>>,
    pub(crate) samples: u64,
    pub(crate) judge: Judge,
    /// See [`Settling::expected_deflection_m`].
    pub(crate) rest_m: Option<f64>,
}

impl<E: Environment<f64, 1>> Parts<E> {
    /// Runs it without log or files.
    pub(crate) fn try_out(&mut self) -> Settling {
        let Self {
            controller,
            device,
            samples,
            judge,
            rest_m,
        } = self;
        let whole = try_out(controller, device, *samples, judge);
        judge.settling(whole, *rest_m)
    }
}

impl TrialSetup {
    /// A trial of a simulated device in virtual time, that may end as it will, with the force limit alone.
    #[must_use]
    pub fn new(device: MassDamperConfig, sensors: Sensors, plan: TrialPlan) -> Self {
        Self {
            device,
            sensors,
            plan,
            must_be_stable: false,
            force_rate_limit_n_per_s: None,
            safety: Safety::default(),
            pace: Pace::Virtual,
            remote: None,
            impact_was_given: false,
            known: GuardedDevice::default(),
            force_unstable: false,
        }
    }

    /// Device and hand, as the analysis knows them, wherever the device is.
    pub(crate) fn dynamics(&self) -> Dynamics {
        dynamics(&self.device)
    }

    /// Settings of the safety chain: on a serial device with what its file says.
    pub(super) fn safety(&self) -> Safety {
        match self.remote {
            Some(_) => self.safety.with_device(&self.known, true),
            None => self.safety,
        }
    }

    /// As it is really tried: a serial device cannot be thrown.
    pub(crate) fn plan(&self) -> TrialPlan {
        match self.remote {
            Some(_) => self.plan.starting_at_rest(),
            None => self.plan,
        }
    }

    /// What to say of an impact that was asked for and that there was none of.
    pub(super) fn not_thrown(&self) -> Option<String> {
        let impact_m_per_s = self.plan.impact_m_per_s;
        let asked = self.impact_was_given && self.remote.is_some() && impact_m_per_s > 0.0;
        asked.then(|| {
            format!(
                "impact_m_per_s = {} had no effect: a serial device cannot be thrown, it was pushed from rest; leave it away",
                Shown(impact_m_per_s)
            )
        })
    }

    /// The device behind its sensors, pushed and thrown.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub(crate) fn sensed(&self) -> Result<Sensed<MassDamper<1>>, Failure> {
        self.sensors.before(thrown(self.device, &self.plan())?)
    }

    /// The safety chain of the loop that runs here.
    ///
    /// # Errors
    /// A limit outside its range; settings that would have no effect.
    pub(crate) fn chain(&self) -> Result<SafetyChain<f64>, Failure> {
        let t = self.device.sample_time;
        if self.remote.is_some() {
            let chain = SafetyChain::from_limits(&self.limits_here(), t).map_err(parameter)?;
            self.safety().acts_on_device()?;
            return Ok(chain);
        }
        let limits = self.force_and_rate();
        let chain = safe_force_limit(limits, &self.device, self.sensors, &self.safety)?;
        self.safety.acts()?;
        Ok(chain)
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
        let safety = self.safety();
        let limits = safety.on(self.force_and_rate(), true);
        let delay = limits.device_delay_samples.max(delay_ticks(&self.device));
        safety.braked(limits, self.device.mass.0, delay)
    }

    /// Limits of the chain that runs here with a serial device: in a host loop the device does all but force
    /// and rate, and with its own loop this chain runs only to be checked.
    fn limits_here(&self) -> Limits {
        match &self.remote {
            Some(remote) if remote.loop_mode == LoopMode::Host => host_limits(&self.limits_there()),
            _ => self.limits_there(),
        }
    }

    /// The push for a serial device, and no law at all: one of a loop on the host.
    pub(crate) fn law(&self) -> RemoteLaw {
        RemoteLaw::none(
            self.limits_there(),
            (self.force_rate_limit_n_per_s, &self.safety()),
            GuardedDevice::given(&self.device),
            held(&self.device, self.plan.push_n),
        )
    }

    /// Runs the loop and writes the log.
    ///
    /// # Errors
    /// Those of the run.
    pub(crate) fn record<E: Environment<f64, 1>, P: PreflightSubject>(
        &self,
        parts: &mut Parts<E>,
        preflight: P,
        law: impl FnOnce(&RemoteDevice) -> Result<RemoteLaw, Failure>,
        (request, mut metadata): (&FolderRequest, BTreeMap<String, String>),
        supervisor: Supervisor<'_>,
    ) -> Result<Ran, Failure> {
        let dynamics = self.dynamics();
        let schedule = Schedule {
            samples: parts.samples,
            sample_time_s: self.device.sample_time.0,
            pace: self.pace,
        };
        let Some(remote) = &self.remote else {
            // Nothing can break, so it is only noted.
            let verdict = preflight.verdict(dynamics, 0)?;
            verdict.describe(&mut metadata);
            let mut world = Simulated::new(&mut parts.controller, &mut parts.device);
            let ran = run_logged(&mut world, schedule, (request, metadata), supervisor)?;
            return Ok(Ran {
                preflight: Some(verdict),
                ..ran
            });
        };
        let run = RemoteRun {
            device: remote,
            law: law(remote)?,
            schedule,
            blank: &|_| blank(0.0),
            preflight: Some(preflight),
            wanted: PreflightRequest {
                force_unstable: self.force_unstable,
                dynamics: Some(dynamics),
            },
            request,
            metadata,
        };
        run.run(&mut parts.controller, supervisor)
    }

    /// Judges a recorded run.
    ///
    /// # Errors
    /// A log that cannot be read.
    pub(super) fn settling(
        mut judge: Judge,
        ran: &Ran,
        rest_m: Option<f64>,
    ) -> Result<Settling, Failure> {
        Samples::of(&ran.record, &ran.log.paths).for_each(|sample| {
            judge.see(sample.time_s, sample.position_m, sample.force_n);
            Ok(())
        })?;
        Ok(judge.settling(ran.record.ended.is_none(), rest_m))
    }

    /// The same without friction, if that could be all that holds the device.
    pub(super) fn smooth(&self) -> Option<Self> {
        let simulated = self.remote.is_none() && self.device.friction.0 > 0.0;
        (simulated && self.plan.criterion == Criterion::Settling).then(|| {
            let mut smooth = self.clone();
            smooth.device.friction = Newtons(0.0);
            smooth
        })
    }

    /// First and last time of the window that is verdict, s, and its samples.
    fn window(&self, record: &Record) -> ([f64; 2], u64) {
        let t = self.device.sample_time.0;
        let judged = ((self.plan.window_s / t).round() as u64).min(record.samples);
        let to_s = record.duration_s();
        ([to_s - judged.saturating_sub(1) as f64 * t, to_s], judged)
    }

    /// Mean deflection over the window at the end against the place of rest.
    pub(super) fn deflection_error(
        &self,
        record: &Record,
        settling: Settling,
        what: &str,
        no_rest: &str,
    ) -> Compared {
        let (window_s, judged) = self.window(record);
        match (settling.deflection_m, settling.expected_deflection_m) {
            (Some(have), Some(want)) if settling.stable => {
                Compared::of_window((have / want - 1.0).abs(), window_s, judged)
            }
            (Some(_), None) => Compared::without_meaning(no_rest.to_owned()),
            _ => Compared::without_meaning(format!("the {what} did not come to rest")),
        }
    }
}
