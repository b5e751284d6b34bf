//! A robot that a hand pushes, as the keys of `[admittance]` say it: its own loop, its sensor, its virtual body, the hands that push it, and the
//! limits of its motion.
//!
//! ```toml
//! [admittance]                        # a device file of its own, or beside [wall]
//! bandwidth_hz = 10
//! dead_time_s = 0.004
//! body_inertance_n_s_mu_per_m = 8     # m of m·D^α + b
//! body_damping_n_s_per_m = 20
//! ```
//! A device file may have `[state_space]` with `a`, `b`, `c` and `delay_s`, from commanded to true velocity, in place of bandwidth, damping ratio
//! and dead time. One reading serves the analysis, the simulated robot and whatever renders on a real one. Without them there is no
//! verdict on a robot, so that these keys are required.

use crate::{
    advice::{analysed, parameter},
    keys::admittance::{
        ADMITTANCE_TABLE, BODY_DAMPING, BODY_INERTANCE, BODY_LAG, BODY_ORDER, BODY_SCHEME,
        FORCE_CUTOFF, FORCE_LAGS, HANDS_DAMPING, HANDS_MASS, HANDS_STIFFNESS, MOTION_ACCELERATION,
        MOTION_HIGH, MOTION_LOW, MOTION_SPEED, ROBOT, ROBOT_BANDWIDTH, ROBOT_DAMPING,
        ROBOT_DEAD_TIME, ROBOT_NOISE, ROBOT_RANGE, TOOL_MASS,
    },
    plant_file::{INTERVALS, made_by, source_of},
};
use fracdiff::{
    Differintegrator, Order, Real, Scheme, Seconds,
    parameter::Shown,
    portable::Form,
    scheme::{Operator, OperatorHistory},
};
use haptic_analysis::{
    AdmittanceBody, AdmittanceBox, AdmittanceLoop, AdmittanceNumber, AdmittanceWorld, ForceFilter,
    HandImpedance, LoopOperator, Robot, VelocityLoop,
};
use haptic_document::{
    Cause, Failure, FileError, Interval, Parsed, Table, bad_input,
    parameters::{
        CURRENT_LAG, DEAD_TIME, Parameter, STATE_A, STATE_B, STATE_B_HAND, STATE_C, STATE_C_HAND,
        STATE_PLANT,
    },
};
use haptic_loop::{
    Admittance, LaggedRate, LaggedRateHistory, LoopParameterError, MotionChain, MotionLimits,
    MotionStartRefused, VirtualBody,
    plant::{LOOP_STATES, RobotHand, RobotLoop, SimulatedRobot, SimulatedRobotConfig},
    units::{
        Hertz, Kilograms, Metres, MetresPerSecond, MetresPerSecondSquared, NewtonSecondsPerMetre,
        Newtons, NewtonsPerMetre,
    },
};
use haptic_remote::{COEFFICIENTS_MAX, DeviceOperator};
use nalgebra::{SMatrix, SVector};
use std::path::Path;

/// The table of a robot.
pub const ADMITTANCE: &str = "admittance";
/// The table of its loop by states, in a device file.
const STATES: &str = "state_space";
/// Memory for which the analysis designs an operator of all of the past, samples.
const HORIZON: f64 = 1e6;

/// A robot with its body, in its hands, within its limits.
#[derive(Clone, Debug)]
pub struct RobotModel {
    /// The robot and the hands that push it.
    pub place: RobotInHands,
    /// Its virtual body.
    pub body: BodyValues,
    /// Limits of its motion.
    pub limits: MotionLimits<1>,
}

/// A robot as its own program reads it.
#[derive(Clone, Debug)]
pub struct OwnRobot {
    /// Limits of its motion.
    pub limits: MotionLimits<1>,
    /// All that its file says; `None` of one that is to be measured: neither its bandwidth nor its dead time is known.
    pub model: Option<RobotModel>,
}

