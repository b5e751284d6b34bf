//! A device that moves: stable for every hand of a box and every wall up to the one that is given, what the hand feels, and at which price.
//! ```text
//! hands × walls: m_h, b_h, k_h between their least and largest values, the world from free space to K + B·D^μ
//! ```
//! The verdict is a proof over the box, not over a grid of it; margins are those of its worst corner.

use crate::analysis::answer::{
    AdmittancePoint, Analysed, Drawn, FREQUENCIES_MOST, StableHands, logarithmic, operator,
};
use crate::analysis::keys::{
    ANALYSED_CONTROLLER, ANALYSED_SAMPLE_TIME, ANALYSED_SCHEME, ANALYSED_TISSUE, FELT_HIGH,
    FELT_LOW, POINTS,
};
use crate::analysis::law::{Law, of_a_tissue_alone};
use fracdiff::num_complex::Complex;
use haptic_analysis::{
    AdmittanceBox, AdmittanceLoop, AdmittanceMargins, AdmittanceNumber, BoxVerdict, EffortWeight,
    ForceFilter, HandImpedance, LoopOperator, Robot, VelocityLoop, VirtualBody, VirtualWorld,
};
use haptic_document::parameters::Parameter;
use haptic_document::{Failure, Table, rows};
use haptic_quantity::{digits, written};
use haptic_trial::advice::analysed;
use haptic_trial::keys::admittance::{
    BODY_DAMPING, BODY_INERTANCE, BODY_LAG, BODY_ORDER, BODY_SCHEME, FORCE_CUTOFF, FORCE_LAGS,
    HANDS_DAMPING, HANDS_MASS, HANDS_STIFFNESS, ROBOT_BANDWIDTH, ROBOT_DAMPING, ROBOT_DEAD_TIME,
    TOOL_MASS,
};
use haptic_trial::keys::wall::{DISSIPATION, ORDER, STIFFNESS};
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

/// Stiffest hand and wall that are looked for, N/m.
const STIFFEST: f64 = 1e6;
/// Largest factor on a body that is looked for.
const HEAVIEST: f64 = 1e4;
/// Springs of a map, from 1 N/m on.
const SOFTEST: f64 = 1.0;
const WALLS: usize = 49;
/// Frequencies at which the hand's port may give energy.
const PASSIVE_POINTS: usize = 2000;

/// A body on a robot, the hands that push it, and a world.
#[derive(Clone, Debug)]
pub(crate) struct MovingDevice {
    robot: Robot,
    body: Body,
    hands: [[f64; 2]; 3],
    world: Option<Law>,
    frequencies_hz: Vec<f64>,
    asked: Value,
}

/// A virtual body.
#[derive(Clone, Debug)]
struct Body {
    inertance: f64,
    damping: f64,
    operator: LoopOperator,
}

/// A corner of the box of hands.
#[derive(Clone, Copy, Debug)]
struct Corner {
    hand: HandImpedance,
    in_world: bool,
    margins: AdmittanceMargins,
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
        let inertance = table.required(&BODY_INERTANCE)?;
        let damping = table.number_if(&BODY_DAMPING)?.unwrap_or(0.0);
        if inertance == 0.0 && damping == 0.0 {
            let reason = format!("a body of nothing moves without end: give {BODY_DAMPING} too");
            return Err(table.fail_at(BODY_INERTANCE.key, reason).into());
        }
        let operator = match table.number_if(&BODY_LAG)? {
            Some(lag) => {
                if order.get().to_bits() != 1.0_f64.to_bits() || table.has(&BODY_SCHEME) {
                    let reason = format!(
                        "a lagged mass has order 1 and no scheme: omit {BODY_LAG}, or {BODY_ORDER} and {BODY_SCHEME}"
                    );
                    return Err(table.fail_at(BODY_LAG.key, reason).into());
                }
                LoopOperator::lagged_difference(lag / t).map_err(analysed)?
            }
            None => operator(table, &BODY_SCHEME, order, Some(t))?.1,
        };
        Ok(Self {
            inertance,
            damping,
            operator,
        })
    }

    const fn virtual_body(&self) -> VirtualBody<'_> {
        VirtualBody {
            inertance_n_s_alpha_per_m: self.inertance,
            damping_n_s_per_m: self.damping,
            operator: &self.operator,
        }
    }
}

