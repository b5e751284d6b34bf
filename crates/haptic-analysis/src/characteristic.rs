//! The characteristic function on the unit circle, with bounds over any interval.
//! ```text
//! F(w)·D(w) = A·D + S·(αD + βN),   P = N/D,   S = w^(d+1)(n₁ + n₀w + …),   w = e^(−jθ)
//! ```
//! With a simulated object [`Behind`] a coupler α(1 − w) + βP, as [`CoupledLoop`](crate::CoupledLoop) says,
//! ```text
//! F·D = A·e·D + (A·u + S·e)·(αvD + βN),   v = 1 − w,   e/u the object
//! ```

use crate::affine::{Terms, Ways};
use crate::curve::{bounds_in_v, jet_in_v, powers_in_v, size_in_v, w_to};
use crate::operator::OperatorNode;
use crate::{LoopOperator, SampledPlant};
use certified_count::{Bounds, Jet, Place};
use core::f64::consts::PI;
use num_complex::Complex;

/// Plant (with its delay) and operator: the loop without α and β.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Characteristic<'a> {
    pub(crate) plant: SampledPlant,
    pub(crate) operator: &'a LoopOperator,
    /// The object behind a coupler; `None` for a wall.
    pub(crate) behind: Option<Behind>,
}

/// Everything known at one angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    pub(crate) place: Place,
    /// A, the denominator of the plant.
    pub(crate) plant: Jet,
    /// S = w^(d+1) times the numerator of the plant.
    pub(crate) gain: Jet,
    pub(crate) operator: OperatorNode,
    /// A·D, S·D, S·N: G = terms · (1, α, β).
    pub(crate) terms: Terms<3>,
}

impl<'a> Characteristic<'a> {
    /// Characteristic of a wall, without an object behind it.
    pub(crate) const fn new(plant: SampledPlant, operator: &'a LoopOperator) -> Self {
        Self {
            plant,
            operator,
            behind: None,
        }
    }

    pub(crate) fn node(&self, theta: f64) -> Node {
        let place = Place::new(theta);
        let turn = place.w * Complex::new(0.0, 1.0); // dv/dθ = jw
        let denominator = self.plant.denominator_in_v();
        let plant = jet_in_v(denominator, &place);
        let first = self.plant.path().whole_samples() + 1;
        let delays = w_to(&place, first);
        let (shape, slope) = powers_in_v(self.plant.numerator_in_v(), place.v);
        let value = delays * shape;
        let gain = Jet::new(
            value,
            value * Complex::new(0.0, -(first as f64)) + delays * turn * slope,
        );
        let operator = self.operator.node(&place);
        let size = size_in_v(denominator, place.size_v);
        let (jets, rough) = self.terms(&place, plant, size, gain, &operator);
        Node {
            place,
            plant,
            gain,
            operator,
            terms: Terms { jets, rough },
        }
    }

    /// The three terms, and how many ε each may be off.
    fn terms(
        &self,
        place: &Place,
        plant: Jet,
        size: f64,
        gain: Jet,
        operator: &OperatorNode,
    ) -> ([Jet; 3], [f64; 3]) {
        let (above, below) = (operator.numerator, operator.denominator);
        let divided = |jet: Jet| {
            if self.operator.has_denominator() {
                jet.times(below)
            } else {
                jet
            }
        };
        let denominator = below.value.norm();
        if let Some(behind) = &self.behind {
            let (e, u) = (jet_in_v(&behind.e, place), jet_in_v(&behind.u, place));
            let sizes = [&behind.e[..], &behind.u[..]].map(|c| size_in_v(c, place.size_v));
            let seen = plant.times(u).plus(gain.times(e));
            let size_seen = size * sizes[1] + gain.value.norm() * sizes[0];
            let v = jet_in_v(&[0.0, 1.0], place);
            let terms = [
                divided(plant.times(e)),
                divided(seen.times(v)),
                seen.times(above),
            ];
            let rough = [
                size * sizes[0] * denominator,
                size_seen * place.size_v * denominator,
                size_seen * (above.value.norm() + 1.0),
            ];
            return (terms, rough);
        }
        let terms = [divided(plant), divided(gain), gain.times(above)];
        // A polynomial that cancels to nothing still has errors of its terms, about 1.
        let rough = [
            size * denominator,
            terms[1].value.norm(),
            terms[2].value.norm() + gain.value.norm(),
        ];
        (terms, rough)
    }

    pub(crate) fn plant_bounds(&self, a: &Node, b: &Node) -> Bounds {
        let coefficients = self.plant.denominator_in_v();
        bounds_in_v(coefficients, &a.place, &b.place, &a.plant, &b.plant)
    }

    pub(crate) fn gain_bounds(&self, a: &Node, b: &Node) -> Bounds {
        let width = b.place.theta - a.place.theta;
        let first = self.plant.path().whole_samples() + 1;
        let (mut rate, mut bend) = (0.0, 0.0);
        for (j, n) in self.plant.numerator().iter().enumerate() {
            let power = (first + j) as f64;
            rate += power * n.abs();
            bend += power * power * n.abs();
        }
        Bounds::from_ends(&a.gain, &b.gain, width, rate, bend)
    }

    pub(crate) fn operator_bounds(&self, a: &Node, b: &Node) -> [Bounds; 2] {
        self.operator
            .bounds((&a.place, &a.operator), (&b.place, &b.operator))
    }

