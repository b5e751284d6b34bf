//! A trial in virtual time: a device hits a wall and is pushed into it. A single trial and the search for a Z-width share this.
//!
//! The device arrives from free flight: at time 0 it is at the wall with the speed of the impact, and the
//! wall remembers nothing. From then on the push acts.

use crate::{
    preflight::WallContact,
    settling::{Criterion, Judge, Settling, Tolerance, TrialScales},
};
use fracdiff::{Operator, Order, Scheme, Seconds, parameter::Shown};
use haptic_document::{
    Failure, FileError, Named, Table, bad_input,
    parameters::{PUSH_BY, TRIAL_DURATION},
};
use haptic_loop::{
    Controller, Device, Environment, LoopParameterError, LoopSample, Reading, SafeForce,
    SafetyChain, SafetyLimits, Wall,
    plant::{MassDamper, MassDamperConfig},
    units::{Metres, Newtons, NewtonsPerSecond},
};
use haptic_trial::{
    advice::parameter,
    device_table::without,
    ending::MotorPush,
    keys::trial::{CRITERION, IMPACT, PUSH, PushBy, THRESHOLD, TRIAL_FORCE_LIMIT, WINDOW},
    tap::TappedLaw,
};
use nalgebra::{SVector, Vector1};
use std::{convert::Infallible, fmt::Debug, ops::RangeInclusive};

/// A wall at the device's start position.
pub type VirtualWall = Wall<f64, Operator<f64>>;

/// Plan of a trial: the motion into the wall, and the rule that judges it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrialPlan {
    /// The rule that judges it.
    pub criterion: Criterion,
    /// Largest standard deviation of the position under the dissertation's rule, m.
    pub threshold_m: f64,
    /// Constant push into the wall, N: above 0, below the force limit.
    pub push_n: f64,
    /// The source of the push.
    pub push_by: PushBy,
    /// Speed at which the device hits the wall, m/s: 0 to 10. 0 with the dissertation's rule and on a serial
    /// device, which cannot be thrown.
    pub impact_m_per_s: f64,
    /// Time in which the wall has to settle, s.
    pub duration_s: f64,
    /// Window at the end that is judged, s.
    pub window_s: f64,
    /// Largest force of the actuator, N: a force that persists there does not come from the wall.
    pub force_limit_n: f64,
}

/// Speeds at which contact that never pulls is hit beside that of its plan, m/s; 0 is a push from rest.
const HITS: [f64; 6] = [0.0, 0.05, 0.1, 0.2, 0.5, 1.0];

impl Default for TrialPlan {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Samples of a trial: of a longer one nothing more is learned.
pub const TRIAL_SAMPLES: RangeInclusive<f64> = 10.0..=20e6;

impl TrialPlan {
    /// 0.1 m/s and 1 N for 5 s, judged over the last 0.4 s, up to 100 N.
    pub const DEFAULT: Self = Self {
        criterion: Criterion::Settling,
        threshold_m: THRESHOLD.default_number(),
        push_n: PUSH.default_number(),
        push_by: PushBy::Hand,
        impact_m_per_s: IMPACT.default_number(),
        duration_s: TRIAL_DURATION.default_number(),
        window_s: WINDOW.default_number(),
        force_limit_n: TRIAL_FORCE_LIMIT.default_number(),
    };
    /// The push of the device's own motor, N; `None` where somebody else pushes.
    pub fn own_push_n(&self) -> Option<f64> {
        (self.push_by == PushBy::Device).then_some(self.push_n)
    }

    /// The push of somebody else, N.
    pub fn push_of_hand_n(&self) -> f64 {
        match self.push_by {
            PushBy::Hand => self.push_n,
            PushBy::Device | PushBy::Second => 0.0,
        }
    }

    /// The push of a motor.
    pub fn push_of_motor(&self) -> Option<MotorPush> {
        match self.push_by {
            PushBy::Hand => None,
            PushBy::Device => Some(MotorPush::Own(self.push_n)),
            PushBy::Second => Some(MotorPush::Second(self.push_n)),
        }
    }

    /// A wall of K N/m and B N·s^μ/m as the motor that pushes taps it; `None` where nobody taps.
    pub fn tapped(
        &self,
        device: &MassDamperConfig,
        [k, b]: [f64; 2],
        order: Order,
        contact: WallContact,
    ) -> Option<TappedLaw> {
        Some(TappedLaw {
            device: *device,
            wall: [k + device.stiffness.0, b],
            order: order.get(),
            samples: (self.duration_s / device.sample_time.0).round() as u64 + 1,
            lifts: contact != WallContact::Linear,
            push_n: self.tapping_push_n()?,
        })
    }

    /// The push of a motor that taps, N; `None` where nobody taps.
    pub fn tapping_push_n(&self) -> Option<f64> {
        (self.own_push_n()).filter(|_| self.criterion == Criterion::Settling)
    }

    /// Starts from rest, for a device that cannot be thrown.
    pub const fn starting_at_rest(self) -> Self {
        Self {
            impact_m_per_s: 0.0,
            ..self
        }
    }