/// All but the body: the robot, and the hands that push it.
#[derive(Clone, Debug)]
pub struct RobotInHands {
    /// The robot, as the analysis has it.
    pub robot: Robot,
    /// Its twin in virtual time, in no hand.
    pub simulated: SimulatedRobotConfig,
    /// Least and largest mass, kg, damping, N·s/m, and stiffness, N/m, of the hands.
    pub hands: [[f64; 2]; 3],
}

/// A virtual body.
#[derive(Clone, Debug)]
pub struct BodyValues {
    /// m, N·s^(1+α)/m.
    pub inertance: f64,
    /// b, N·s/m.
    pub damping: f64,
    /// `D^α` as it runs.
    pub operator: LoopOperator,
    /// Lag of a lagged mass, s.
    pub lag_s: Option<f64>,
    /// Scheme of its operator, without a lag.
    pub scheme: Scheme,
}

/// Least and largest value of a key that takes one or both.
fn ends(table: &Table<'_>, key: &Parameter) -> Result<[f64; 2], FileError> {
    let given = table.numbers_if(key)?;
    match *given.unwrap_or_else(|| key.default_numbers()) {
        [one] => Ok([one; 2]),
        [low, high] if low <= high => Ok([low, high]),
        _ => {
            let key = key.key;
            let reason =
                format!("{key} is one number, or the least and the largest one, as in [0, 3]");
            Err(table.fail_at(key, reason))
        }
    }
}

/// The operator of a scheme as it runs: the exact one with a memory of all of the run.
///
/// # Errors
/// One that its scheme cannot make.
pub fn rendered<F: Real>(
    scheme: Scheme,
    order: Order,
    sample_time: Seconds,
) -> Result<Operator<F>, Failure> {
    let runs = if scheme == Scheme::Exact {
        "full".parse().map_err(Failure::input)?
    } else {
        scheme
    };
    runs.build(order, sample_time, HORIZON)
        .map_err(Failure::input)
}

impl BodyValues {
    /// The body of these keys, at this sample time, s.
    ///
    /// # Errors
    /// A body of nothing, a lag beside an order or scheme, an operator that its scheme cannot make.
    pub fn of(table: &Table<'_>, t: f64) -> Result<Self, Failure> {
        let order = table.order(&BODY_ORDER)?;
        let lag_s = table.number_if(&BODY_LAG)?;
        let inertance = table.required(&BODY_INERTANCE)?;
        let damping = table.number_if(&BODY_DAMPING)?.unwrap_or(0.0);
        if inertance == 0.0 && damping == 0.0 {
            let reason = format!("a body of nothing moves without end: give {BODY_DAMPING} too");
            return Err(table.fail_at(BODY_INERTANCE.key, reason).into());
        }
        let (scheme, operator) = match lag_s {
            Some(lag) => {
                if order.get().to_bits() != 1.0_f64.to_bits() || table.has(&BODY_SCHEME) {
                    let reason = format!(
                        "a lagged mass has order 1 and no scheme: omit {BODY_LAG}, or {BODY_ORDER} and {BODY_SCHEME}"
                    );
                    return Err(table.fail_at(BODY_LAG.key, reason).into());
                }
                let operator = LoopOperator::lagged_difference(lag / t);
                (Scheme::Exact, operator.map_err(analysed)?)
            }
            None => {
                let scheme = table.scheme(&BODY_SCHEME)?;
                let operator = LoopOperator::new(scheme, order, Seconds(t), HORIZON);
                (scheme, operator.map_err(Failure::input)?)
            }
        };
        Ok(Self {
            inertance,
            damping,
            operator,
            lag_s,
            scheme,
        })
    }

