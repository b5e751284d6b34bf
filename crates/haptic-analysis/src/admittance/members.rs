//! Every member of a box of bodies, hands and worlds at once, proved.
//! ```text
//! F(θ) of a box is a zonotope: c + Σ ε_i·g_i, |ε_i| ≤ 1, c of the middle, g_i half the width of an interval times its term
//! 0 is outside ⇐ |Re(n̄c)| > Σ |Re(n̄g_i)| for one n, at right angles to some g_i, or along it
//! one member stable, 0 outside for every θ ⇒ all members are stable, as their poles move without a jump
//! ```
//! The second n is for generators that are parallel, as all of them are at θ = π. Between two angles the sum of the terms' ways is taken off, so no
//! member's border is narrow enough to be missed; an interval that is not proved is halved. Towards rest all terms lie in one half plane, body and
//! hand as v·(b + `b_h`) at a right angle from the springs: that is the proof there, below 1e-9 rad/sample by its limit alone.

use super::closed::{AdmittanceLoop, AdmittanceNumber};
use super::terms::{Family, Node, TERMS};
use crate::AnalysisError;
use crate::curve::angles_to_pi;
use certified_count::product;
use core::f64::consts::PI;
use fracdiff::parameter::{not_negative, range};
use num_complex::Complex;

/// Bodies, hands and worlds between two values of each number.
#[derive(Clone, Copy, Debug)]
pub struct AdmittanceBox<'a> {
    family: Family<'a>,
    low: [f64; TERMS],
    high: [f64; TERMS],
}

/// The proof of a box, or what stands against one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BoxVerdict {
    /// Every member is stable.
    Proved,
    /// The member with these values is not stable: b, m, hand's mass (with the tool's), damping and stiffness, K and B.
    Unstable([f64; TERMS]),
    /// The members that were tried are stable; at this angle, rad/sample, the proof ended.
    Unproved {
        /// The angle θ = ωT.
        theta: f64,
    },
}

/// The first terms are those of body and hand, but for its stiffness.
const MOVING: usize = 4;
/// Halvings of a way between two angles; intervals looked at, at most.
const HALVINGS: u32 = 50;
const LOOKS: usize = 100_000;
/// Rounding errors of a projection, as a share of its terms.
const ROUNDING: f64 = 32.0 * f64::EPSILON;
/// Largest values are found to this share of themselves.
const KNOWN: f64 = 1e-7;

impl<'a> AdmittanceBox<'a> {
    /// The box that holds one loop alone.
    #[must_use]
    pub fn around(subject: &AdmittanceLoop<'a>) -> Self {
        Self {
            family: subject.family,
            low: subject.coefficients,
            high: subject.coefficients,
        }
    }

    /// The box with all values of one number from `low` to `high`. A hand's mass is given without the tool's.
    ///
    /// # Errors
    /// A value that is negative or not finite, or `high` below `low`.
    pub fn with(
        mut self,
        number: AdmittanceNumber,
        [low, high]: [f64; 2],
    ) -> Result<Self, AnalysisError> {
        not_negative("least value of a range", low, "")?;
        range(
            "largest value of a range",
            high,
            high >= low,
            "not below the least",
            "",
        )?;
        let tool = if number == AdmittanceNumber::HandMass {
            self.family.robot.tool_mass_kg()
        } else {
            0.0
        };
        let (index, unit) = (number.index(), self.family.units()[number.index()]);
        self.low[index] = (low + tool) * unit;
        self.high[index] = (high + tool) * unit;
        Ok(self)
    }

    /// The verdict on all members. *Cost*: some thousand values of F, more where a member is near its border.
    #[must_use]
    pub fn verdict(&self) -> BoxVerdict {
        let is_stable = |member: &[f64; TERMS]| self.family.verdict(member).stable;
        let middle = self.middle();
        if !is_stable(&middle) {
            return BoxVerdict::Unstable(self.given(middle));
        }
        let Some(theta) = self.unproved() else {
            return BoxVerdict::Proved;
        };
        let unstable = self.corners().find(|member| !is_stable(member));
        unstable.map_or(BoxVerdict::Unproved { theta }, |member| {
            BoxVerdict::Unstable(self.given(member))
        })
    }