    /// Bounds of the three terms over an interval.
    pub(crate) fn bounds(&self, a: &Node, b: &Node) -> [Bounds; 3] {
        let plant = self.plant_bounds(a, b);
        let gain = self.gain_bounds(a, b);
        let [above, below] = self.operator_bounds(a, b);
        let divided = |bounds: Bounds| {
            if self.operator.has_denominator() {
                bounds.times(below)
            } else {
                bounds
            }
        };
        let Some(behind) = &self.behind else {
            return [divided(plant), divided(gain), gain.times(above)];
        };
        let (a, b) = (&a.place, &b.place);
        let valued = |coefficients: &[f64]| {
            let [jet_a, jet_b] = [a, b].map(|place| jet_in_v(coefficients, place));
            bounds_in_v(coefficients, a, b, &jet_a, &jet_b)
        };
        let (e, u, v) = (valued(&behind.e), valued(&behind.u), valued(&[0.0, 1.0]));
        let seen = plant.times(u).plus(gain.times(e));
        [
            divided(plant.times(e)),
            divided(seen.times(v)),
            seen.times(above),
        ]
    }

    pub(crate) fn span(&self, a: &Node, b: &Node) -> Ways<3> {
        Ways::new(&self.bounds(a, b))
    }

    /// Angles to begin with: fine towards rest, where everything slow happens.
    pub(crate) fn first_angles() -> impl Iterator<Item = f64> {
        let slow = (0..12).map(|k| libm::ldexp(PI / 64.0, k - 12));
        let fast = (1..=64).map(|k| PI * f64::from(k) / 64.0);
        core::iter::once(0.0).chain(slow).chain(fast)
    }
}

impl Node {
    pub(crate) fn theta(&self) -> f64 {
        self.place.theta
    }

    /// G = A·D + S(αD + βN).
    pub(crate) fn value(&self, [alpha, beta]: [f64; 2]) -> Complex<f64> {
        self.terms.value(&[1.0, alpha, beta])
    }

    /// An estimate of the rounding error of the value.
    pub(crate) fn noise(&self, [alpha, beta]: [f64; 2]) -> f64 {
        self.terms.noise(&[1.0, alpha, beta])
    }
}

/// The object without units, e/u with e and u in powers of v = 1 − w, divided by the largest that e can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Behind {
    pub(crate) e: [f64; 3],
    pub(crate) u: [f64; 2],
}

impl Behind {
    /// Object behind a coupler from its shares of mass, damping and stiffness: `m_o/m`, `b_o·T/m`, `k_o·T²/m`.
    pub(crate) fn new([mass, damping, stiffness]: [f64; 3]) -> Self {
        let most = 8.0 * mass + 2.0 * damping + 2.0 * stiffness;
        // With mass 2ρv² + δv(2 − v) + γ(2 − v)²/2 over 2 − v; without one both have the factor 2 − v.
        let (e, u) = if mass > 0.0 {
            let e = [
                2.0 * stiffness,
                2.0 * damping - 2.0 * stiffness,
                2.0 * mass - damping + 0.5 * stiffness,
            ];
            (e, [2.0, -1.0])
        } else {
            ([stiffness, damping - 0.5 * stiffness, 0.0], [1.0, 0.0])
        };
        Self {
            e: e.map(|c| c / most),
            u: u.map(|c| c / most),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ForcePath;
    use fracdiff::{Order, Scheme, Seconds};

    #[test]
    fn no_sample_of_a_plant_inside_an_interval_exceeds_its_bounds() {
        let order = Order::new(0.5).expect("in range");
        let operator =
            LoopOperator::new(Scheme::Exact, order, Seconds(1e-3), 1e3).expect("an operator");
        for (delay, lag) in [
            (0.0, 0.0),
            (0.4, 0.0),
            (1.7, 0.3),
            (2.999, 5.0),
            (9.5, 1e-3),
        ] {
            let path = ForcePath::new(delay, lag).expect("in range");
            let plant = SampledPlant::behind(0.2, 0.5, path).expect("in range");
            let characteristic = Characteristic::new(plant, &operator);
            for interval in [[0.0, 0.01], [0.1, 0.5], [1.0, 1.2], [2.5, PI]] {
                let name = format!("d + h = {delay}, τ = {lag}");
                assert_bounded(&characteristic, interval, &name);
            }
        }
    }

    fn assert_bounded(characteristic: &Characteristic, [low, high]: [f64; 2], name: &str) {
        let (a, b) = (characteristic.node(low), characteristic.node(high));
        let bounds = [
            characteristic.plant_bounds(&a, &b),
            characteristic.gain_bounds(&a, &b),
        ];
        let jets = |theta| {
            let node = characteristic.node(theta);
            [node.plant, node.gain]
        };
        let mut travel = [0.0; 2];
        let mut last = jets(low);
        for i in 1..=200_u32 {
            let theta = low + (high - low) * f64::from(i) / 200.0;
            let (here, h) = (jets(theta), 1e-5 * theta);
            // Rounding errors of the values, of 1e-15 each, over h.
            let noise = 1e-6 + 2e-15 / h;
            let before = jets(theta - h);
            for k in 0..2 {
                let what = format!("{name}, term {k} at {theta}");
                let bound = &bounds[k];
                travel[k] += (here[k].value - last[k].value).norm();
                assert!(here[k].value.norm() <= bound.size * (1.0 + 1e-9), "{what}");
                assert!(here[k].rate.norm() <= bound.rate * (1.0 + 1e-9), "{what}");
                let bend = (here[k].rate - before[k].rate).norm() / h;
                let most = bound.bend * (1.0 + 1e-3) + noise * bound.bend.max(1.0);
                assert!(bend <= most, "{what}");
                // The derivative is that of the value.
                let slope = (here[k].value - before[k].value) / h;
                let off = (slope - here[k].rate).norm();
                assert!(off <= h * bound.bend + noise, "{what}");
            }
            last = here;
        }
        for (travel, bounds) in travel.iter().zip(&bounds) {
            assert!(*travel <= bounds.travel * (1.0 + 1e-9), "{travel}");
        }
    }
}