    /// The body as the analysis has it.
    pub const fn virtual_body(&self) -> AdmittanceBody<'_> {
        AdmittanceBody {
            inertance_n_s_alpha_per_m: self.inertance,
            damping_n_s_per_m: self.damping,
            operator: &self.operator,
        }
    }

    /// The body as it runs.
    ///
    /// # Errors
    /// A scheme that cannot make the operator, or a body of nothing.
    pub fn rendered(
        &self,
        sample_time: Seconds,
    ) -> Result<VirtualBody<f64, BodyOperator>, Failure> {
        let operator = match self.lag_s {
            Some(lag_s) => BodyOperator::Lagged(
                LaggedRate::new(Seconds(lag_s), sample_time).map_err(parameter)?,
            ),
            None => {
                let order = self.operator.order();
                BodyOperator::Of(Box::new(rendered(self.scheme, order, sample_time)?))
            }
        };
        let damping = NewtonSecondsPerMetre(self.damping);
        VirtualBody::new(self.inertance, damping, operator).map_err(parameter)
    }
}

impl BodyValues {
    /// The body in single precision and in the memory of a device: nothing is allocated when it starts anew.
    ///
    /// # Errors
    /// A scheme that runs on no device, in words.
    pub fn on_device(&self, t: Seconds) -> Result<VirtualBody<f32, DeviceOperator>, String> {
        let made = if let Some(lag_s) = self.lag_s {
            // y ← g·x − g·x₁ + k·y₁, as of a LaggedRate
            let (gain, kept) = (1.0 / (t.0 + lag_s), lag_s / (t.0 + lag_s));
            let values = [gain, -gain, -kept].map(|value| value as f32);
            DeviceOperator::new(Form::Recursion, 0, &values)
        } else {
            let order = self.operator.order();
            let built =
                rendered::<f32>(self.scheme, order, t).map_err(|error| error.to_string())?;
            let Some(list) = built.list() else {
                let scheme = self.scheme;
                return Err(format!(
                    "body_scheme = {scheme} runs on no device: give full"
                ));
            };
            DeviceOperator::new(list.form, list.integer, &list.values)
        };
        let operator = made.map_err(|error| {
            format!("body_scheme has more than {COEFFICIENTS_MAX} taps, or another flaw ({error}): give full")
        })?;
        let damping = NewtonSecondsPerMetre(self.damping);
        let body = VirtualBody::new(self.inertance, damping, operator);
        body.map_err(|error| error.to_string())
    }
}

/// The operator of a body: of a scheme, or the rate of a lagged mass.
#[derive(Clone, Debug)]
pub enum BodyOperator {
    /// `D^α` of any scheme.
    Of(Box<Operator<f64>>),
    /// s/(1 + τ·s).
    Lagged(LaggedRate<f64>),
}

/// History of a [`BodyOperator`].
#[derive(Clone, Debug)]
pub enum BodyHistory {
    /// That of a scheme.
    Of(Box<OperatorHistory<f64>>),
    /// That of a lagged mass.
    Lagged(LaggedRateHistory<f64>),
}

impl Differintegrator<f64> for BodyOperator {
    type History = BodyHistory;

    fn at_rest(&self) -> BodyHistory {
        match self {
            Self::Of(operator) => BodyHistory::Of(Box::new(operator.at_rest())),
            Self::Lagged(rate) => BodyHistory::Lagged(rate.at_rest()),
        }
    }

    fn direct_gain(&self) -> f64 {
        match self {
            Self::Of(operator) => operator.direct_gain(),
            Self::Lagged(rate) => rate.direct_gain(),
        }
    }

    fn past(&self, history: &BodyHistory) -> f64 {
        match (self, history) {
            (Self::Of(operator), BodyHistory::Of(history)) => operator.past(history),
            (Self::Lagged(rate), BodyHistory::Lagged(history)) => rate.past(history),
            // Not a number is a fault of the motion chain.
            _ => f64::NAN,
        }
    }

    fn advance(&self, history: &mut BodyHistory, x: f64) {
        match (self, history) {
            (Self::Of(operator), BodyHistory::Of(history)) => operator.advance(history, x),
            (Self::Lagged(rate), BodyHistory::Lagged(history)) => rate.advance(history, x),
            _ => {}
        }
    }