    /// Further speeds at which a wall is hit, m/s. A linear wall has none, since each hit gives the verdict of the planned one.
    pub fn hits(&self, contact: WallContact) -> impl Iterator<Item = f64> {
        let once = contact == WallContact::Linear
            || self.criterion != Criterion::Settling
            || self.push_of_motor().is_some();
        let hits: &[f64] = if once { &[] } else { &HITS };
        let planned = self.impact_m_per_s;
        (hits.iter().copied()).filter(move |hit| hit.total_cmp(&planned).is_ne())
    }

    /// Number of samples, that at time 0 included.
    ///
    /// # Errors
    /// A plan that cannot be tried, with the parameter to change.
    pub fn samples(&self, sample_time: Seconds) -> Result<u64, Failure> {
        let t = sample_time.0;
        let samples = haptic_trial::samples::count(self.duration_s, t, &TRIAL_SAMPLES)?;
        if !(self.window_s >= 10.0 * t && self.window_s <= self.duration_s) {
            return Err(bad_input!(
                "window {} s is not in [{}, {}] s, from ten samples to the whole run: change {WINDOW} or {TRIAL_DURATION}",
                Shown(self.window_s),
                Shown(10.0 * t),
                Shown(self.duration_s)
            ));
        }
        if !(self.push_n > 0.0 && self.push_n < self.force_limit_n) {
            return Err(bad_input!(
                "push {} N is not above 0 N and below the force limit of {} N: change one of them",
                Shown(self.push_n),
                Shown(self.force_limit_n)
            ));
        }
        let impacts = IMPACT.range();
        if !impacts.contains(self.impact_m_per_s) {
            return Err(bad_input!(
                "impact {} m/s is not {impacts} m/s: change it; 0.1 m/s is usual",
                Shown(self.impact_m_per_s)
            ));
        }
        Ok(samples)
    }

    /// Tries a law of one's own on a plant of one's own, in virtual time.
    ///
    /// `law` is its history at rest, and what makes the force, N, of a position, m, and the next history; it is asked twice a tick, for the force
    /// and then for the history. `plant` takes the force of a tick and gives the position at the next one; at first it is at 0 m, and it is
    /// thrown and pushed as its own model does it. `stiffness_n_per_m` is the spring that it meets at rest, with which the deflection is expected.
    ///
    /// # Errors
    /// A parameter of the plan outside its range.
    pub fn try_law<H: Clone + Debug>(
        &self,
        law: (H, impl Fn(&mut H, f64) -> f64),
        plant: impl FnMut(f64) -> f64,
        sample_time: Seconds,
        stiffness_n_per_m: f64,
    ) -> Result<Settling, Failure> {
        let samples = self.samples(sample_time)?;
        let mut judge = self.judge(stiffness_n_per_m, stiffness_n_per_m, 0.0, sample_time.0);
        let chain = force_limit(self.force_limit_n, sample_time)?;
        let mut plant = OwnPlant {
            step: plant,
            next: Reading {
                tick: 0,
                time_s: 0.0,
                position_m: Vector1::zeros(),
            },
            sample_time,
        };
        let mut controller = Controller::new(OwnLaw(law.0, law.1), chain);
        let whole = try_out(&mut controller, &mut plant, samples, &mut judge);
        Ok(judge.settling(whole, Some(self.push_n / stiffness_n_per_m)))
    }

    /// The judge of a wall of K N/m with the hand, and of K + B·T^(−μ) N/m for a step, behind these sensors.
    pub fn judge(
        &self,
        spring_n_per_m: f64,
        step_n_per_m: f64,
        encoder_step_m: f64,
        sample_time_s: f64,
    ) -> Judge {
        let scales = TrialScales {
            push_n: self.push_n,
            spring_n_per_m,
            step_n_per_m,
            encoder_step_m,
            threshold_m: self.threshold_m,
        };
        Judge::new(
            self.criterion,
            self.impact_m_per_s,
            Tolerance::new(self.criterion, scales),
            // The window holds whole samples; times are multiples of T, rounded.
            self.duration_s - self.window_s + 0.5 * sample_time_s,
            0.5 * self.duration_s,
            self.force_limit_n,
        )
        .behind(self.push_of_motor())
    }
}

/// A law as its history at rest and its step.
struct OwnLaw<H, F>(H, F);

impl<H: Clone + Debug, F: Fn(&mut H, f64) -> f64> Environment<f64, 1> for OwnLaw<H, F> {
    type History = H;

    fn at_rest(&self) -> H {
        self.0.clone()
    }

    fn force(&self, history: &H, x: &Vector1<f64>) -> Vector1<f64> {
        Vector1::new(self.1(&mut history.clone(), x[0]))
    }

    fn advance(&self, history: &mut H, x: &Vector1<f64>) {
        self.1(history, x[0]);
    }
}

/// A plant as its step.
struct OwnPlant<F> {
    step: F,
    next: Reading<f64, 1>,
    sample_time: Seconds,
}

impl<F: FnMut(f64) -> f64> Device<f64, 1> for OwnPlant<F> {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<f64, 1>, Infallible> {
        Ok(self.next)
    }

