//! The characteristic function on the unit circle, with bounds over any interval.
//!
//! ```text
//! F(w)·D(w) = A·D + S·(αD + βN),   P = N/D,   S = w^(d+1)(n₁ + n₀w + …),   w = e^(−jθ)
//! ```

use crate::curve::{Bounds, Jet, Place, product};
use crate::operator::OperatorNode;
use crate::{LoopOperator, SampledPlant};
use core::f64::consts::PI;
use num_complex::Complex;

/// Plant (with its delay) and operator: the loop without α and β.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Characteristic<'a> {
    pub(crate) plant: SampledPlant,
    pub(crate) operator: &'a LoopOperator,
}

/// Everything known at one angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    pub(crate) place: Place,
    /// A.
    pub(crate) plant: Jet,
    /// S = w^(d+1) times the numerator of the plant.
    pub(crate) gain: Jet,
    pub(crate) operator: OperatorNode,
    /// A·D, S·D, S·N: G = terms · (1, α, β).
    pub(crate) terms: [Jet; 3],
    /// Rounding error of the first term is this many ε.
    pub(crate) rough: f64,
}

/// Bounds of the three terms over an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    pub(crate) travel: [f64; 3],
    pub(crate) bend: [f64; 3],
}

impl<'a> Characteristic<'a> {
    pub(crate) fn node(&self, theta: f64) -> Node {
        let place = Place::new(theta);
        let turn = place.w * Complex::new(0.0, 1.0); // dv/dθ = jw
        let own = self.plant.denominator_in_v();
        let (value, slope) = powers(own, place.v);
        let plant = Jet {
            value,
            rate: slope * turn,
        };
        let first = self.plant.path().whole_samples() + 1;
        let delays = place.w_to(first);
        let (shape, slope) = powers(self.plant.numerator_in_v(), place.v);
        let value = delays * shape;
        let gain = Jet {
            value,
            rate: value * Complex::new(0.0, -(first as f64)) + delays * turn * slope,
        };
        let operator = self.operator.node(&place);
        let (above, below) = (operator.numerator, operator.denominator);
        let terms = if self.operator.has_denominator() {
            [plant.times(below), gain.times(below), gain.times(above)]
        } else {
            [plant, gain, gain.times(above)]
        };
        let size = own.iter().enumerate().fold(0.0, |sum, (k, a)| {
            sum + (0..k).fold(a.abs(), |term, _| term * place.size_v)
        });
        Node {
            place,
            plant,
            gain,
            operator,
            terms,
            rough: size * below.value.norm(),
        }
    }

    pub(crate) fn plant_bounds(&self, a: &Node, b: &Node) -> Bounds {
        let width = b.place.theta - a.place.theta;
        // |A′| ≤ Σ k|a_k||v|^(k−1), |A″| ≤ that + Σ k(k − 1)|a_k||v|^(k−2), and |v| grows with θ.
        let (mut rate, mut curl) = (0.0, 0.0);
        for (k, a) in self.plant.denominator_in_v().iter().enumerate().skip(1) {
            let most = |power: usize| (0..power).fold(a.abs(), |term, _| term * b.place.size_v);
            rate += k as f64 * most(k - 1);
            if k > 1 {
                curl += (k * (k - 1)) as f64 * most(k - 2);
            }
        }
        Bounds::from_ends(&a.plant, &b.plant, width, rate, rate + curl)
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

    /// Of the three terms over an interval.
    pub(crate) fn bounds(&self, a: &Node, b: &Node) -> [Bounds; 3] {
        let plant = self.plant_bounds(a, b);
        let gain = self.gain_bounds(a, b);
        let [above, below] = self.operator_bounds(a, b);
        if self.operator.has_denominator() {
            [plant.times(below), gain.times(below), gain.times(above)]
        } else {
            [plant, gain, gain.times(above)]
        }
    }

    pub(crate) fn span(&self, a: &Node, b: &Node) -> Span {
        let terms = self.bounds(a, b);
        Span {
            travel: terms.map(|term| term.travel),
            bend: terms.map(|term| term.bend),
        }
    }

    /// Angles to begin with: fine towards rest, where everything slow happens.
    pub(crate) fn first_angles() -> impl Iterator<Item = f64> {
        let slow = (0..12).map(|k| libm::ldexp(PI / 64.0, k - 12));
        let fast = (1..=64).map(|k| PI * f64::from(k) / 64.0);
        core::iter::once(0.0).chain(slow).chain(fast)
    }
}

/// A polynomial and its derivative at v, the coefficient of v⁰ first.
fn powers(coefficients: &[f64], v: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
    let horner = |factor: fn(usize) -> f64, skip: usize| {
        let terms = coefficients.iter().enumerate().skip(skip).rev();
        terms.fold(Complex::new(0.0, 0.0), |sum, (k, c)| {
            sum * v + factor(k) * c
        })
    };
    (horner(|_| 1.0, 0), horner(|k| k as f64, 1))
}

impl Node {
    pub(crate) fn theta(&self) -> f64 {
        self.place.theta
    }

    /// G = A·D + S(αD + βN).
    pub(crate) fn value(&self, alpha: f64, beta: f64) -> Complex<f64> {
        let [one, stiff, fractional] = &self.terms;
        one.value + stiff.value * alpha + fractional.value * beta
    }

    pub(crate) fn rate(&self, alpha: f64, beta: f64) -> f64 {
        let [one, stiff, fractional] = &self.terms;
        if beta == 0.0 {
            return (one.rate + stiff.rate * alpha).norm();
        }
        let rate = (one.rate + stiff.rate * alpha + fractional.rate * beta).norm();
        if rate.is_nan() { f64::INFINITY } else { rate }
    }

    /// An estimate of the rounding error of the value.
    pub(crate) fn noise(&self, alpha: f64, beta: f64) -> f64 {
        let stiff = alpha * self.terms[1].value.norm();
        // A polynomial that cancels to nothing still has errors of its terms, about 1.
        let fractional = beta * (self.terms[2].value.norm() + self.gain.value.norm());
        8.0 * f64::EPSILON * (self.rough + stiff + fractional)
    }
}

impl Span {
    /// A bound of the length of G's path.
    pub(crate) fn path(&self, a: &Node, b: &Node, alpha: f64, beta: f64) -> f64 {
        let sum = |terms: &[f64; 3]| terms[0] + product(alpha, terms[1]) + product(beta, terms[2]);
        let width = b.theta() - a.theta();
        let ends = a.rate(alpha, beta) + b.rate(alpha, beta);
        let by_bend = 0.5 * width * (ends + 0.5 * width * sum(&self.bend));
        sum(&self.travel).min(by_bend)
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
            let characteristic = Characteristic {
                plant,
                operator: &operator,
            };
            for interval in [(0.0, 0.01), (0.1, 0.5), (1.0, 1.2), (2.5, PI)] {
                let name = format!("d + h = {delay}, τ = {lag}");
                assert_bounded(&characteristic, interval, &name);
            }
        }
    }

    fn assert_bounded(characteristic: &Characteristic, (low, high): (f64, f64), name: &str) {
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
                assert!(
                    bend <= bound.bend * (1.0 + 1e-3) + noise * bound.bend.max(1.0),
                    "{what}"
                );
                // The derivative is that of the value.
                let slope = (here[k].value - before[k].value) / h;
                assert!(
                    (slope - here[k].rate).norm() <= h * bound.bend + noise,
                    "{what}"
                );
            }
            last = here;
        }
        for k in 0..2 {
            assert!(
                travel[k] <= bounds[k].travel * (1.0 + 1e-9),
                "{k}: {travel:?}"
            );
        }
    }
}
