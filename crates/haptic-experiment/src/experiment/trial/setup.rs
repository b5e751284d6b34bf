//! All of an experiment on a pushed device but the law that it feels: what a wall and a coupler share.

use super::second::second;
use super::{Pushed, SecondDevice, no_law_there, safe_chain};
use crate::experiment::kind::Conduct;
use crate::experiment::reading::remote;
use fracdiff::parameter::Shown;
use haptic_analysis::Dynamics;
use haptic_document::{Failure, FileError, Table, parameters as p};
use haptic_judge::felt::Tally;
use haptic_judge::settling::{Criterion, Judge, Settling};
use haptic_judge::trial::{TRIAL_SAMPLES, TrialPlan, force_and_rate, plan, thrown, try_out};
use haptic_loop::plant::{MassDamperConfig, Sensed};
use haptic_loop::units::Newtons;
use haptic_loop::{Controller, Environment, SafetyChain, SafetyLimits};
use haptic_run::Ran;
use haptic_run::record::RunRecord;
use haptic_run::remote::RemoteLaw;
use haptic_trial::device_table::dynamics;
use haptic_trial::device_table::{device, device_model, samples_fit};
use haptic_trial::keys::trial::{IMPACT, PushBy, TRIAL_FORCE_RATE_LIMIT};
use haptic_trial::safety::{GuardChoice, GuardedDevice, Safety, safety};
use haptic_trial::{DeviceModel, Sensors};

/// All of an experiment on a pushed device but the law that it feels.
#[derive(Clone, Debug)]
pub(crate) struct TrialSetup {
    /// The device, its hand and its imperfections, simulated here or known for a serial device.
    pub device: MassDamperConfig,
    pub sensors: Sensors,
    pub plan: TrialPlan,
    /// The device that pushes it, if that is a second one.
    pub second: Option<SecondDevice>,
    /// True if the run fails when the trial or the analysis finds it unstable, or a coupler does
    /// not meet Llewellyn's criterion.
    pub must_be_stable: bool,
    /// Largest rate of the force, N/s; `None` keeps a serial device's own limit, and sets none on a
    /// simulated one.
    pub force_rate_limit_n_per_s: Option<f64>,
    /// Further settings of the safety chain.
    pub safety: Safety,
    pub conduct: Conduct,
    /// True if the impact speed was requested: a serial device cannot be thrown, so this then
    /// causes a warning.
    pub impact_was_given: bool,
    /// Values from its device file for the guard of a serial device.
    pub known: GuardedDevice,
}

/// A loop made of good parameters: the law behind the safety chain, and the device behind its sensors.
pub(crate) struct Parts<E: Environment<f64, 1>> {
    pub(crate) controller: Controller<f64, 1, E>,
    pub(crate) device: Sensed<Pushed>,
    pub(crate) samples: u64,
    pub(crate) judge: Judge,
    /// See [`Settling::expected_deflection_m`](haptic_judge::settling::Settling::expected_deflection_m).
    pub(crate) rest_m: Option<f64>,
}

impl<E: Environment<f64, 1>> Parts<E> {
    /// Runs the loop without log or files.
    pub(crate) fn tried(mut self) -> Settling {
        let (device, judge) = (&mut self.device, &mut self.judge);
        let whole = try_out(&mut self.controller, device, self.samples, judge);
        self.judge.settling(whole, self.rest_m)
    }
}

impl TrialSetup {
    /// A trial of a simulated device in virtual time, that may end as it will, with the force limit alone.
    pub(crate) fn new(device: MassDamperConfig, sensors: Sensors, plan: TrialPlan) -> Self {
        Self {
            device,
            sensors,
            plan,
            second: None,
            must_be_stable: false,
            force_rate_limit_n_per_s: None,
            safety: Safety::default(),
            conduct: Conduct::on(None),
            impact_was_given: false,
            known: GuardedDevice::default(),
        }
    }

    /// Device and hand, as the analysis knows them, wherever the device is; with a second device, which it touches, as one body.
    pub(crate) fn dynamics(&self) -> Dynamics {
        let first = dynamics(&self.device);
        let Some(second) = &self.second else {
            return first;
        };
        Dynamics {
            mass_kg: first.mass_kg + second.device.mass.0,
            damping_n_s_per_m: first.damping_n_s_per_m + second.device.damping.0,
            ..first
        }
    }

    /// Settings of the safety chain: on a serial device with what its file says.
    pub(super) fn safety(&self) -> Safety {
        match self.conduct.remote {
            Some(_) => self.safety.with_device(&self.known, true),
            None => self.safety,
        }
    }

    /// Plan of the trial as it is really tried: a serial device cannot be thrown.
    pub(crate) fn plan(&self) -> TrialPlan {
        match self.conduct.remote {
            Some(_) => self.plan.starting_at_rest(),
            None => self.plan,
        }
    }

    /// Place where the law began, m: 0, or where the handle stood if the device's own motor pushes.
    pub(super) fn start_m(&self, ran: &Ran) -> Result<f64, Failure> {
        let mut start_m = None;
        if self.plan.push_by == PushBy::Device {
            ran.samples().for_each(|sample| {
                start_m.get_or_insert(sample.position_m);
                Ok(())
            })?;
        }
        Ok(start_m.unwrap_or(0.0))
    }

    /// Sums over a run in the hand of a person, whose push nobody knows; `None` of a trial: on a simulated device, pushed by its own
    /// motor, or to be stable.
    pub(super) fn felt(&self, record: &RunRecord) -> Option<Tally> {
        let is_real = record.link.as_ref().is_some_and(|link| !link.simulated);
        let held = is_real && self.plan.push_by == PushBy::Hand && !self.must_be_stable;
        held.then(|| Tally::of(0, 0.0, None, self.device.sample_time))
    }

