//! The keys of a device that moves, and its loops in any hand and world.

use crate::analysis::answer::{FREQUENCIES_MOST, logarithmic};
use crate::analysis::keys::{
    ANALYSED_CONTROLLER, ANALYSED_SAMPLE_TIME, ANALYSED_SCHEME, ANALYSED_TISSUE, BEST_BODY,
    BODY_FRONT, FELT_HIGH, FELT_LOW, HAND_MARGIN, POINTS,
};
use crate::analysis::law::{Law, of_a_tissue_alone};
use haptic_analysis::{AdmittanceBox, AdmittanceLoop, AdmittanceWorld, HandImpedance};
use haptic_document::parameters::DEVICE_MODEL;
use haptic_document::{Failure, Table, rows};
use haptic_loop::plant::SimulatedRobotConfig;
use haptic_loop::units::Newtons;
use haptic_trial::device_table::robot;
use haptic_trial::keys::admittance::{BODY, PUSHING_HANDS, ROBOT};
use haptic_trial::keys::wall::{DISSIPATION, ORDER, STIFFNESS};
use haptic_trial::robot::{BodyValues, RobotInHands};
use serde_json::{Value, json};

/// The device of these keys, and what is asked of it.
#[derive(Clone, Debug)]
pub(crate) struct MovingDevice {
    pub(super) around: Around,
    /// `None` if the best one is sought.
    pub(super) body: Option<BodyValues>,
    /// Factor on the hands that it bears then.
    pub(super) hand_margin: f64,
    /// All bodies that none beats are sought too.
    pub(super) seeks_front: bool,
    pub(super) frequencies_hz: Vec<f64>,
    pub(super) asked: Value,
}

/// All but the body: the robot, the hands that push it, and a world.
#[derive(Clone, Debug)]
pub(super) struct Around {
    pub(super) place: RobotInHands,
    pub(super) world: Option<Law>,
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

/// Noise of the simulated force sensor, rms, and a count of it.
pub(super) const NOISE: Newtons = Newtons(0.05);
pub(super) const COUNT: Newtons = Newtons(0.01);

impl MovingDevice {
    pub(crate) fn of(table: &Table<'_>) -> Result<Self, Failure> {
        let t = table.required(&ANALYSED_SAMPLE_TIME)?;
        let world = world(table, t)?;
        let [low, high] = [table.number(&FELT_LOW)?, table.number(&FELT_HIGH)?];
        let most = 0.5 / t;
        if !(low < high && high <= most) {
            let reason = format!(
                "{low} to {high} Hz do not rise within {most} Hz, half the sample rate: change {FELT_LOW} or {FELT_HIGH}"
            );
            return Err(table.fail_at(FELT_HIGH.key, reason).into());
        }
        let count = table.count_in(&POINTS, 2..=FREQUENCIES_MOST)?;
        let known = robot(table, None, t)?;
        let mut place = match &known {
            Some(model) => {
                let mut written = ROBOT.iter().chain(PUSHING_HANDS);
                if let Some(key) = written.find(|key| table.has(key)) {
                    let reason = format!(
                        "the file of {DEVICE_MODEL} says it: change it there, or omit one of them"
                    );
                    return Err(table.fail_at(key.key, reason).into());
                }
                model.place.clone()
            }
            None if table.has(&DEVICE_MODEL) => {
                let reason =
                    "no [admittance] in it: a robot has its bandwidth, dead time and body there";
                return Err(table.fail_at(DEVICE_MODEL.key, reason).into());
            }
            None => RobotInHands::of(table, t)?,
        };
        // The trials meet no limit of the motion.
        place.simulated = SimulatedRobotConfig {
            sensor_range: Newtons(1e9),
            sensor_noise: NOISE,
            sensor_resolution: COUNT,
            ..place.simulated
        };
        let hands = place.hands;
        let body = if table.flag(&BEST_BODY)? {
            if let Some(key) = BODY.iter().find(|key| table.has(key)) {
                let reason =
                    format!("it has no effect with {BEST_BODY}, which looks for it: omit it");
                return Err(table.fail_at(key.key, reason).into());
            }
            None
        } else {
            let idle = [&HAND_MARGIN, &BODY_FRONT];
            if let Some(key) = idle.into_iter().find(|key| table.has(key)) {
                let reason =
                    format!("it has no effect without {BEST_BODY}: give that too, or omit it");
                return Err(table.fail_at(key.key, reason).into());
            }
            let is_given = BODY.iter().any(|key| table.has(key));
            Some(match known {
                Some(model) if !is_given => model.body,
                Some(_) | None => BodyValues::of(table, t)?,
            })
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
            seeks_front: table.flag(&BODY_FRONT)?,
            frequencies_hz: logarithmic(low, high, count).collect(),
            asked: rows([asked].into_iter().chain(in_place)).into(),
            around: Around { place, world },
        })
    }
}

impl Around {
    /// With hands that are so much heavier, stiffer and damp so much more, too.
    pub(super) fn with_margin(&self, factor: f64) -> Self {
        let hands = self.place.hands.map(|[low, high]| [low, factor * high]);
        Self {
            place: RobotInHands {
                hands,
                ..self.place.clone()
            },
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
        body: &'a BodyValues,
        hand: HandImpedance,
        world: Option<AdmittanceWorld<'a>>,
    ) -> Result<AdmittanceLoop<'a>, Failure> {
        self.place.in_hand(body, hand, world)
    }

    /// All hands, and all worlds from free space to the one that is given.
    pub(super) fn all<'a>(&'a self, body: &'a BodyValues) -> Result<AdmittanceBox<'a>, Failure> {
        self.place.all(body, self.world())
    }
}