    /// A member in the units that people give.
    fn given(&self, mut member: [f64; TERMS]) -> [f64; TERMS] {
        for (value, unit) in member.iter_mut().zip(self.family.units()) {
            *value /= unit;
        }
        member
    }

    /// The largest value up to `most` of one number such that the box from its least value to there is proved, to 1e-7 of itself; `None` if
    /// even the least is not.
    ///
    /// # Errors
    /// `most` below the least value.
    pub fn largest(
        &self,
        number: AdmittanceNumber,
        most: f64,
    ) -> Result<Option<f64>, AnalysisError> {
        let unit = self.family.units()[number.index()];
        let least = self.low[number.index()] / unit;
        range(
            "largest value of a range",
            most,
            most >= least,
            "not below the least",
            "",
        )?;
        let holds = |high: f64| {
            let mut grown = *self;
            grown.high[number.index()] = high * unit;
            grown.is_proved()
        };
        if holds(most) {
            return Ok(Some(most));
        }
        if !holds(least) {
            return Ok(None);
        }
        let (mut low, mut high) = (least, most);
        // From below, where a proof is cheap.
        while high - low > KNOWN * high {
            let middle = if low > 0.0 {
                libm::sqrt(low * high)
            } else {
                high / 16.0
            };
            if holds(middle) {
                low = middle;
            } else {
                high = middle;
            }
            if high < 1e-12 * most {
                break;
            }
        }
        Ok(Some(low))
    }

    /// The least factor on the body, m and b together, from `low` to `high`, with which the box is proved: the first of 80 in equal steps of their
    /// logarithm, and then to 1e-4 of itself from the one before. A heavier body may not be proved again: a spring that acts late drives a mass.
    #[must_use]
    pub fn least_body(&self, [low, high]: [f64; 2]) -> Option<f64> {
        const STEPS: u32 = 80;
        let holds = |factor: &f64| {
            let mut scaled = *self;
            for index in 0..2 {
                scaled.low[index] *= factor;
                scaled.high[index] *= factor;
            }
            scaled.is_proved()
        };
        let ratio = libm::pow(high / low, 1.0 / f64::from(STEPS));
        let factors = (0..=STEPS).map(|step| low * libm::pow(ratio, f64::from(step)));
        let mut above = factors.into_iter().find(holds)?;
        let mut below = (above / ratio).max(low);
        while above - below > 1e-4 * above {
            let middle = libm::sqrt(below * above);
            *(if holds(&middle) {
                &mut above
            } else {
                &mut below
            }) = middle;
        }
        Some(above)
    }

    /// True if every member is proved to be stable.
    #[must_use]
    pub fn is_proved(&self) -> bool {
        self.family.verdict(&self.middle()).stable && self.unproved().is_none()
    }

    fn middle(&self) -> [f64; TERMS] {
        core::array::from_fn(|i| 0.5 * (self.low[i] + self.high[i]))
    }

    fn corners(&self) -> impl Iterator<Item = [f64; TERMS]> {
        let wide = |i: &usize| self.high[*i] > self.low[*i];
        let wide: Vec<usize> = (0..TERMS).filter(wide).collect();
        (0..1_usize << wide.len()).map(move |which| {
            let mut corner = self.low;
            for (bit, &index) in wide.iter().enumerate() {
                if which >> bit & 1 == 1 {
                    corner[index] = self.high[index];
                }
            }
            corner
        })
    }

    /// An angle at which the proof ended; `None` if 0 is nowhere.
    fn unproved(&self) -> Option<f64> {
        // At rest F is its springs: above 0, or v·(b + b_h), or m·v^(1+α): all less than half a turn from one another, but a free mass.
        let (springs, damping) = self.family.at_rest(&self.low);
        let is_mass = self.family.body.operator.order().get() >= 1.0;
        if springs == 0.0 && damping <= 0.0 && is_mass {
            return Some(0.0);
        }
        let nodes: Vec<Node> = angles_to_pi()
            .map(|theta| self.family.node(theta))
            .collect();
        let mut todo: Vec<(Node, Node, u32)> =
            nodes.windows(2).map(|pair| (pair[0], pair[1], 0)).collect();
        for _ in 0..LOOKS {
            let (a, b, depth) = todo.pop()?;
            let theta = 0.5 * (a.place.theta + b.place.theta);
            let middle = self.family.node(theta);
            if self.is_one_sided(&a, &middle, &b) || self.is_clear(&a, &middle, &b) {
                continue;
            }
            if depth == HALVINGS || self.holds_zero(&middle) {
                return Some(theta);
            }
            todo.push((a, middle, depth + 1));
            todo.push((middle, b, depth + 1));
        }
        todo.last().map(|(a, ..)| a.place.theta)
    }