    /// Warning about a requested impact that had no effect.
    pub(super) fn not_thrown(&self) -> Option<String> {
        let impact_m_per_s = self.plan.impact_m_per_s;
        let asked = self.impact_was_given && self.conduct.remote.is_some() && impact_m_per_s > 0.0;
        asked.then(|| {
            format!(
                "impact_m_per_s = {} had no effect: a serial device cannot be thrown, it was pushed from rest; omit it",
                Shown(impact_m_per_s)
            )
        })
    }

    /// The device behind its sensors, pushed and thrown.
    pub(crate) fn sensed(&self) -> Result<Sensed<Pushed>, Failure> {
        let plan = self.plan();
        self.sensors.before(match &self.second {
            None => Pushed::Alone(Box::new(thrown(self.device, &plan)?)),
            Some(second) => {
                let pair = second.before(self.device, plan.push_n, &self.safety())?;
                Pushed::Pair(Box::new(pair))
            }
        })
    }

    /// The safety chain of the loop that runs here.
    pub(crate) fn chain(&self) -> Result<SafetyChain<f64>, Failure> {
        let (limits, safety) = (self.force_and_rate(), self.safety());
        safe_chain(limits, &self.device, self.sensors, &safety, &self.conduct)
    }

    fn force_and_rate(&self) -> SafetyLimits {
        let (force, rate) = (self.plan.force_limit_n, self.force_rate_limit_n_per_s);
        force_and_rate(force, rate, self.device.sample_time)
    }

    /// The push for a serial device, and no law at all: one of a loop on the host.
    pub(crate) fn law(&self) -> RemoteLaw {
        let push_n = self.plan.push_of_hand_n();
        RemoteLaw {
            held_push_n: self.plan.push_n,
            push: self.plan.push_of_motor(),
            ..no_law_there(
                self.force_and_rate(),
                self.force_rate_limit_n_per_s,
                &self.safety(),
                &self.device,
                push_n,
            )
        }
    }

    /// A copy without friction, if friction could be all that holds the device.
    pub(super) fn smooth(&self) -> Option<Self> {
        let second_n = (self.second.as_ref()).map_or(0.0, |second| second.device.friction.0);
        let rubs = self.device.friction.0 + second_n > 0.0;
        let simulated = self.conduct.remote.is_none() && rubs;
        (simulated && self.plan.criterion == Criterion::Settling).then(|| {
            let mut smooth = self.clone();
            smooth.device.friction = Newtons(0.0);
            if let Some(second) = &mut smooth.second {
                second.device.friction = Newtons(0.0);
            }
            smooth
        })
    }
}

/// Facts about the device that keys say over a device file; none without one.
fn written(table: &Table<'_>, device: &MassDamperConfig, sensors: Sensors) -> GuardedDevice {
    if !table.has(&p::DEVICE_MODEL) {
        return GuardedDevice::default();
    }
    let is = |parameter: &p::Parameter| !table.lies_below(parameter, &p::DEVICE_MODEL);
    let all = GuardedDevice::simulated(device, sensors);
    let has_noise = is(&p::ENCODER_RESOLUTION) || is(&p::SENSOR_NOISE);
    GuardedDevice {
        mass_kg: all.mass_kg.filter(|_| is(&p::MASS)),
        damping_n_s_per_m: all.damping_n_s_per_m.filter(|_| is(&p::DAMPING)),
        delay_s: all.delay_s.filter(|_| is(&p::DELAY)),
        current_lag_s: all.current_lag_s.filter(|_| is(&p::CURRENT_LAG)),
        noise_m: all.noise_m.filter(|_| has_noise),
    }
}

/// A guard counts the energy of the whole actuator, so it would take the push for energy of the wall.
const PUSHED_WITH_GUARD: &str = "push_by = \"device\" pushes with the energy that a guard takes away: omit `guard`, or one of them";

/// Device, trial and safety, and whether an unstable trial is a failure.
pub(crate) fn setup(
    table: &Table<'_>,
    must_be_stable: &p::Parameter,
    drive: Option<&Table<'_>>,
) -> Result<TrialSetup, FileError> {
    let remote = remote(table)?;
    let sample_time_s = table.required(&p::SAMPLE_TIME)?;
    let duration_s = table.number(&p::TRIAL_DURATION)?;
    samples_fit(table, sample_time_s, duration_s, &TRIAL_SAMPLES)?;
    let model = device_model(table)?;
    for key in [&p::MASS, &p::DAMPING] {
        table.required(key)?;
    }
    let (device, sensors) = device(table, sample_time_s)?;
    let mut plan = plan(table, duration_s)?;
    let second = drive.map(|drive| second(drive, table, device, remote.as_ref(), &plan));
    let second = second.transpose()?;
    if second.is_some() {
        plan = TrialPlan {
            push_by: PushBy::Second,
            ..plan.starting_at_rest()
        };
    }
    let safety = safety(table)?;
    if plan.push_by == PushBy::Device && safety.guard != GuardChoice::Off {
        return Err(table.fail_at(p::PUSH_BY.key, PUSHED_WITH_GUARD));
    }
    let of_file = model.as_ref().map(DeviceModel::guarded).unwrap_or_default();
    Ok(TrialSetup {
        must_be_stable: table.flag(must_be_stable)?,
        force_rate_limit_n_per_s: table.number_if(&TRIAL_FORCE_RATE_LIMIT)?,
        safety,
        conduct: Conduct::on(remote),
        second,
        impact_was_given: table.number_if(&IMPACT)?.is_some(),
        known: written(table, &device, sensors).or(of_file),
        ..TrialSetup::new(device, sensors, plan)
    })
}
