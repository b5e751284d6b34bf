//! The keys of a device that moves, and its loops in any hand and world.

use crate::analysis::answer::{FREQUENCIES_MOST, logarithmic, operator};
use crate::analysis::keys::{
    ANALYSED_CONTROLLER, ANALYSED_SAMPLE_TIME, ANALYSED_SCHEME, ANALYSED_TISSUE, BEST_BODY,
    FELT_HIGH, FELT_LOW, HAND_MARGIN, POINTS,
};
use crate::analysis::law::{Law, of_a_tissue_alone};
use fracdiff::{Scheme, Seconds};
use haptic_analysis::{
    AdmittanceBody, AdmittanceBox, AdmittanceLoop, AdmittanceNumber, AdmittanceWorld, ForceFilter,
    HandImpedance, LoopOperator, Robot, VelocityLoop,
};
use haptic_document::parameters::Parameter;
use haptic_document::{Failure, Table, rows};
use haptic_loop::plant::{RobotHand, RobotLoop, SimulatedRobotConfig};
use haptic_loop::units::{Hertz, Newtons};
use haptic_trial::advice::{analysed, parameter};
use haptic_trial::keys::admittance::{
    BODY, BODY_DAMPING, BODY_INERTANCE, BODY_LAG, BODY_ORDER, BODY_SCHEME, FORCE_CUTOFF,
    FORCE_LAGS, HANDS_DAMPING, HANDS_MASS, HANDS_STIFFNESS, ROBOT_BANDWIDTH, ROBOT_DAMPING,
    ROBOT_DEAD_TIME, TOOL_MASS,
};
use haptic_trial::keys::wall::{DISSIPATION, ORDER, STIFFNESS};
use serde_json::{Value, json};

/// The device of these keys, and what is asked of it.
#[derive(Clone, Debug)]
pub(crate) struct MovingDevice {
    pub(super) around: Around,
    /// `None` if the best one is sought.
    pub(super) body: Option<Body>,
    /// Factor on the hands that it bears then.
    pub(super) hand_margin: f64,
    pub(super) frequencies_hz: Vec<f64>,
    pub(super) asked: Value,
}

/// All but the body: the robot, the hands that push it, and a world.
#[derive(Clone, Debug)]
pub(super) struct Around {
    pub(super) robot: Robot,
    /// Its twin in virtual time, in no hand.
    pub(super) simulated: SimulatedRobotConfig,
    /// Least and largest mass, damping and stiffness.
    pub(super) hands: [[f64; 2]; 3],
    pub(super) world: Option<Law>,
}

/// Noise of the simulated force sensor, rms, and a count of it.
pub(super) const NOISE: Newtons = Newtons(0.05);
pub(super) const COUNT: Newtons = Newtons(0.01);

/// A virtual body.
#[derive(Clone, Debug)]
pub(super) struct Body {
    pub(super) inertance: f64,
    pub(super) damping: f64,
    pub(super) operator: LoopOperator,
    /// Lag of a lagged mass, s.
    pub(super) lag_s: Option<f64>,
    /// Scheme of its operator, without a lag.
    pub(super) scheme: Scheme,
}

/// Least and largest value of a key that takes one or both.
fn ends(table: &Table<'_>, key: &Parameter) -> Result<[f64; 2], Failure> {
    let given = table.numbers_if(key)?;
    match *given.unwrap_or_else(|| key.default_numbers()) {
        [one] => Ok([one; 2]),
        [low, high] if low <= high => Ok([low, high]),
        _ => {
            let reason = "it is one number, or the least and the largest one";
            Err(table.fail_at(key.key, reason).into())
        }
    }
}

