//! The characteristic function of an admittance loop, affine in body, hand and world, with its bounds.
//! ```text
//! F = v·[Ã·(b·P_d + m·T^(−α)·P_n)·Q_d + w^(d+1)·(m_h·N_m + b_h·N_b)·P_d·Q_d] + w^(d+1)·k_h·N_k·P_d·Q_d
//!     + T·w^(1+e)·Ã·(K·Q_d + B·T^(−μ)·Q_n)·P_d,        v = 1 − w
//! ```

use super::robot::{Numerator, Robot};
use crate::LoopOperator;
use crate::affine::{Terms, Ways};
use crate::characteristic::Characteristic;
use crate::curve::{bounds_in_v, jet_in_v, powers_in_v, size_in_v, w_to};
use crate::operator::OperatorNode;
use certified_count::{Bounds, Jet, Place};
use num_complex::Complex;

/// The virtual body M(D) = m·D^α + b, from a velocity to a force.
#[derive(Clone, Copy, Debug)]
pub struct AdmittanceBody<'a> {
    /// m, N·s^(1+α)/m, at least 0: a mass in kg at α = 1, a damping in N·s/m at α = 0.
    pub inertance_n_s_alpha_per_m: f64,
    /// b, N·s/m, at least 0.
    pub damping_n_s_per_m: f64,
    /// D^α of the velocity, by the scheme that runs.
    pub operator: &'a LoopOperator,
}

/// The virtual world K + B·D^μ at the virtual position.
#[derive(Clone, Copy, Debug)]
pub struct AdmittanceWorld<'a> {
    /// K, N/m, at least 0.
    pub stiffness_n_per_m: f64,
    /// B, N·s^μ/m, at least 0.
    pub dissipation_n_s_mu_per_m: f64,
    /// D^μ of the position.
    pub operator: &'a LoopOperator,
    /// Whole samples between the virtual position and the force of the world, up to 10 000.
    pub delay_samples: usize,
}

/// Terms of F: b, m, `m_h`, `b_h`, `k_h`, K, B.
pub(super) const TERMS: usize = 7;

/// Robot, body and world without their coefficients.
#[derive(Clone, Copy, Debug)]
pub(super) struct Family<'a> {
    pub(super) robot: &'a Robot,
    pub(super) body: AdmittanceBody<'a>,
    pub(super) world: Option<AdmittanceWorld<'a>>,
}

/// Everything known at one angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) place: Place,
    v: Jet,
    /// A/(1 − w).
    pub(super) robot: Jet,
    /// The three numerators behind their delay.
    pub(super) forces: [Jet; 3],
    /// Position over velocity times v.
    moved: Jet,
    pub(super) body: OperatorNode,
    pub(super) world: OperatorNode,
    pub(super) terms: Terms<TERMS>,
}

/// w^d.
fn delay(place: &Place, samples: usize) -> Jet {
    let value = w_to(place, samples);
    Jet::new(value, value * Complex::new(0.0, -(samples as f64)))
}

impl Numerator {
    fn jet(&self, place: &Place, first: usize) -> Jet {
        let (value, slope) = powers_in_v(&self.in_v, place.v);
        let turn = place.w * Complex::new(0.0, 1.0);
        Jet::new(value, slope * turn).times(delay(place, first))
    }

    fn bounds(&self, a: &Jet, b: &Jet, width: f64, first: usize) -> Bounds {
        let (mut rate, mut bend) = (0.0, 0.0);
        for (j, n) in self.in_w.iter().enumerate() {
            let power = (first + j) as f64;
            rate += power * n.abs();
            bend += power * power * n.abs();
        }
        Bounds::from_ends(a, b, width, rate, bend)
    }

    fn size(&self) -> f64 {
        self.in_w.iter().map(|n| n.abs()).sum()
    }
}

