//! All of a trial on a pushed device but the law that it feels: what a wall and a coupler share.

use crate::{
    pushed::{Pushed, SecondDevice, second},
    robot::PushedRobot,
    settling::{Criterion, Judge, Settling},
    trial::{TRIAL_SAMPLES, TrialPlan, force_and_rate, plan, thrown, try_out},
};
use fracdiff::parameter::Shown;
use haptic_analysis::{Dynamics, HandImpedance};
use haptic_document::{Failure, FileError, Table, parameters as p};
use haptic_link::LoopMode;
use haptic_loop::{
    Controller, Environment, SafetyChain, SafetyLimits,
    plant::{MassDamperConfig, Sensed},
    units::{Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre, Seconds},
};
use haptic_trial::{
    DeviceModel, Sensors,
    device_table::{device, device_model, dynamics, encoder_step, robot, samples_fit},
    keys::trial::{IMPACT, PushBy, TRIAL_FORCE_RATE_LIMIT},
    robot::RobotModel,
    safe_chain::safe_chain,
    safety::{GuardChoice, GuardedDevice, Safety, keys::GUARD, safety},
};
use std::sync::Arc;

/// All of an experiment on a pushed device but the law that it feels.
#[derive(Clone, Debug)]
pub struct TrialSetup {
    /// The device, its hand and its imperfections, simulated here or known for a serial device.
    pub device: MassDamperConfig,
    /// Encoder resolution and noise of the position that the loop reads.
    pub sensors: Sensors,
    /// Push, hit and the rule that judges.
    pub plan: TrialPlan,
    /// The device that pushes it, if that is a second one.
    pub second: Option<SecondDevice>,
    /// The robot that a hand pushes in place of the device, which is that hand then, with the tool.
    pub robot: Option<Arc<RobotModel>>,
    /// True if the run fails when the trial or the analysis finds it unstable, or a coupler does
    /// not meet Llewellyn's criterion.
    pub must_be_stable: bool,
    /// Largest rate of the force, N/s; `None` keeps a serial device's own limit, and sets none on a
    /// simulated one.
    pub force_rate_limit_n_per_s: Option<f64>,
    /// Further settings of the safety chain.
    pub safety: Safety,
    /// Place of the loop of a device at a port; `None` for the simulated one.
    pub at_port: Option<LoopMode>,
    /// True if the impact speed was requested: a serial device cannot be thrown, so this then
    /// causes a warning.
    pub impact_was_given: bool,
    /// Values from its device file for the guard of a serial device.
    pub known: GuardedDevice,
}

/// A loop made of good parameters: the law behind the safety chain, and the device behind its sensors.
#[derive(Debug)]
pub struct TrialParts<E: Environment<f64, 1>> {
    /// The law behind the safety chain.
    pub controller: Controller<f64, 1, E>,
    /// The device behind its sensors, or both of them.
    pub device: Sensed<Pushed>,
    /// Samples of the trial, that at time 0 included.
    pub samples: u64,
    /// Judge of the trial, which must see each sample.
    pub judge: Judge,
    /// See [`Settling::expected_deflection_m`](crate::settling::Settling::expected_deflection_m).
    pub rest_m: Option<f64>,
}

impl<E: Environment<f64, 1>> TrialParts<E> {
    /// Runs the loop without log or files.
    pub fn tried(mut self) -> Settling {
        let (device, judge) = (&mut self.device, &mut self.judge);
        let whole = try_out(&mut self.controller, device, self.samples, judge);
        // A robot that has stopped stands still, which is no rest.
        let ended = device.device().ended();
        Settling {
            ended,
            ..self.judge.settling(whole && ended.is_none(), self.rest_m)
        }
    }
}

impl TrialSetup {
    /// A trial of a simulated device in virtual time, that may end as it will, with the force limit alone.
    pub fn new(device: MassDamperConfig, sensors: Sensors, plan: TrialPlan) -> Self {
        Self {
            device,
            sensors,
            plan,
            second: None,
            robot: None,
            must_be_stable: false,
            force_rate_limit_n_per_s: None,
            safety: Safety::default(),
            at_port: None,
            impact_was_given: false,
            known: GuardedDevice::default(),
        }
    }