impl Body {
    fn of(table: &Table<'_>, t: f64) -> Result<Self, Failure> {
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
            None => operator(table, &BODY_SCHEME, order, Some(t))?,
        };
        Ok(Self {
            inertance,
            damping,
            operator,
            lag_s,
            scheme,
        })
    }

    pub(super) const fn virtual_body(&self) -> AdmittanceBody<'_> {
        AdmittanceBody {
            inertance_n_s_alpha_per_m: self.inertance,
            damping_n_s_per_m: self.damping,
            operator: &self.operator,
        }
    }
}

/// The robot of these keys, for the analysis and in virtual time: without bandwidth and dead time there is no verdict on it.
fn robot(table: &Table<'_>, t: f64) -> Result<(Robot, SimulatedRobotConfig), Failure> {
    let (frequency, ratio) = (
        table.required(&ROBOT_BANDWIDTH)?,
        table.number(&ROBOT_DAMPING)?,
    );
    let motion = VelocityLoop::second_order(frequency, ratio).map_err(analysed)?;
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
    let dead_time = table.required(&ROBOT_DEAD_TIME)?;
    let tool = table.number(&TOOL_MASS)?;
    let robot = Robot::new(motion, dead_time, filter, tool, t).map_err(analysed)?;
    let turns = RobotLoop::second_order(Hertz(frequency), ratio).map_err(parameter)?;
    let simulated = SimulatedRobotConfig {
        dead_time: Seconds(dead_time),
        sensor_lags: filter.lags,
        sensor_bandwidth: Hertz(filter.cutoff_hz),
        sensor_range: Newtons(1e9),
        sensor_noise: NOISE,
        sensor_resolution: COUNT,
        ..SimulatedRobotConfig::of(Seconds(t), turns, RobotHand::relaxed())
    };
    Ok((robot, simulated))
}

/// The law in contact, if there is one. A spring alone has no order.
fn world(table: &Table<'_>, t: f64) -> Result<Option<Law>, Failure> {
    let in_place = [&ANALYSED_TISSUE, &ANALYSED_CONTROLLER];
    let is_in_place = in_place.iter().any(|key| table.has(key));
    if !is_in_place && !table.has(&DISSIPATION) {
        let idle = [&ORDER, &ANALYSED_SCHEME];
        if let Some(key) = idle.iter().find(|key| table.has(key)) {
            let reason =
                format!("it is of the dissipation of a wall: give {DISSIPATION}, or omit it");
            return Err(table.fail_at(key.key, reason).into());
        }
        of_a_tissue_alone(table)?;
        let Some(stiffness) = table.number_if(&STIFFNESS)? else {
            return Ok(None);
        };
        return Ok(Some(Law::spring(stiffness, t)?));
    }
    Ok(Some(Law::of(table, Some(t))?.0))
}

impl MovingDevice {
    pub(crate) fn of(table: &Table<'_>) -> Result<Self, Failure> {
        let t = table.required(&ANALYSED_SAMPLE_TIME)?;
        let world = world(table, t)?;
        let hands = [&HANDS_MASS, &HANDS_DAMPING, &HANDS_STIFFNESS];
        let [mass, damping, stiffness] = hands.map(|key| ends(table, key));
        let hands = [mass?, damping?, stiffness?];
        let [low, high] = [table.number(&FELT_LOW)?, table.number(&FELT_HIGH)?];
        let most = 0.5 / t;
        if !(low < high && high <= most) {
            let reason = format!(
                "{low} to {high} Hz do not rise within {most} Hz, half the sample rate: change {FELT_LOW} or {FELT_HIGH}"
            );
            return Err(table.fail_at(FELT_HIGH.key, reason).into());
        }
        let count = table.count_in(&POINTS, 2..=FREQUENCIES_MOST)?;
        let (robot, simulated) = robot(table, t)?;
        let body = if table.flag(&BEST_BODY)? {
            if let Some(key) = BODY.iter().find(|key| table.has(key)) {
                let reason =
                    format!("it has no effect with {BEST_BODY}, which looks for it: omit it");
                return Err(table.fail_at(key.key, reason).into());
            }
            None
        } else {
            if table.has(&HAND_MARGIN) {
                let reason =
                    format!("it has no effect without {BEST_BODY}: give that too, or omit it");
                return Err(table.fail_at(HAND_MARGIN.key, reason).into());
            }
            Some(Body::of(table, t)?)
        };
        let asked = json!({
            "hand_mass_kg": hands[0],
            "hand_damping_n_s_per_m": hands[1],
            "hand_stiffness_n_per_m": hands[2],
            "stiffness_n_per_m": world.as_ref().and_then(|law| law.of_wall(law.stiffness)),
            "dissipation_n_s_mu_per_m": world.as_ref().and_then(|law| law.of_wall(law.dissipation)),
            "sample_time_s": t,
        });
        let in_place = world.as_ref().map(Law::in_place_result);
        Ok(Self {
            body,
            hand_margin: table.number(&HAND_MARGIN)?,
            frequencies_hz: logarithmic(low, high, count).collect(),
            asked: rows([asked].into_iter().chain(in_place)).into(),
            around: Around {
                robot,
                simulated,
                hands,
                world,
            },
        })
    }
}