    fn memory_length(&self) -> Option<usize> {
        match self {
            Self::Of(operator) => operator.memory_length(),
            Self::Lagged(rate) => rate.memory_length(),
        }
    }
}

/// The robot's own loop, as the analysis and as its twin in virtual time have it.
struct OwnLoop {
    analysed: VelocityLoop,
    simulated: RobotLoop,
    dead_time_s: f64,
}

impl OwnLoop {
    /// The loop of bandwidth, damping ratio and dead time.
    fn second_order(table: &Table<'_>) -> Result<Self, Failure> {
        let [frequency, dead_time] =
            [&ROBOT_BANDWIDTH, &ROBOT_DEAD_TIME].map(|key| measured(table, key));
        let (frequency, ratio) = (frequency?, table.number(&ROBOT_DAMPING)?);
        Ok(Self {
            analysed: VelocityLoop::second_order(frequency, ratio).map_err(analysed)?,
            simulated: RobotLoop::second_order(Hertz(frequency), ratio).map_err(parameter)?,
            dead_time_s: dead_time?,
        })
    }

    /// The loop of `[state_space]`, in place of those keys.
    fn of_states(table: &Table<'_>, states: &Table<'_>) -> Result<Self, FileError> {
        let idle = [
            (table, &ROBOT_BANDWIDTH),
            (table, &ROBOT_DAMPING),
            (table, &ROBOT_DEAD_TIME),
            (states, &STATE_B_HAND),
            (states, &STATE_C_HAND),
            (states, &CURRENT_LAG),
        ];
        if let Some((table, key)) = idle.into_iter().find(|(table, key)| table.has(key)) {
            let reason = format!(
                "{} has no effect: [state_space] has the robot's loop by a, b, c and delay_s, and [admittance] its hands; omit it",
                key.key
            );
            return Err(table.fail_at(key.key, reason));
        }
        let rows = states.matrix(&STATE_A)?;
        let [b, c] = [&STATE_B, &STATE_C].map(|key| states.numbers(key));
        let (b, c) = (b?, c?);
        let n = b.len();
        let is_square = rows.len() == n && rows.iter().all(|row| row.len() == n);
        if !is_square || c.len() != n || !(1..=LOOP_STATES).contains(&n) {
            let reason = format!(
                "a has {} rows for {n} numbers of b and {} of c: a robot has from 1 to {LOOP_STATES} states, as many of each",
                rows.len(),
                c.len()
            );
            return Err(states.fail_at(STATE_A.key, reason));
        }
        let motion = VelocityLoop::from_matrices(&rows.concat(), &b, &c);
        let mut simulated = RobotLoop {
            a: SMatrix::zeros(),
            b: SVector::zeros(),
            c: SVector::zeros(),
        };
        for (row, values) in rows.iter().enumerate() {
            (simulated.b[row], simulated.c[row]) = (b[row], c[row]);
            for (column, value) in values.iter().enumerate() {
                simulated.a[(row, column)] = *value;
            }
        }
        Ok(Self {
            analysed: motion.map_err(|error| states.fail_at(STATE_A.key, error))?,
            simulated,
            dead_time_s: states.required(&DEAD_TIME)?,
        })
    }
}

impl RobotInHands {
    /// The robot of these keys and its hands, at this sample time, s: without bandwidth and dead time there is no verdict on it.
    ///
    /// # Errors
    /// A missing key, one without effect, or a number outside its range.
    pub fn of(table: &Table<'_>, t: f64) -> Result<Self, Failure> {
        Self::with_loop(table, OwnLoop::second_order(table)?, t)
    }

