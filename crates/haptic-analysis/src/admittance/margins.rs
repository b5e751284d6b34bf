//! Margins of an admittance loop: how much heavier a hand, how much later a robot.

use super::closed::{AdmittanceLoop, AdmittanceNumber};
use super::robot::Robot;
use super::terms::{Family, Node, TERMS};
use crate::AnalysisError;
use crate::affine::weighted;
use crate::margin::stable_between;
use certified_count::{
    AtAngle, Bounds, Jet, Late, LoopTerms, OpenLoop, Peak, Unknown, delay_margin,
};
use core::f64::consts::PI;

/// The margins of a stable admittance loop. The open loop is the hand over the body with its world.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct AdmittanceMargins {
    /// The least factor above 1 on the whole hand that takes the loop to the boundary; `None` if none does.
    pub hand_up: Option<AtAngle>,
    /// The largest such factor below 1.
    pub hand_down: Option<AtAngle>,
    /// The least additional dead time of the robot that takes the loop to the boundary, samples; `None` if none does.
    pub dead_time: Option<AtAngle>,
    /// The largest sensitivity |1/(1 + L/(M + world))|.
    pub sensitivity: AtAngle,
}

/// Relative height by which another peak might exceed the one found.
const PEAK_TOLERANCE: f64 = 1e-6;
/// Parts of a sample of further dead time that are tried, and of such a part.
const PARTS: u32 = 16;
const FINER: u32 = 32;

/// F as the sum of two functions: all terms but some, and those.
struct Split<'a, 'b> {
    family: &'a Family<'b>,
    below: [f64; TERMS],
    above: [f64; TERMS],
}

impl<'a, 'b> Split<'a, 'b> {
    /// All terms but one, and one times 1.
    fn one(subject: &'a AdmittanceLoop<'b>, index: usize) -> Self {
        let (mut below, mut above) = (subject.coefficients, [0.0; TERMS]);
        below[index] = 0.0;
        above[index] = 1.0;
        Self {
            family: &subject.family,
            below,
            above,
        }
    }

    /// Body and world, and the hand.
    fn hand(subject: &'a AdmittanceLoop<'b>) -> Self {
        let (mut below, mut above) = (subject.coefficients, [0.0; TERMS]);
        for index in 2..5 {
            above[index] = core::mem::replace(&mut below[index], 0.0);
        }
        Self {
            family: &subject.family,
            below,
            above,
        }
    }

    /// Every factor above 0 on the second part with which F has a zero on the circle.
    fn crossings(&self) -> Vec<f64> {
        self.gain_crossings()
            .into_iter()
            .map(|at| at.value)
            .collect()
    }
}

impl OpenLoop for Split<'_, '_> {
    type Node = Node;

    fn terms(&self, theta: f64) -> LoopTerms<Node> {
        let node = self.family.node(theta);
        let part = |coefficients: &[f64; TERMS]| {
            Jet::new(
                node.terms.value(coefficients),
                node.terms.slope(coefficients),
            )
        };
        LoopTerms {
            theta,
            parts: [part(&self.below), part(&self.above)],
            node,
        }
    }

    fn bounds(&self, a: &LoopTerms<Node>, b: &LoopTerms<Node>) -> [Bounds; 2] {
        let terms = self.family.bounds(&a.node, &b.node);
        [&self.below, &self.above].map(|coefficients| weighted(&terms, coefficients))
    }

    fn angles(&self) -> Vec<f64> {
        Family::first_angles().collect()
    }
}

impl AdmittanceLoop<'_> {
    /// The values from `low` to `high` of one number, at least 0, with which the loop is stable, as intervals that rise; the others stay.
    #[must_use]
    pub fn stable_values(&self, number: AdmittanceNumber, [low, high]: [f64; 2]) -> Vec<[f64; 2]> {
        let unit = self.family.units()[number.index()];
        let crossings = Split::one(self, number.index());
        let crossings = crossings.crossings().into_iter().map(|at| at / unit);
        stable_between(crossings, [low, high], |value| {
            let mut coefficients = self.coefficients;
            coefficients[number.index()] = value * unit;
            self.family.verdict(&coefficients).stable
        })
    }

    /// All margins. *Cost*: some thousand values of F, most of them for the dead time.
    ///
    /// # Errors
    /// [`AnalysisError::NotStable`].
    pub fn margins(&self) -> Result<AdmittanceMargins, AnalysisError> {
        if !self.verdict().stable {
            return Err(AnalysisError::NotStable { what: "margins" });
        }
        let hand = Split::hand(self);
        let crossings = hand.gain_crossings();
        let order = |a: &AtAngle, b: &AtAngle| a.value.total_cmp(&b.value);
        let above = crossings.iter().filter(|at| at.value > 1.0);
        let below = crossings.iter().filter(|at| at.value < 1.0);
        Ok(AdmittanceMargins {
            hand_up: above.copied().min_by(order),
            hand_down: below.copied().max_by(order),
            dead_time: self.dead_time_margin(),
            sensitivity: hand.peak(Peak::Sensitivity, PEAK_TOLERANCE),
        })
    }

    fn dead_time_margin(&self) -> Option<AtAngle> {
        let delay = self.family.robot.dead_time().delay_samples();
        let mores: Vec<f64> = (0..PARTS)
            .map(|part| f64::from(part) / f64::from(PARTS))
            .collect();
        let later = |samples: f64| {
            let total = delay + samples;
            let robot = self.family.robot;
            let prompt = robot.delayed_by(total - libm::floor(total))?;
            let whole = libm::rint(total - prompt.dead_time().delay_samples());
            Ok::<_, AnalysisError>(Later {
                subject: self,
                prompt,
                whole,
                late: robot.delayed_by(total).ok(),
            })
        };
        let zero = delay_margin(&later, &mores, FINER).ok()?;
        zero.map(|(delay, theta)| AtAngle::new(delay, theta))
    }

    /// Its law and hand on another robot.
    fn on<'c>(&self, robot: &'c Robot) -> AdmittanceLoop<'c>
    where
        Self: 'c,
    {
        AdmittanceLoop {
            family: Family {
                robot,
                ..self.family
            },
            coefficients: self.coefficients,
        }
    }
}

/// A loop whose robot acts later. Whole samples turn the phase alone, so crossovers are those of the prompt one.
struct Later<'a, 'b> {
    subject: &'a AdmittanceLoop<'b>,
    prompt: Robot,
    whole: f64,
    late: Option<Robot>,
}

impl Late for Later<'_, '_> {
    fn crossovers(&self) -> Vec<(f64, f64)> {
        let prompt = self.subject.on(&self.prompt);
        let split = Split::hand(&prompt);
        let turned = |theta: f64| {
            let turn = (-split.terms(theta).gain()).arg() - self.whole * theta;
            (theta, turn - 2.0 * PI * libm::rint(turn / (2.0 * PI)))
        };
        split.crossovers().into_iter().map(turned).collect()
    }

    fn is_turned(&self) -> bool {
        let prompt = self.subject.on(&self.prompt);
        Split::hand(&prompt).terms(PI).gain().norm() >= 1.0
    }

    fn lost(&self) -> Result<Option<f64>, Unknown> {
        let verdict = self
            .subject
            .on(self.late.as_ref().ok_or(Unknown)?)
            .verdict();
        Ok((!verdict.stable).then_some(verdict.theta))
    }
}