impl Around {
    /// With hands that are so much heavier, stiffer and damp so much more, too.
    pub(super) fn with_margin(&self, factor: f64) -> Self {
        Self {
            hands: self.hands.map(|[low, high]| [low, factor * high]),
            ..self.clone()
        }
    }

    /// K and B of the world.
    pub(super) fn gains(law: &Law) -> [f64; 2] {
        [law.stiffness, law.dissipation].map(|gain| gain.unwrap_or(0.0))
    }

    pub(super) fn world(&self) -> Option<AdmittanceWorld<'_>> {
        let law = self.world.as_ref()?;
        let [stiffness_n_per_m, dissipation_n_s_mu_per_m] = Self::gains(law);
        Some(AdmittanceWorld {
            stiffness_n_per_m,
            dissipation_n_s_mu_per_m,
            operator: &law.operator,
            delay_samples: 0,
        })
    }

    pub(super) fn in_hand<'a>(
        &'a self,
        body: &'a Body,
        hand: HandImpedance,
        world: Option<AdmittanceWorld<'a>>,
    ) -> Result<AdmittanceLoop<'a>, Failure> {
        AdmittanceLoop::new(&self.robot, body.virtual_body(), hand, world).map_err(analysed)
    }

    /// True of ends that are not a twin of others, as those of a number that is alone.
    pub(super) fn is_corner(&self, which: [usize; 3]) -> bool {
        (which.iter().zip(&self.hands)).all(|(end, [low, high])| *end == 0 || low < high)
    }

    /// The hand of these ends: 0 the least, 1 the largest.
    pub(super) fn hand(&self, which: [usize; 3]) -> HandImpedance {
        let [mass_kg, damping_n_s_per_m, stiffness_n_per_m] =
            [0, 1, 2].map(|number| self.hands[number][which[number]]);
        HandImpedance {
            mass_kg,
            damping_n_s_per_m,
            stiffness_n_per_m,
        }
    }

    pub(super) fn with_hands<'a>(
        &self,
        mut all: AdmittanceBox<'a>,
    ) -> Result<AdmittanceBox<'a>, Failure> {
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
    pub(super) fn all<'a>(&'a self, body: &'a Body) -> Result<AdmittanceBox<'a>, Failure> {
        let middle = self.in_hand(body, self.hand([0; 3]), self.world())?;
        let mut all = self.with_hands(AdmittanceBox::around(&middle))?;
        if let Some(law) = &self.world {
            let [stiffness, dissipation] = Self::gains(law);
            all = all
                .with(AdmittanceNumber::WorldStiffness, [0.0, stiffness])
                .map_err(analysed)?;
            all = all
                .with(AdmittanceNumber::WorldDissipation, [0.0, dissipation])
                .map_err(analysed)?;
        }
        Ok(all)
    }
}