    fn with_loop(table: &Table<'_>, own: OwnLoop, t: f64) -> Result<Self, Failure> {
        let filter = match table.number_if(&FORCE_CUTOFF)? {
            Some(cutoff_hz) => ForceFilter {
                cutoff_hz,
                lags: table.count_in(&FORCE_LAGS, 1..=4)?,
            },
            None if table.has(&FORCE_LAGS) => {
                let reason =
                    format!("it has no effect without {FORCE_CUTOFF}: give that too, or omit it");
                return Err(table.fail_at(FORCE_LAGS.key, reason).into());
            }
            None => ForceFilter::NONE,
        };
        let tool = table.number(&TOOL_MASS)?;
        let robot = Robot::new(own.analysed, own.dead_time_s, filter, tool, t);
        let robot = robot.map_err(analysed)?;
        let simulated = SimulatedRobotConfig {
            dead_time: Seconds(own.dead_time_s),
            sensor_lags: filter.lags,
            sensor_bandwidth: Hertz(filter.cutoff_hz),
            ..SimulatedRobotConfig::of(Seconds(t), own.simulated, RobotHand::relaxed())
        };
        let [mass, damping, stiffness] =
            [&HANDS_MASS, &HANDS_DAMPING, &HANDS_STIFFNESS].map(|key| ends(table, key));
        Ok(Self {
            robot,
            simulated,
            hands: [mass?, damping?, stiffness?],
        })
    }

    /// A body in one hand and one world.
    ///
    /// # Errors
    /// A number that the analysis does not take.
    pub fn in_hand<'a>(
        &'a self,
        body: &'a BodyValues,
        hand: HandImpedance,
        world: Option<AdmittanceWorld<'a>>,
    ) -> Result<AdmittanceLoop<'a>, Failure> {
        AdmittanceLoop::new(&self.robot, body.virtual_body(), hand, world).map_err(analysed)
    }

    /// The hands at the corners of the box, each once: mass, damping, stiffness.
    pub fn corners(&self) -> impl Iterator<Item = HandImpedance> {
        // Ends of a number that is alone are twins.
        let is_corner = |which: &[usize; 3]| {
            let mut ends = which.iter().zip(&self.hands);
            ends.all(|(end, [low, high])| *end == 0 || low < high)
        };
        let all = (0..8_usize).map(|which| [0, 1, 2].map(|number| which >> number & 1));
        all.filter(is_corner).map(|which| self.hand(which))
    }

    /// The hand of these ends: 0 the least, 1 the largest.
    #[must_use]
    pub fn hand(&self, which: [usize; 3]) -> HandImpedance {
        let [mass_kg, damping_n_s_per_m, stiffness_n_per_m] =
            [0, 1, 2].map(|number| self.hands[number][which[number]]);
        HandImpedance {
            mass_kg,
            damping_n_s_per_m,
            stiffness_n_per_m,
        }
    }

    /// A box with all of the hands.
    ///
    /// # Errors
    /// A number that the analysis does not take.
    pub fn with_hands<'a>(&self, mut all: AdmittanceBox<'a>) -> Result<AdmittanceBox<'a>, Failure> {
        let numbers = [
            AdmittanceNumber::HandMass,
            AdmittanceNumber::HandDamping,
            AdmittanceNumber::HandStiffness,
        ];
        for (number, ends) in numbers.into_iter().zip(self.hands) {
            all = all.with(number, ends).map_err(analysed)?;
        }
        Ok(all)
    }

    /// All hands, and all worlds from free space to the one that is given.
    ///
    /// # Errors
    /// A number that the analysis does not take.
    pub fn all<'a>(
        &'a self,
        body: &'a BodyValues,
        world: Option<AdmittanceWorld<'a>>,
    ) -> Result<AdmittanceBox<'a>, Failure> {
        let middle = self.in_hand(body, self.hand([0; 3]), world)?;
        let mut all = self.with_hands(AdmittanceBox::around(&middle))?;
        if let Some(world) = world {
            for (number, most) in [
                (AdmittanceNumber::WorldStiffness, world.stiffness_n_per_m),
                (
                    AdmittanceNumber::WorldDissipation,
                    world.dissipation_n_s_mu_per_m,
                ),
            ] {
                all = all.with(number, [0.0, most]).map_err(analysed)?;
            }
        }
        Ok(all)
    }

    /// The simulated robot in this hand, behind a body and a chain, armed and at rest: the noise of its sensor begins with this seed.
    ///
    /// # Errors
    /// A robot, body or limit outside its range; noise so large that nobody would arm it.
    pub fn simulated(
        &self,
        body: &BodyValues,
        limits: &MotionLimits<1>,
        hand: HandImpedance,
        seed: u64,
    ) -> Result<Admittance<f64, 1, BodyOperator, SimulatedRobot<1>>, Failure> {
        let config = SimulatedRobotConfig {
            hand: RobotHand {
                mass: Kilograms(hand.mass_kg + self.robot.tool_mass_kg()),
                damping: NewtonSecondsPerMetre(hand.damping_n_s_per_m),
                stiffness: NewtonsPerMetre(hand.stiffness_n_per_m),
            },
            seed,
            ..self.simulated
        };
        let t = config.sample_time;
        let robot = SimulatedRobot::<1>::new(config).map_err(parameter)?;
        let chain = MotionChain::new(limits, t).map_err(parameter)?;
        let mut device = Admittance::new(robot, body.rendered(t)?, chain);
        for _ in 0..(limits.rest_time.0 / t.0) as usize + 2 {
            device.rest().map_err(Failure::run)?;
        }
        match device.arm() {
            Ok(_) => Ok(device),
            Err(
                error @ (MotionStartRefused::Offset { .. } | MotionStartRefused::Unsteady { .. }),
            ) => Err(bad_input!(
                "{error}: of a simulated robot lower {ROBOT_NOISE}, or give more {ROBOT_RANGE}"
            )),
            Err(MotionStartRefused::Outside { .. }) => Err(bad_input!(
                "a trial begins at 0 m, which is not between the ends of the robot's way: change {MOTION_LOW} or {MOTION_HIGH}"
            )),
            Err(error) => Err(Failure::run(error)),
        }
    }
}