    /// Device and hand, as the analysis knows them, wherever the device is; with a second device, which it touches, as one body.
    pub fn dynamics(&self) -> Dynamics {
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
    pub fn safety(&self) -> Safety {
        match self.at_port {
            Some(_) => self.safety.with_device(&self.known, true),
            None => self.safety,
        }
    }

    /// Plan of the trial as it is really tried: a serial device cannot be thrown.
    pub fn plan(&self) -> TrialPlan {
        match self.at_port {
            Some(_) => self.plan.starting_at_rest(),
            None => self.plan,
        }
    }

    /// Warning about a requested impact that had no effect.
    pub fn not_thrown(&self) -> Option<String> {
        let impact_m_per_s = self.plan.impact_m_per_s;
        let asked = self.impact_was_given && self.at_port.is_some() && impact_m_per_s > 0.0;
        asked.then(|| {
            format!(
                "impact_m_per_s = {} had no effect: a serial device cannot be thrown, it was pushed from rest; omit it",
                Shown(impact_m_per_s)
            )
        })
    }

    /// The device behind its sensors, pushed and thrown.
    ///
    /// # Errors
    /// A device, or a sensor, outside its ranges.
    pub fn sensed(&self) -> Result<Sensed<Pushed>, Failure> {
        let plan = self.plan();
        self.sensors.before(match (&self.second, &self.robot) {
            (None, None) => Pushed::Alone(Box::new(thrown(self.device, &plan)?)),
            (None, Some(robot)) => {
                let robot = PushedRobot::new(robot, self.hand(robot), plan.push_n)?;
                Pushed::Robot(Box::new(robot))
            }
            (Some(second), _) => {
                let pair = second.before(self.device, plan.push_n, &self.safety())?;
                Pushed::Pair(Box::new(pair))
            }
        })
    }

    /// Step of an encoder that is as coarse as the sensors, m: of a robot what the noise of its force sensor moves a spring, N/m, by.
    pub fn step_m(&self, spring_n_per_m: f64) -> f64 {
        match &self.robot {
            Some(robot) if spring_n_per_m > 0.0 => {
                robot.place.simulated.sensor_noise.0 / spring_n_per_m
            }
            Some(_) | None => encoder_step(self.sensors),
        }
    }

    /// The hand of the trial on a robot.
    fn hand(&self, robot: &RobotModel) -> HandImpedance {
        HandImpedance {
            mass_kg: self.device.mass.0 - robot.place.robot.tool_mass_kg(),
            damping_n_s_per_m: self.device.damping.0,
            stiffness_n_per_m: self.device.stiffness.0,
        }
    }

    /// Trials of the robot in the other corners of its box of hands; none without a robot.
    pub fn in_other_hands(&self) -> impl Iterator<Item = Self> {
        let own = self.robot.as_deref().map(|robot| self.hand(robot));
        let robot = self.robot.clone();
        let hands = robot.into_iter().flat_map(|robot| {
            let corners: Vec<_> = robot.place.corners().collect();
            corners.into_iter().map(move |hand| (robot.clone(), hand))
        });
        let others = hands.filter(move |(_, hand)| Some(*hand) != own);
        others.map(|(robot, hand)| Self {
            device: held_by(&robot, hand),
            ..self.clone()
        })
    }

    /// The safety chain of the loop that runs here.
    ///
    /// # Errors
    /// As [`safe_chain`].
    pub fn chain(&self) -> Result<SafetyChain<f64>, Failure> {
        let (limits, safety) = (self.force_and_rate(), self.safety());
        safe_chain(limits, &self.device, self.sensors, &safety, self.at_port)
    }

    /// Limits of force and rate.
    #[must_use]
    pub fn force_and_rate(&self) -> SafetyLimits {
        let (force, rate) = (self.plan.force_limit_n, self.force_rate_limit_n_per_s);
        force_and_rate(force, rate, self.device.sample_time)
    }

    /// A copy without friction, if friction could be all that holds the device.
    pub fn smooth(&self) -> Option<Self> {
        let second_n = (self.second.as_ref()).map_or(0.0, |second| second.device.friction.0);
        let rubs = self.device.friction.0 + second_n > 0.0;
        let simulated = self.at_port.is_none() && rubs;
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

/// The hand of a robot, with the tool, as the judge knows it, which reads the place of the command.
pub fn held_by(robot: &RobotModel, hand: HandImpedance) -> MassDamperConfig {
    MassDamperConfig {
        mass: Kilograms(hand.mass_kg + robot.place.robot.tool_mass_kg()),
        damping: NewtonSecondsPerMetre(hand.damping_n_s_per_m),
        stiffness: NewtonsPerMetre(hand.stiffness_n_per_m),
        sample_time: robot.place.simulated.sample_time,
        delay: Seconds(0.0),
        friction: Newtons(0.0),
        saturation: None,
        gain: 1.0,
        current_lag: Seconds(0.0),
    }
}

/// Keys of a device of forces, which a robot has not.
pub const OF_FORCES: [p::Parameter; 10] = [
    p::MASS,
    p::DAMPING,
    p::HAND_STIFFNESS,
    p::DELAY,
    p::CURRENT_LAG,
    p::FRICTION,
    p::ENCODER_RESOLUTION,
    p::SENSOR_NOISE,
    IMPACT,
    p::PUSH_BY,
];

/// A robot in the largest hand of its box, at rest.
fn robot_in_hand(
    table: &Table<'_>,
    robot: &RobotModel,
    guard: GuardChoice,
) -> Result<MassDamperConfig, FileError> {
    if let Some(key) = OF_FORCES.iter().find(|key| table.has(key)) {
        let key = key.key;
        let remedy = if key == p::HAND_STIFFNESS.key {
            "give admittance.hand_stiffness in its place"
        } else {
            "omit it, or give the robot's own hand in [admittance]"
        };
        let reason =
            format!("{key} of [wall] has no effect on a robot that a hand pushes: {remedy}");
        return Err(table.fail_at(key, reason));
    }
    if guard != GuardChoice::Off {
        let reason = "a guard needs a device that damps, which a robot does not: omit `guard`; [admittance] has limits of its own";
        return Err(table.fail_at(GUARD.key, reason));
    }
    Ok(held_by(robot, robot.place.hand([1; 3])))
}

/// A guard counts the energy of the whole actuator, so it would take the push for energy of the wall.
const PUSHED_WITH_GUARD: &str = "push_by = \"device\" pushes with the energy that a guard takes away: omit `guard`, or one of them";

/// Tables beside that of a law.
#[derive(Clone, Copy, Debug, Default)]
pub struct Beside<'a> {
    /// `[drive]`: a second device that pushes.
    pub drive: Option<&'a Table<'a>>,
    /// `[admittance]`: a robot that a hand pushes.
    pub admittance: Option<&'a Table<'a>>,
}

/// Device, trial and safety, and whether an unstable trial is a failure; where the loop of the device is, and of the second one.
///
/// # Errors
/// A missing or wrong key: with file and line.
pub fn setup(
    table: &Table<'_>,
    must_be_stable: &p::Parameter,
    beside: Beside<'_>,
    at_port: [Option<LoopMode>; 2],
) -> Result<TrialSetup, FileError> {
    let sample_time_s = table.required(&p::SAMPLE_TIME)?;
    let duration_s = table.number(&p::TRIAL_DURATION)?;
    samples_fit(table, sample_time_s, duration_s, &TRIAL_SAMPLES)?;
    let drive = beside.drive;
    let robot = robot(table, beside.admittance, sample_time_s)?;
    let safety = safety(table)?;
    let model = match &robot {
        Some(_) => None,
        None => device_model(table)?,
    };
    let (device, sensors) = match &robot {
        Some(robot) => {
            if let Some(drive) = drive {
                let reason = "[drive] pushes a device of forces, and a robot is pushed by a hand: omit [drive] or the robot";
                return Err(drive.fail(reason));
            }
            (robot_in_hand(table, robot, safety.guard)?, Sensors::NONE)
        }
        None => {
            for key in [&p::MASS, &p::DAMPING] {
                table.required(key)?;
            }
            device(table, sample_time_s)?
        }
    };
    let mut plan = plan(table, duration_s)?;
    if robot.is_some() {
        plan = plan.starting_at_rest();
    }
    let second = drive.map(|drive| second(drive, table, device, at_port, &plan));
    let second = second.transpose()?;
    if second.is_some() {
        plan = TrialPlan {
            push_by: PushBy::Second,
            ..plan.starting_at_rest()
        };
    }
    if plan.push_by == PushBy::Device && safety.guard != GuardChoice::Off {
        return Err(table.fail_at(p::PUSH_BY.key, PUSHED_WITH_GUARD));
    }
    let of_file = model.as_ref().map(DeviceModel::guarded).unwrap_or_default();
    Ok(TrialSetup {
        must_be_stable: table.flag(must_be_stable)?,
        force_rate_limit_n_per_s: table.number_if(&TRIAL_FORCE_RATE_LIMIT)?,
        safety,
        at_port: at_port[0],
        second,
        robot: robot.map(Arc::new),
        impact_was_given: table.number_if(&IMPACT)?.is_some(),
        known: written(table, &device, sensors).or(of_file),
        ..TrialSetup::new(device, sensors, plan)
    })
}
