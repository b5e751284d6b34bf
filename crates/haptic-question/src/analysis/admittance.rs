//! A device that moves: stable for every hand of a box and every wall up to the one that is given, what the hand feels, and at which price.
//! ```text
//! hands × walls: m_h, b_h, k_h between their least and largest values, the world from free space to K + B·D^μ
//! ```
//! The verdict is a proof over the box, not over a grid of it; margins are those of its worst corner.

mod best;
mod moving;
#[cfg(test)]
mod tests;
mod trial;

pub(crate) use moving::MovingDevice;
pub(crate) use trial::{RUN_S, RobotTap};

use crate::analysis::admittance::best::{Best, Front, bodies, stable_inertances};
use crate::analysis::admittance::moving::{Around, COUNT, NOISE};
use crate::analysis::admittance::trial::trials;
use crate::analysis::answer::{
    AdmittancePoint, Analysed, Drawn, StableBodies, StableHands, logarithmic,
};
use crate::analysis::law::Law;
use fracdiff::num_complex::Complex;
use haptic_analysis::{
    AdmittanceBox, AdmittanceLoop, AdmittanceMargins, AdmittanceNumber, AdmittanceWorld,
    BoxVerdict, EffortWeight, HandImpedance, LoopOperator,
};
use haptic_document::{Failure, rows};
use haptic_quantity::{digits, written};
use haptic_trial::advice::analysed;
use haptic_trial::robot::BodyValues;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};
use std::sync::atomic::AtomicBool;

/// Stiffest hand and wall that are looked for, N/m.
const STIFFEST: f64 = 1e6;
/// Factors on a body that are looked for.
const BODIES: [f64; 2] = [0.01, 1e3];
/// Springs of a map, from 1 N/m on.
const SOFTEST: f64 = 1.0;
const WALLS: usize = 49;
/// Dampings of a map of bodies, so many times less and more than the body's own, or than 0.1 N·s/m without one.
const DAMPINGS: usize = 25;
const BODIES_AROUND: f64 = 20.0;
const LEAST_DAMPING: f64 = 0.1;
/// Frequencies at which the hand's port may give energy.
const PASSIVE_POINTS: usize = 2000;

/// A corner of the box of hands.
#[derive(Clone, Copy, Debug)]
struct Corner {
    hand: HandImpedance,
    in_world: bool,
    margins: AdmittanceMargins,
}

/// A body in its surroundings.
struct Judged<'a> {
    around: &'a Around,
    body: &'a BodyValues,
    frequencies_hz: &'a [f64],
}

impl MovingDevice {
    /// Number of steps in the reported progress.
    pub(crate) const fn steps(&self) -> u64 {
        match (&self.body, self.seeks_front) {
            (Some(_), _) => 1,
            (None, false) => Best::STEPS,
            (None, true) => Best::STEPS + Front::STEPS,
        }
    }

    pub(crate) fn answer(
        &self,
        progress: &(dyn Fn(u64) + Sync),
        stop: &AtomicBool,
    ) -> Result<Analysed, Failure> {
        let judged = |body| {
            let judged = Judged {
                around: &self.around,
                body,
                frequencies_hz: &self.frequencies_hz,
            };
            judged.answer(&self.asked)
        };
        if let Some(body) = &self.body {
            return judged(body);
        }
        let found = bodies(&self.around, self.hand_margin, progress, stop)?;
        let mut answer = judged(found.body())?;
        answer.report.extend(found.rows());
        let sought = self.seeks_front.then(|| {
            let (around, margin) = (&self.around, self.hand_margin);
            Front::of(&found, around, margin, progress, stop)
        });
        let sought = sought.transpose()?;
        answer.report.extend(sought.iter().flat_map(Front::rows));
        if let Some(Drawn::Admittance { bodies, front, .. }) = &mut answer.drawn {
            *bodies = found.points();
            *front = sought.map_or_else(Vec::new, |front| front.points);
        }
        Ok(answer)
    }
}