impl RobotModel {
    /// The robot of a table with [`ADMITTANCE_TABLE`], at this sample time, s.
    ///
    /// # Errors
    /// A missing or wrong key, with its place.
    pub fn of(table: &Table<'_>, t: f64) -> Result<Self, FileError> {
        Self::by(table, None, t)
    }

    /// The robot of a table, with its loop by states where there is one.
    fn by(table: &Table<'_>, states: Option<&Table<'_>>, t: f64) -> Result<Self, FileError> {
        let refused = |failure: Failure| {
            if let Failure::Input(Cause::Document(error)) = failure {
                *error
            } else {
                table.fail(failure)
            }
        };
        let own = match states {
            Some(states) => OwnLoop::of_states(table, states)?,
            None => OwnLoop::second_order(table).map_err(refused)?,
        };
        let mut place = RobotInHands::with_loop(table, own, t).map_err(refused)?;
        let body = BodyValues::of(table, t).map_err(refused)?;
        let limits = limits(table, t)?;
        place.simulated.sensor_range = limits.sensor_range;
        place.simulated.sensor_noise = Newtons(table.number(&ROBOT_NOISE)?);
        Ok(Self {
            place,
            body,
            limits,
        })
    }

    /// The robot of a device file, at this sample time, s; `path` is for messages.
    ///
    /// # Errors
    /// A file that is wrong, or describes something else, with its place.
    pub fn parse(path: &Path, text: &str, t: f64) -> Result<Self, FileError> {
        in_file(path, text, |table, states| Self::by(table, states, t))
    }
}

impl OwnRobot {
    /// The robot of a device file, at this sample time, s; `path` is for messages.
    ///
    /// # Errors
    /// A file that is wrong, or describes something else, with its place; one of bandwidth and dead time without the other.
    pub fn parse(path: &Path, text: &str, t: f64) -> Result<Self, FileError> {
        in_file(path, text, |table, states| {
            let is_known = [&ROBOT_BANDWIDTH, &ROBOT_DEAD_TIME].map(|key| table.has(key));
            if states.is_none() && is_known == [false; 2] {
                let limits = limits(table, t)?;
                return Ok(Self {
                    limits,
                    model: None,
                });
            }
            let model = RobotModel::by(table, states, t)?;
            Ok(Self {
                limits: model.limits,
                model: Some(model),
            })
        })
    }
}