impl Family<'_> {
    /// Angles to begin with: fine towards rest, where everything slow happens.
    pub(super) fn first_angles() -> impl Iterator<Item = f64> {
        Characteristic::first_angles()
    }

    /// The power of w before the force of a hand.
    fn first(&self) -> usize {
        self.robot.dead_time().whole_samples() + 1
    }

    /// The power of w before the force of the world.
    fn first_of_world(&self) -> usize {
        1 + self.world.map_or(0, |world| world.delay_samples)
    }

    pub(super) fn node(&self, theta: f64) -> Node {
        let place = Place::new(theta);
        let robot = jet_in_v(&self.robot.denominator_in_v, &place);
        let forces = self
            .robot
            .numerators
            .each_ref()
            .map(|n| n.jet(&place, self.first()));
        let body = self.body.operator.node(&place);
        // Without a world its two terms are those of a spring.
        let world = self
            .world
            .map_or(OperatorNode::ONE, |world| world.operator.node(&place));
        let moved = delay(&place, self.first_of_world());
        let t = self.robot.sample_time_s();
        let moved = Jet::new(moved.value * t, moved.rate * t);
        let v = jet_in_v(&[0.0, 1.0], &place);
        let (p, q) = (body.denominator, world.denominator);
        let jets = products(
            [v, robot, p, q, body.numerator, world.numerator, moved],
            forces,
        );
        let size = size_in_v(&self.robot.denominator_in_v, place.size_v);
        let [p, q] = [p, q].map(|jet| jet.value.norm());
        let by_robot = place.size_v * size;
        let [of_mass, of_damping, of_stiffness] =
            self.robot.numerators.each_ref().map(Numerator::size);
        let rough = [
            by_robot * p * q,
            // A polynomial that cancels to nothing still has errors of its terms, about 1.
            by_robot * (body.numerator.value.norm() + 1.0) * q,
            place.size_v * of_mass * p * q,
            place.size_v * of_damping * p * q,
            of_stiffness * p * q,
            t * size * p * q,
            t * size * p * (world.numerator.value.norm() + 1.0),
        ];
        Node {
            place,
            v,
            robot,
            forces,
            moved,
            body,
            world,
            terms: Terms { jets, rough },
        }
    }

    pub(super) fn bounds(&self, a: &Node, b: &Node) -> [Bounds; TERMS] {
        let width = b.place.theta - a.place.theta;
        let in_v = |list: &[f64], of: fn(&Node) -> &Jet| {
            bounds_in_v(list, &a.place, &b.place, of(a), of(b))
        };
        let v = in_v(&[0.0, 1.0], |node| &node.v);
        let robot = in_v(&self.robot.denominator_in_v, |node| &node.robot);
        let mut forces = [Bounds::ONE; 3];
        for (i, bounds) in forces.iter_mut().enumerate() {
            let numerator = &self.robot.numerators[i];
            *bounds = numerator.bounds(&a.forces[i], &b.forces[i], width, self.first());
        }
        let [body, p] = (self.body.operator).bounds((&a.place, &a.body), (&b.place, &b.body));
        let [world, q] = self.world.map_or([Bounds::ONE; 2], |world| {
            (world.operator).bounds((&a.place, &a.world), (&b.place, &b.world))
        });
        let turns = self.first_of_world() as f64;
        let t = self.robot.sample_time_s();
        let moved = Bounds::from_ends(&a.moved, &b.moved, width, t * turns, t * turns * turns);
        products([v, robot, p, q, body, world, moved], forces)
    }

    pub(super) fn ways(&self, a: &Node, b: &Node) -> Ways<TERMS> {
        Ways::new(&self.bounds(a, b))
    }

    /// The terms at rest, over one another's unit: F(1) for these coefficients, and the damping that is left where it is 0.
    pub(super) fn at_rest(&self, coefficients: &[f64; TERMS]) -> (f64, f64) {
        let node = self.node(0.0);
        let springs = node.terms.value(coefficients).norm();
        let noise = node.terms.noise(coefficients);
        let damping = coefficients[0] + coefficients[3];
        (if springs <= noise { 0.0 } else { springs }, damping)
    }
}

/// Functions of θ that can be multiplied: values with derivatives, and their bounds.
trait Factor: Copy {
    fn by(self, other: Self) -> Self;
}

impl Factor for Jet {
    fn by(self, other: Self) -> Self {
        self.times(other)
    }
}

impl Factor for Bounds {
    fn by(self, other: Self) -> Self {
        self.times(other)
    }
}

/// The seven terms from v, Ã, `P_d`, `Q_d`, `P_n`, `Q_n`, T·w^(1+e), and the three numerators.
fn products<F: Factor>([v, robot, p, q, body, world, moved]: [F; 7], forces: [F; 3]) -> [F; TERMS] {
    let both = p.by(q);
    let free = v.by(robot);
    let [of_mass, of_damping, of_stiffness] = forces.map(|force| force.by(both));
    let placed = moved.by(robot).by(p);
    [
        free.by(both),
        free.by(body).by(q),
        v.by(of_mass),
        v.by(of_damping),
        of_stiffness,
        placed.by(q),
        placed.by(world),
    ]
}