impl Judged<'_> {
    /// The corner that bears the least more of a hand.
    fn worst(&self) -> Result<Option<Corner>, Failure> {
        let worlds: &[bool] = if self.around.world.is_some() {
            &[false, true]
        } else {
            &[false]
        };
        let mut worst: Option<Corner> = None;
        for &in_world in worlds {
            for hand in self.around.place.corners() {
                let world = if in_world { self.around.world() } else { None };
                let Ok(margins) = self.around.in_hand(self.body, hand, world)?.margins() else {
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

    fn answer(&self, asked: &Value) -> Result<Analysed, Failure> {
        let body = json!({
            "body_order": self.body.operator.order().get(),
            "body_inertance_n_s_mu_per_m": self.body.inertance,
            "body_damping_n_s_per_m": self.body.damping,
            "body_lag_s": self.body.lag_s,
        });
        let all = self.around.all(self.body)?;
        let verdict = all.verdict();
        let stable = match verdict {
            BoxVerdict::Proved => Some(true),
            BoxVerdict::Unstable(_) => Some(false),
            BoxVerdict::Unproved { .. } => None,
        };
        let t = self.around.place.robot.sample_time_s();
        let unproved_hz = match verdict {
            BoxVerdict::Unproved { theta } => Some(theta / (TAU * t)),
            BoxVerdict::Proved | BoxVerdict::Unstable(_) => None,
        };
        let proof = json!({
            "stable": stable,
            "stable_reason": stable.is_none().then_some("the hands that were tried are stable; the proof for all between them ended at this frequency"),
            "unproved_hz": unproved_hz,
            "unstable_hand": unstable(verdict, self.around.place.robot.tool_mass_kg()),
        });
        let least_body = all.least_body(BODIES);
        let limits = json!({
            "least_body_factor": least_body,
            "least_body_factor_reason": least_body.is_none().then_some("no factor on m and b from 0.01 to 1000 is proved for these hands and worlds"),
        });
        let worst = self.worst()?;
        let hand = match (verdict, &worst) {
            (_, Some(worst)) => worst.hand,
            (BoxVerdict::Unstable([_, _, mass, damping, stiffness, ..]), _) => HandImpedance {
                mass_kg: mass - self.around.place.robot.tool_mass_kg(),
                damping_n_s_per_m: damping,
                stiffness_n_per_m: stiffness,
            },
            _ => self.around.place.hand([1, 0, 1]),
        };
        let walls = self.walls(&all, hand)?;
        let margins = worst.map_or_else(|| json!({}), |worst| self.margins(&worst));
        let tried = trials(self.around, self.body)?;
        let tried = json!({
            "trials": tried.map(|tried| tried.runs),
            "trials_reason": tried.map_or_else(
                || "a world of several elements, or a controller, is not tried".to_owned(),
                |_| format!("a tap in each corner of the hands, with {} of noise and counts of {}", written("noise_n", NOISE.0), written("count_n", COUNT.0)),
            ),
            "settled_trials": tried.map(|tried| tried.settled),
        });
        let points = self.points()?;
        let felt = self.felt()?;
        let report = rows([
            body,
            asked.clone(),
            proof,
            tried,
            limits,
            walls,
            margins,
            felt,
        ]);
        let law = self.around.world.as_ref().map(|law| {
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
                stable_bodies: self.bodies()?,
                bodies: Vec::new(),
                front: Vec::new(),
            }),
        })
    }

    /// The springs that are stable in this hand, and those proved from free space on for all hands.
    fn walls(&self, all: &AdmittanceBox<'_>, hand: HandImpedance) -> Result<Value, Failure> {
        let spring = Law::spring(1.0, self.around.place.robot.sample_time_s())?.operator;
        let subject = self
            .around
            .in_hand(self.body, hand, Some(of_spring(&spring, 1.0)))?;
        let stable = subject.stable_values(AdmittanceNumber::WorldStiffness, [0.0, STIFFEST]);
        let free = AdmittanceBox::around(&self.around.in_hand(
            self.body,
            hand,
            Some(of_spring(&spring, 0.0)),
        )?);
        let proved = self
            .around
            .place
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
                "in the hand of the picture no spring is stable"
            } else {
                "from and to, in the hand of the picture"
            },
        }))
    }

    fn margins(&self, worst: &Corner) -> Value {
        let t = self.around.place.robot.sample_time_s();
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

    /// Impedance at the hand: its price, its errors, its passivity.
    fn felt(&self) -> Result<Value, Failure> {
        let t = self.around.place.robot.sample_time_s();
        let free = self
            .around
            .in_hand(self.body, self.around.place.hand([0; 3]), None)?;
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
            "command_noise_reason": "at half the sample rate",
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
        let free = self
            .around
            .in_hand(self.body, self.around.place.hand([0; 3]), None)?;
        let contact = match self.around.world() {
            None => None,
            world => Some(
                self.around
                    .in_hand(self.body, self.around.place.hand([0; 3]), world)?,
            ),
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

    /// Inertances of the body that are stable in all corners, damping by damping, around its own.
    fn bodies(&self) -> Result<StableBodies, Failure> {
        // A body without damping has no place on a logarithmic axis.
        let has_damping = self.body.damping > 0.0;
        let own = if has_damping {
            self.body.damping
        } else {
            LEAST_DAMPING
        };
        let dampings = logarithmic(own / BODIES_AROUND, own * BODIES_AROUND, DAMPINGS);
        let stable = dampings.map(|damping| {
            let body = BodyValues {
                damping,
                ..self.body.clone()
            };
            Ok((damping, stable_inertances(self.around, &body)?))
        });
        Ok(StableBodies {
            order: self.body.operator.order().get(),
            dampings: stable.collect::<Result<_, Failure>>()?,
            body: [self.body.damping, self.body.inertance],
        })
    }

    /// Stiffnesses of a hand that are stable, spring by spring, and those that are asked for.
    fn map(&self, hand: HandImpedance) -> Result<StableHands, Failure> {
        let spring = Law::spring(1.0, self.around.place.robot.sample_time_s())?.operator;
        let springs = logarithmic(SOFTEST, STIFFEST, WALLS).map(|spring_n_per_m| {
            let subject =
                self.around
                    .in_hand(self.body, hand, Some(of_spring(&spring, spring_n_per_m)))?;
            let hands = subject.stable_values(AdmittanceNumber::HandStiffness, [0.0, STIFFEST]);
            Ok((spring_n_per_m, hands))
        });
        let spring_n_per_m = match &self.around.world {
            None => Some(0.0),
            Some(law) if law.dissipation.is_some() => None,
            Some(law) => law.stiffness,
        };
        Ok(StableHands {
            mass_kg: hand.mass_kg,
            damping_n_s_per_m: hand.damping_n_s_per_m,
            springs: springs.collect::<Result<_, Failure>>()?,
            hands_n_per_m: self.around.place.hands[2],
            spring_n_per_m,
        })
    }
}

const fn of_spring(operator: &LoopOperator, stiffness_n_per_m: f64) -> AdmittanceWorld<'_> {
    AdmittanceWorld {
        stiffness_n_per_m,
        dissipation_n_s_mu_per_m: 0.0,
        operator,
        delay_samples: 0,
    }
}

/// The member that is not stable, if one was found, without the tool.
fn unstable(verdict: BoxVerdict, tool_kg: f64) -> Value {
    let BoxVerdict::Unstable([.., mass, damping, hand, stiffness, dissipation]) = verdict else {
        return Value::Null;
    };
    json!({
        "mass_kg": mass - tool_kg,
        "damping_n_s_per_m": damping,
        "stiffness_n_per_m": hand,
        "wall_stiffness_n_per_m": stiffness,
        "wall_dissipation_n_s_mu_per_m": dissipation,
    })
}