    fn write(&mut self, force: SafeForce<f64, 1>) -> Result<(), Infallible> {
        let tick = self.next.tick + 1;
        self.next = Reading {
            tick,
            time_s: tick as f64 * self.sample_time.0,
            position_m: Vector1::new((self.step)(force.newtons()[0])),
        };
        Ok(())
    }
}

/// Reads the plan of a trial: how a wall is tried and judged.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn plan(table: &Table<'_>, duration_s: f64) -> Result<TrialPlan, FileError> {
    let criterion = table.choice(&CRITERION)?;
    let impact_m_per_s = match criterion {
        Criterion::Settling => {
            let instead = CRITERION.set_to(Criterion::Dissertation.name());
            without(
                table,
                [&THRESHOLD],
                &format!("with the criterion settling: give {instead}"),
            )?;
            IMPACT.default_number()
        }
        Criterion::Dissertation => 0.0,
    };
    let push_by = table.choice(&PUSH_BY)?;
    let impact_m_per_s = match push_by {
        PushBy::Hand => impact_m_per_s,
        PushBy::Device => {
            let why = "where the device pushes by itself, from rest: give `push_by` = hand";
            without(table, [&IMPACT], why)?;
            0.0
        }
        // Its table is read later.
        PushBy::Second => 0.0,
    };
    let plan = TrialPlan {
        criterion,
        threshold_m: table.number(&THRESHOLD)?,
        impact_m_per_s: table.number_if(&IMPACT)?.unwrap_or(impact_m_per_s),
        push_n: table.number(&PUSH)?,
        push_by,
        duration_s,
        window_s: table.number(&WINDOW)?,
        force_limit_n: table.number(&TRIAL_FORCE_LIMIT)?,
    };
    if plan.push_n >= plan.force_limit_n {
        return Err(table.fail_at(
            "push_n",
            format_args!(
                "push_n = {} is not below force_limit_n = {}: no wall could hold it",
                Shown(plan.push_n),
                Shown(plan.force_limit_n)
            ),
        ));
    }
    Ok(plan)
}

/// Runs the loop in virtual time, without log or files, until the judge has seen enough; `true` if it
/// reached the end without a fault.
pub fn try_out<E, V>(
    controller: &mut Controller<f64, 1, E>,
    device: &mut V,
    samples: u64,
    judge: &mut Judge,
) -> bool
where
    E: Environment<f64, 1>,
    V: Device<f64, 1, Error = Infallible>,
{
    let Ok(whole) = (controller.engage(device)).run(samples, |sample| seen(judge, sample));
    whole
}

/// Lets the judge see a tick; `false` if it has seen enough.
pub fn seen(judge: &mut Judge, sample: &LoopSample<f64, 1>) -> bool {
    let reading = &sample.reading;
    judge.see(
        reading.time_s,
        reading.position_m[0],
        sample.force.newtons()[0],
    )
}

/// A wall without a force.
///
/// # Errors
/// A parameter outside its range.
pub fn no_wall(t: Seconds) -> Result<VirtualWall, Failure> {
    let order = Order::new(0.0).map_err(Failure::input)?;
    let operator = Scheme::Grunwald { length: 1 }.build(order, t, 1.0);
    let operator = operator.map_err(Failure::input)?;
    wall_at_start(0.0, 0.0, operator, WallContact::Linear).map_err(Failure::input)
}

/// K in N/m and B in N·s^μ/m; one-sided it pushes but never pulls, signed it has no clamp yet.
///
/// # Errors
/// A parameter outside its range.
pub fn wall_at_start(
    stiffness: f64,
    dissipation: f64,
    operator: Operator<f64>,
    contact: WallContact,
) -> Result<VirtualWall, LoopParameterError> {
    let start = (contact == WallContact::OneSided).then_some(Metres(0.0));
    Wall::new(stiffness, dissipation, operator, start)
}

/// The device at the moment it hits the wall, with the push on it.
///
/// # Errors
/// A parameter outside its range.
pub fn thrown(config: MassDamperConfig, plan: &TrialPlan) -> Result<MassDamper<1>, Failure> {
    let mut device = MassDamper::new(config).map_err(parameter)?;
    device.set_external_force(SVector::from([plan.push_of_hand_n()]));
    device.set_state(SVector::from([0.0]), SVector::from([plan.impact_m_per_s]));
    Ok(device)
}

/// A safety chain that limits the force alone.
///
/// # Errors
/// A parameter outside its range.
pub fn force_limit(limit_n: f64, t: Seconds) -> Result<SafetyChain<f64>, Failure> {
    SafetyChain::from_limits(&force_and_rate(limit_n, None, t), t).map_err(parameter)
}

/// Limits of the force and of its rate, N/s. The rate is not what is tried here: without one the limit may be crossed
/// within one sample.
pub fn force_and_rate(limit_n: f64, rate: Option<f64>, t: Seconds) -> SafetyLimits {
    let rate = rate.unwrap_or(2.0 * limit_n / t.0);
    SafetyLimits::bare(Newtons(limit_n), NewtonsPerSecond(rate))
}