/// A number that must be there, which a measurement finds.
fn measured(table: &Table<'_>, key: &Parameter) -> Result<f64, FileError> {
    table.number_if(key)?.ok_or_else(|| {
        let missing = format!("missing key `{}` in [{}]", key.key, table.name);
        let advice = format!(": give {key}, which `device measure` finds on the robot");
        table.fail(missing).of_file(advice)
    })
}

/// The device file of a robot, whose loop this program measured: with the places for all else.
pub fn measured_file(
    values: [f64; 3],
    intervals: &[Interval],
    program: &str,
    note: &str,
) -> String {
    let keys = [ROBOT_BANDWIDTH, ROBOT_DAMPING, ROBOT_DEAD_TIME];
    let mut text = "[admittance]\n".to_owned();
    for (key, value) in keys.iter().zip(values) {
        text += &format!("{} = {value:?}\n", key.key);
    }
    text += &format!(
        "# The body that a hand moves has to be chosen: {}, {}, {}\n",
        BODY_INERTANCE.key, BODY_DAMPING.key, BODY_ORDER.key
    );
    text += "\n# 95 of 100 such intervals have the true value in them.\n[intervals]\n";
    for Interval { key, low, high } in intervals {
        text += &format!("{key} = [{low:?}, {high:?}]\n");
    }
    text + &made_by(program, note)
}

/// The limits of motion of a table.
fn limits(table: &Table<'_>, t: f64) -> Result<MotionLimits<1>, FileError> {
    let range = Newtons(table.number(&ROBOT_RANGE)?);
    let [low, high] = [table.number(&MOTION_LOW)?, table.number(&MOTION_HIGH)?];
    if low >= high {
        let reason = format!(
            "motion_low_m = {} is not below motion_high_m = {}: exchange them",
            Shown(low),
            Shown(high)
        );
        return Err(table.fail_at(MOTION_LOW.key, reason));
    }
    let limits = MotionLimits::of(
        MetresPerSecond(table.number(&MOTION_SPEED)?),
        MetresPerSecondSquared(table.number(&MOTION_ACCELERATION)?),
        [Metres(low)],
        [Metres(high)],
        range,
    );
    let checked: Result<MotionChain<f64, 1>, LoopParameterError> =
        MotionChain::new(&limits, Seconds(t));
    checked.map_err(|error| table.fail(error))?;
    Ok(limits)
}