    /// From a to b all members lie in one half plane: body and hand, which are never 0 there, and the springs and the dissipation, whose coefficients
    /// only turn from their term's angle to nothing. Towards rest each term falls as a power of its own, and this alone is a proof with few steps.
    fn is_one_sided(&self, a: &Node, middle: &Node, b: &Node) -> bool {
        let ways = [self.family.ways(a, middle), self.family.ways(middle, b)];
        // A term in the middle of the way, its error over the way, and its coefficient's ends.
        let term = |index: usize| {
            let error = ways[0].travel[index].max(ways[1].travel[index])
                + 8.0 * f64::EPSILON * middle.terms.rough[index];
            let value = middle.terms.jets[index].value;
            (value, error, self.low[index], self.high[index])
        };
        let mut held = Complex::new(0.0, 0.0);
        let mut error = 0.0;
        for (value, moved, low, high) in (0..MOVING).map(term) {
            held += value * (0.5 * (low + high));
            error += product(high, moved);
        }
        let along = held.conj() / held.norm();
        let (mut least, mut beside) = (held.norm() - error, error);
        for (value, _, low, high) in (0..MOVING).map(term) {
            let turned = along * value * (0.5 * (high - low));
            least -= turned.re.abs();
            beside += turned.im.abs();
        }
        if least <= 0.0 || least.is_nan() {
            return false;
        }
        let spread = libm::atan2(beside, least);
        let (mut first, mut last) = (held.arg() - spread, held.arg() + spread);
        let others = (MOVING..TERMS).map(term).filter(|term| term.3 > 0.0);
        for (value, error, ..) in others {
            // Not a number from 1 on.
            let spread = libm::asin(error / value.norm());
            if spread.is_nan() {
                return false;
            }
            first = first.min(value.arg() - spread);
            last = last.max(value.arg() + spread);
        }
        last - first < PI * (1.0 - 1e-9)
    }

    /// Room between 0 and the zonotope, and the direction in which it is largest.
    fn room(&self, node: &Node) -> f64 {
        let middle = self.middle();
        let value = node.terms.value(&middle);
        let half: [f64; TERMS] = core::array::from_fn(|i| 0.5 * (self.high[i] - self.low[i]));
        let generators: [_; TERMS] = core::array::from_fn(|i| node.terms.jets[i].value * half[i]);
        let noise = ROUNDING * node.terms.size(&self.high) + node.terms.noise(&self.high);
        let along = |n: Complex<f64>| {
            let n = n.conj() / n.norm();
            let widths = generators.iter().map(|g| (n * g).re.abs());
            (n * value).re.abs() - widths.sum::<f64>()
        };
        let turn = Complex::new(0.0, 1.0);
        let directions = generators.iter().filter(|g| g.norm() > 0.0);
        let rooms = directions.flat_map(|g| [along(*g * turn), along(*g)]);
        // A member alone is its distance from 0.
        rooms
            .chain([along(value)])
            .fold(f64::NEG_INFINITY, f64::max)
            - noise
    }

    /// 0 is in the zonotope, or too near to tell.
    fn holds_zero(&self, node: &Node) -> bool {
        let room = self.room(node);
        room.is_nan() || room <= 0.0
    }

    /// 0 is in no zonotope from a to b.
    fn is_clear(&self, a: &Node, middle: &Node, b: &Node) -> bool {
        let way = |from: &Node, to: &Node| {
            let width = to.place.theta - from.place.theta;
            let ways = self.family.ways(from, to);
            // The middle moves by its own way, each generator by its own.
            let mut moved = ways.path([&from.terms, &to.terms], &self.middle(), width);
            for index in 0..TERMS {
                let half = 0.5 * (self.high[index] - self.low[index]);
                if half > 0.0 {
                    let mut alone = [0.0; TERMS];
                    alone[index] = half;
                    moved += ways.path([&from.terms, &to.terms], &alone, width);
                }
            }
            moved
        };
        let moved = way(a, middle).max(way(middle, b));
        self.room(middle) > moved
    }
}