/// The robot of these keys: without bandwidth and dead time there is no verdict on it.
fn robot(table: &Table<'_>, t: f64) -> Result<Robot, Failure> {
    let motion = VelocityLoop::second_order(
        table.required(&ROBOT_BANDWIDTH)?,
        table.number(&ROBOT_DAMPING)?,
    );
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
    Robot::new(motion.map_err(analysed)?, dead_time, filter, tool, t).map_err(analysed)
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
    pub(super) fn of(table: &Table<'_>) -> Result<Self, Failure> {
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
        let (robot, body) = (robot(table, t)?, Body::of(table, t)?);
        let asked = json!({
            "body_order": body.operator.order().get(),
            "body_inertance_n_s_mu_per_m": body.inertance,
            "body_damping_n_s_per_m": body.damping,
            "body_lag_s": table.number_if(&BODY_LAG)?,
            "hand_mass_kg": hands[0],
            "hand_damping_n_s_per_m": hands[1],
            "hand_stiffness_n_per_m": hands[2],
            "stiffness_n_per_m": world.as_ref().and_then(|law| law.of_wall(law.stiffness)),
            "dissipation_n_s_mu_per_m": world.as_ref().and_then(|law| law.of_wall(law.dissipation)),
            "sample_time_s": t,
        });
        let in_place = world.as_ref().map(Law::in_place_result);
        Ok(Self {
            robot,
            body,
            hands,
            frequencies_hz: logarithmic(low, high, count).collect(),
            asked: rows([asked].into_iter().chain(in_place)).into(),
            world,
        })
    }

    /// K and B of the world.
    fn gains(law: &Law) -> [f64; 2] {
        [law.stiffness, law.dissipation].map(|gain| gain.unwrap_or(0.0))
    }

    fn world(&self) -> Option<VirtualWorld<'_>> {
        let law = self.world.as_ref()?;
        let [stiffness_n_per_m, dissipation_n_s_mu_per_m] = Self::gains(law);
        Some(VirtualWorld {
            stiffness_n_per_m,
            dissipation_n_s_mu_per_m,
            operator: &law.operator,
            delay_samples: 0,
        })
    }

    fn in_hand<'a>(
        &'a self,
        hand: HandImpedance,
        world: Option<VirtualWorld<'a>>,
    ) -> Result<AdmittanceLoop<'a>, Failure> {
        AdmittanceLoop::new(&self.robot, self.body.virtual_body(), hand, world).map_err(analysed)
    }

    /// The hand of these ends: 0 the least, 1 the largest.
    fn hand(&self, which: [usize; 3]) -> HandImpedance {
        let [mass_kg, damping_n_s_per_m, stiffness_n_per_m] =
            [0, 1, 2].map(|number| self.hands[number][which[number]]);
        HandImpedance {
            mass_kg,
            damping_n_s_per_m,
            stiffness_n_per_m,
        }
    }

    fn with_hands<'a>(&self, mut all: AdmittanceBox<'a>) -> Result<AdmittanceBox<'a>, Failure> {
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
    fn all(&self) -> Result<AdmittanceBox<'_>, Failure> {
        let middle = self.in_hand(self.hand([0; 3]), self.world())?;
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

    /// The corner that bears the least more of a hand.
    fn worst(&self) -> Result<Option<Corner>, Failure> {
        let worlds: &[bool] = if self.world.is_some() {
            &[false, true]
        } else {
            &[false]
        };
        let mut worst: Option<Corner> = None;
        for &in_world in worlds {
            for which in 0..8_usize {
                let hand = self.hand([0, 1, 2].map(|number| which >> number & 1));
                let world = if in_world { self.world() } else { None };
                let Ok(margins) = self.in_hand(hand, world)?.margins() else {
                    return Ok(None);
                };
                let room = |margins: &AdmittanceMargins| {
                    margins.hand_up.map_or(f64::INFINITY, |at| at.value)
                };
                if worst.is_none_or(|worst| room(&margins) < room(&worst.margins)) {
                    worst = Some(Corner {
                        hand,
                        in_world,
                        margins,
                    });
                }
            }
        }
        Ok(worst)
    }

    pub(crate) fn answer(&self) -> Result<Analysed, Failure> {
        let all = self.all()?;
        let verdict = all.verdict();
        let stable = match verdict {
            BoxVerdict::Proved => Some(true),
            BoxVerdict::Unstable(_) => Some(false),
            _ => None,
        };
        let t = self.robot.sample_time_s();
        let unproved_hz = match verdict {
            BoxVerdict::Unproved { theta } => Some(theta / (TAU * t)),
            _ => None,
        };
        let proof = json!({
            "stable": stable,
            "stable_reason": stable.is_none().then_some("the hands that were tried are stable; the proof for all between them ended at this frequency"),
            "unproved_hz": unproved_hz,
            "unstable_hand": unstable(verdict),
        });
        let least_body = all.least_body(HEAVIEST);
        let limits = json!({
            "least_body_factor": least_body,
            "least_body_factor_reason": least_body.is_none().then_some("not even 10 000 times the body is proved for these hands and worlds"),
        });
        let worst = self.worst()?;
        let hand = match (verdict, &worst) {
            (_, Some(worst)) => worst.hand,
            (BoxVerdict::Unstable([_, _, mass, damping, stiffness, ..]), _) => HandImpedance {
                mass_kg: mass - self.robot.tool_mass_kg(),
                damping_n_s_per_m: damping,
                stiffness_n_per_m: stiffness,
            },
            _ => self.hand([1, 0, 1]),
        };
        let walls = self.walls(&all, hand)?;
        let margins = worst.map_or_else(|| json!({}), |worst| self.margins(&worst));
        let points = self.points()?;
        let felt = self.felt()?;
        let report = rows([self.asked.clone(), proof, limits, walls, margins, felt]);
        let law = self.world.as_ref().map(|law| {
            let gain = law
                .of_wall(law.stiffness)
                .map(|k| written("stiffness_n_per_m", k));
            law.words(gain).join(" · ")
        });
        Ok(Analysed {
            report,
            about: format!(
                "body of order α = {} · {}",
                digits(self.body.operator.order().get(), 4),
                law.unwrap_or_else(|| "free space".to_owned())
            ),
            drawn: Some(Drawn::Admittance {
                points,
                stable: self.map(hand)?,
            }),
        })
    }

    /// The springs that are stable in this hand, and those proved from free space on for all hands.
    fn walls(&self, all: &AdmittanceBox<'_>, hand: HandImpedance) -> Result<Value, Failure> {
        let spring = Law::spring(1.0, self.robot.sample_time_s())?.operator;
        let subject = self.in_hand(hand, Some(of_spring(&spring, 1.0)))?;
        let stable = subject.stable_values(AdmittanceNumber::WorldStiffness, [0.0, STIFFEST]);
        let free = AdmittanceBox::around(&self.in_hand(hand, Some(of_spring(&spring, 0.0)))?);
        let proved = self
            .with_hands(free)?
            .largest(AdmittanceNumber::WorldStiffness, STIFFEST);
        let proved = proved.map_err(analysed)?;
        let stiffest = all
            .largest(AdmittanceNumber::HandStiffness, STIFFEST)
            .map_err(analysed)?;
        Ok(json!({
            "largest_hand_stiffness_n_per_m": stiffest.filter(|most| *most < STIFFEST),
            "largest_hand_stiffness_reason": stiffest.map_or(
                Some("not even the least one is proved with the other hands"),
                |most| (most >= STIFFEST).then_some("any up to 1 MN/m"),
            ),
            "largest_spring_n_per_m": proved,
            "largest_spring_reason": proved.map_or(
                "free space is not proved for these hands",
                |_| "every softer one is proved too, for all hands",
            ),
            "stable_springs_n_per_m": stable,
            "stable_springs_reason": if stable.is_empty() {
                "in the worst hand no spring is stable"
            } else {
                "from and to, in the worst hand"
            },
        }))
    }

    fn margins(&self, worst: &Corner) -> Value {
        let t = self.robot.sample_time_s();
        let margins = &worst.margins;
        let hand = worst.hand;
        json!({
            "worst_hand": {
                "mass_kg": hand.mass_kg,
                "damping_n_s_per_m": hand.damping_n_s_per_m,
                "stiffness_n_per_m": hand.stiffness_n_per_m,
                "in_world": worst.in_world,
            },
            "hand_up": margins.hand_up.map(|at| at.value),
            "hand_up_rad_s": margins.hand_up.map(|at| at.theta / t),
            "dead_time_margin_s": margins.dead_time.map(|at| at.value * t),
            "sensitivity_peak": margins.sensitivity.value,
            "sensitivity_peak_rad_s": margins.sensitivity.theta / t,
        })
    }

    /// What the hand feels of body and world, and its price.
    fn felt(&self) -> Result<Value, Failure> {
        let t = self.robot.sample_time_s();
        let free = self.in_hand(self.hand([0; 3]), None)?;
        let off = |hz: f64| -> Result<Option<f64>, Failure> {
            if hz > 0.5 / t {
                return Ok(None);
            }
            let felt = free.displayed_impedance(TAU * hz).map_err(analysed)?;
            let wanted = free.virtual_impedance(TAU * hz).map_err(analysed)?;
            Ok(Some((felt / wanted - 1.0).norm()))
        };
        // A port that gives energy at one frequency is not passive; dead time makes it so at some.
        let mut active: Option<f64> = None;
        for omega in logarithmic(1e-4 * PI / t, PI / t, PASSIVE_POINTS) {
            let felt = free.displayed_impedance(omega).map_err(analysed)?;
            if felt.re < 0.0 {
                active = Some(omega);
                break;
            }
        }
        let effort = |weight| free.effort(weight).map_err(analysed);
        Ok(json!({
            "effort_n_s_per_m": effort(EffortWeight::Hand)?,
            "effort_reason": "rms of the impedance in free space, 0.1 to 4 Hz, weight 1/(1 + (f/1 Hz)^2)^2",
            "flat_effort_n_s_per_m": effort(EffortWeight::Flat)?,
            "command_noise": free.command_noise(),
            "command_noise_unit": "m/s per N",
            "felt_error_at_1hz": off(1.0)?,
            "felt_error_at_3hz": off(3.0)?,
            "passive": active.map(|_| false),
            "passive_reason": active.map_or_else(
                || "not shown: a hand may push at several frequencies".to_owned(),
                |omega| format!("in free space it gives energy from {} on: with a dead time no robot is passive at all frequencies", written("frequency_hz", omega / TAU)),
            ),
        }))
    }

    fn points(&self) -> Result<Vec<AdmittancePoint>, Failure> {
        let free = self.in_hand(self.hand([0; 3]), None)?;
        let contact = match self.world() {
            None => None,
            world => Some(self.in_hand(self.hand([0; 3]), world)?),
        };
        let at = |hz: &f64| {
            let felt = |subject: &AdmittanceLoop<'_>| -> Result<[Complex<f64>; 2], Failure> {
                let omega = TAU * hz;
                let felt = subject.displayed_impedance(omega).map_err(analysed)?;
                Ok([felt, subject.virtual_impedance(omega).map_err(analysed)?])
            };
            let [free, free_virtual] = felt(&free)?;
            let contact = contact.as_ref().map(felt).transpose()?;
            Ok(AdmittancePoint {
                frequency_hz: *hz,
                free_n_s_per_m: free.norm(),
                free_degrees: free.arg().to_degrees(),
                free_virtual_n_s_per_m: free_virtual.norm(),
                contact_n_s_per_m: contact.map(|[felt, _]| felt.norm()),
                contact_degrees: contact.map(|[felt, _]| felt.arg().to_degrees()),
                contact_virtual_n_s_per_m: contact.map(|[_, wanted]| wanted.norm()),
            })
        };
        self.frequencies_hz.iter().map(at).collect()
    }

    /// Stiffnesses of a hand that are stable, spring by spring, and those that are asked for.
    fn map(&self, hand: HandImpedance) -> Result<StableHands, Failure> {
        let spring = Law::spring(1.0, self.robot.sample_time_s())?.operator;
        let springs = logarithmic(SOFTEST, STIFFEST, WALLS).map(|spring_n_per_m| {
            let subject = self.in_hand(hand, Some(of_spring(&spring, spring_n_per_m)))?;
            let hands = subject.stable_values(AdmittanceNumber::HandStiffness, [0.0, STIFFEST]);
            Ok((spring_n_per_m, hands))
        });
        let law = self.world.as_ref().filter(|law| law.dissipation.is_none());
        Ok(StableHands {
            mass_kg: hand.mass_kg,
            damping_n_s_per_m: hand.damping_n_s_per_m,
            springs: springs.collect::<Result<_, Failure>>()?,
            hands_n_per_m: self.hands[2],
            spring_n_per_m: law.and_then(|law| law.stiffness),
        })
    }
}

const fn of_spring(operator: &LoopOperator, stiffness_n_per_m: f64) -> VirtualWorld<'_> {
    VirtualWorld {
        stiffness_n_per_m,
        dissipation_n_s_mu_per_m: 0.0,
        operator,
        delay_samples: 0,
    }
}

/// The member that is not stable, if one was found; the tool is part of its mass.
fn unstable(verdict: BoxVerdict) -> Value {
    let BoxVerdict::Unstable([.., mass, damping, hand, stiffness, dissipation]) = verdict else {
        return Value::Null;
    };
    json!({
        "mass_kg": mass,
        "damping_n_s_per_m": damping,
        "stiffness_n_per_m": hand,
        "wall_stiffness_n_per_m": stiffness,
        "wall_dissipation_n_s_mu_per_m": dissipation,
    })
}