/// The table of a device file, read.
fn in_file<T>(
    path: &Path,
    text: &str,
    read: impl FnOnce(&Table<'_>, Option<&Table<'_>>) -> Result<T, FileError>,
) -> Result<T, FileError> {
    let document = Parsed::of(path, text)?;
    let choice = "the device file of a robot has [admittance]";
    let beside = ["source", INTERVALS, STATES];
    let (_, table, mut tables) = document.one_of(&[ADMITTANCE], &beside, "device", choice)?;
    if let Some(source) = tables.remove("source") {
        source_of(source)?;
    }
    if let Some(intervals) = tables.remove(INTERVALS) {
        intervals.with_keys(&[(INTERVALS, ROBOT)])?;
    }
    let states = tables.remove(STATES);
    let states = states.map(|states| states.with_keys(&[(STATES, STATE_PLANT)]));
    let states = states.transpose()?;
    let table = table.with_keys(&[(ADMITTANCE, ADMITTANCE_TABLE)])?;
    read(&table, states.as_ref())
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracdiff::FrequencyResponse as _;
    use testkit::Tested;

    const ROBOT: &str = "[admittance]\nbandwidth_hz = 10\ndead_time_s = 0.004\nbody_inertance_n_s_mu_per_m = 8\nbody_damping_n_s_per_m = 20\n";

    fn read(text: &str) -> Result<RobotModel, FileError> {
        RobotModel::parse(Path::new("robot.toml"), text, 2e-3)
    }

    #[test]
    fn a_robot_without_dead_time_bandwidth_or_body_is_refused_by_its_key() {
        for key in ["bandwidth_hz", "dead_time_s", "body_inertance_n_s_mu_per_m"] {
            let lines: Vec<&str> = ROBOT
                .lines()
                .filter(|line| !line.starts_with(key))
                .collect();
            let refused = read(&lines.join("\n"))
                .expect_err("half a robot")
                .to_string();
            assert!(refused.contains(key), "{refused}");
        }
        let ends = read(&format!("{ROBOT}motion_low_m = 0.4\n")).expect_err("ends");
        assert!(ends.to_string().contains("motion_low_m = 0.4"), "{ends}");
    }

    #[test]
    fn a_loop_by_its_states_is_the_robot_of_its_bandwidth_and_what_is_none_is_refused() {
        let omega = core::f64::consts::TAU * 10.0;
        let body = "[admittance]\nbody_inertance_n_s_mu_per_m = 8\nbody_damping_n_s_per_m = 20\n";
        let good = format!(
            "{body}[state_space]\na = [[0, {omega:?}], [-{omega:?}, {:?}]]\nb = [0, {omega:?}]\nc = [1, 0]\ndelay_s = 0.004\n",
            -1.6 * omega
        );
        let [states, known] = [good.as_str(), ROBOT].map(|text| read(text).expect("a robot").place);
        assert_eq!(states.simulated, known.simulated);
        for hz in [0.3, 4.0, 60.0] {
            let [a, b] = [&states, &known].map(|place| place.robot.way(hz));
            assert_eq!(a, b);
        }
        let bad = |from: &str, to: &str| {
            let refused = read(&good.replacen(from, to, 1)).expect_err(to);
            refused.to_string()
        };
        for (from, to, words) in [
            ("delay_s = 0.004", "", "delay_s"),
            (
                "[state",
                "damping_ratio = 1\n[state",
                "damping_ratio has no effect",
            ),
            (
                "delay_s",
                "c_hand = [1, 0]\ndelay_s",
                "c_hand has no effect",
            ),
            ("c = [1, 0]", "c = [1]", "2 numbers of b and 1 of c"),
            ("c = [1, 0]", "c = [3, 0]", "gain at rest"),
            (", -", ", ", "below 0"),
        ] {
            let refused = bad(from, to);
            assert!(
                refused.contains(words) && !refused.contains('\n'),
                "{refused}"
            );
        }
    }

    #[test]
    fn a_lagged_mass_runs_as_it_is_analysed_and_a_history_of_another_operator_gives_no_motion()
    -> Tested {
        let lagged = read(&format!("{ROBOT}body_lag_s = 0.05\n"))?;
        let plain = read(&format!("{ROBOT}body_order = 0.7\n"))?;
        let t = Seconds(2e-3);
        for model in [&lagged, &plain] {
            let body = model.body.rendered(t)?;
            let operator = body.operator();
            // The impulse response against the response of the analysis, at a quarter of the sample rate.
            let mut history = operator.at_rest();
            let mut sum = num_complex::Complex::new(0.0, 0.0);
            for n in 0..200_000_u32 {
                let y = operator.step(&mut history, if n == 0 { 1.0 } else { 0.0 });
                sum += num_complex::Complex::from_polar(
                    y,
                    -f64::from(n % 4) * core::f64::consts::FRAC_PI_2,
                );
            }
            let rate = libm::pow(t.0, -model.body.operator.order().get());
            let wanted = model.body.operator.response(core::f64::consts::FRAC_PI_2) * rate;
            assert!((sum / wanted - 1.0).norm() < 1e-6, "{sum} {wanted}");
        }
        let [a, b] = [&lagged, &plain].map(|model| model.body.rendered(t).expect("a body"));
        assert!(a.operator().past(&b.operator().at_rest()).is_nan());
        Ok(())
    }
}
