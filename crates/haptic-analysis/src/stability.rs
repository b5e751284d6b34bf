//! Stability of the sampled loop by encirclement, and its poles.

use crate::affine::Ways;
use crate::characteristic::{Characteristic, Node};
use crate::{AnalysisError, LoopOperator, SampledPlant, SampledWall};
use certified_count::{Curve, NodeValue, StabilityVerdict};
use core::f64::consts::PI;
use fracdiff::Order;
use fracdiff::parameter::{positive, range};
use fracdiff::product;
use num_complex::Complex;

/// Device and wall without units.
/// ```text
/// α = K·T²/m,   β = B·T^(2−μ)/m,   δ = b·T/m,   γ = k·T²/m
/// ```
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, eq. 3.9.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nondimensional {
    /// α, 0 to 1e12.
    pub alpha: f64,
    /// β, 0 to 1e12.
    pub beta: f64,
    /// δ, 0 to 1e6.
    pub delta: f64,
    /// γ, 0 to 1e12.
    pub gamma: f64,
}

impl Nondimensional {
    /// Largest α and β that are accepted.
    pub const WALL_MAX: f64 = 1e12;

    /// Itself, if all four are within their ranges.
    ///
    /// # Errors
    /// The first that is not.
    pub fn checked(self) -> Result<Self, AnalysisError> {
        let (wall, allowed) = (Self::WALL_MAX, "from 0 to 1e12");
        let (damping, hand) = (SampledPlant::DELTA_MAX, SampledPlant::GAMMA_MAX);
        for (what, value, most, allowed) in [
            ("alpha", self.alpha, wall, allowed),
            ("beta", self.beta, wall, allowed),
            ("delta", self.delta, damping, "from 0 to 1e6"),
            ("gamma", self.gamma, hand, allowed),
        ] {
            range(what, value, (0.0..=most).contains(&value), allowed, "")?;
        }
        Ok(self)
    }

    /// The wall that has these α and β on a device of this mass.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn with_units(
        self,
        mass_kg: f64,
        sample_time_s: f64,
        order: Order,
    ) -> Result<SampledWall, AnalysisError> {
        self.checked()?;
        let m = positive("mass", mass_kg, "kg")?;
        let t = positive("sample time", sample_time_s, "s")?;
        Ok(SampledWall {
            stiffness_n_per_m: self.alpha * m / (t * t),
            dissipation_n_s_mu_per_m: self.beta * m / libm::pow(t, 2.0 - order.get()),
            order,
            sample_time_s: t,
        })
    }
}

/// A loop closed over a virtual environment, without units.
/// ```text
/// F(w) = A(w) + w^(d+1)·N(w)·(α + βP(w)),   stable ⇔ F has no zero in |w| ≤ 1,  w = z^(−1)
/// ```
/// - α, β: stiffness and dissipation, at least 0; δ, γ: device and hand, see [`SampledPlant`].
/// - d: whole samples of delay between measuring and acting, beside the one of the hold; up to 10 000. A delay that is no whole number and a current lag belong to the plant:
///   [`with_plant`](Self::with_plant).
/// ```
/// use fracdiff::{Order, Scheme, Seconds};
/// use haptic_analysis::{LoopOperator, Nondimensional, SampledLoop};
///
/// let damper = LoopOperator::new(Scheme::Exact, Order::new(1.0)?, Seconds(1e-3), 1e3)?;
/// let wall = |alpha| Nondimensional { alpha, beta: 1.0, delta: 0.0, gamma: 0.0 };
/// // Without damping of the device: α < 2β(2 − β)/(2 + β) = 2/3 at β = 1.
/// assert!(SampledLoop::new(wall(0.66), &damper, 0)?.verdict().stable);
/// assert!(!SampledLoop::new(wall(0.67), &damper, 0)?.verdict().stable);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, §4.2; the argument principle in place
/// of Routh and Hurwitz, so that irrational operators can be judged too.
#[derive(Clone, Copy, Debug)]
pub struct SampledLoop<'a> {
    pub(crate) characteristic: Characteristic<'a>,
    pub(crate) alpha: f64,
    pub(crate) beta: f64,
    /// Judged beside the zeros of F at w = 1.
    pub(crate) beside_rest: bool,
}

/// Largest degree for which a verdict takes the trouble to find all poles.
const EIGENVALUE_DEGREE: usize = 64;
/// |F| over the sizes of its terms, and over n₁ + n₀, at which a loop is on the boundary.
pub(crate) const BOUNDARY: f64 = 1e-9;

/// Replaces by 0 a stiffness or dissipation too small for its products to be normal numbers.
pub(crate) fn flushed(value: f64) -> f64 {
    const LEAST: f64 = 1e-200;
    if value < LEAST { 0.0 } else { value }
}

impl<'a> SampledLoop<'a> {
    /// Checks all parameters. An α or β below 1e-200 counts as 0.
    ///
    /// # Errors
    /// α, β, δ or γ negative or not finite; δ or γ too large for a [`SampledPlant`]; α or β above 1e12; d above the largest delay.
    pub fn new(
        parameters: Nondimensional,
        operator: &'a LoopOperator,
        delay: usize,
    ) -> Result<Self, AnalysisError> {
        let Nondimensional {
            alpha,
            beta,
            delta,
            gamma,
        } = parameters.checked()?;
        Self::with_plant(
            SampledPlant::new(delta, gamma)?.later(delay)?,
            alpha,
            beta,
            operator,
        )
    }

    /// Closes the loop on any plant, with the plant's own delay and lag.
    ///
    /// # Errors
    /// α or β negative, not finite, or above 1e12.
    pub fn with_plant(
        plant: SampledPlant,
        alpha: f64,
        beta: f64,
        operator: &'a LoopOperator,
    ) -> Result<Self, AnalysisError> {
        for (what, value) in [("alpha", alpha), ("beta", beta)] {
            let kept = (0.0..=Nondimensional::WALL_MAX).contains(&value);
            range(what, value, kept, "from 0 to 1e12", "")?;
        }
        Ok(Self {
            characteristic: Characteristic::new(plant, operator),
            alpha: flushed(alpha),
            beta: flushed(beta),
            beside_rest: false,
        })
    }

    /// The plant with its delay, as the loop samples it.
    #[must_use]
    pub fn plant(&self) -> &SampledPlant {
        &self.characteristic.plant
    }

    /// F at w = e^(−jθ), θ in rad/sample.
    #[must_use]
    pub fn characteristic(&self, theta: f64) -> Complex<f64> {
        let node = self.characteristic.node(theta);
        node.value([self.alpha, self.beta]) / node.operator.denominator.value
    }

    /// The certified verdict, by encirclement. Cost: about 100 responses of the operator, and some ten
    /// more for each decade that F comes closer to zero.
    ///
    /// - *On the boundary*: |F| ≤ 1e-9 of the sizes of its terms was met, and of n₁ + n₀: changing α, β and the plant by that share could
    ///   take the loop there.
    /// - *Distance*: |F|/(n₁ + n₀). It would take about this change of α, as a complex number, to reach the boundary. The margins proper are
    ///   in [`WallMargins`](crate::WallMargins). Of a loop that [drifts](Self::beside_rest) over |v|^p too, as F falls towards rest.
    #[must_use]
    pub fn verdict(&self) -> StabilityVerdict {
        let circle = self.characteristic.circle();
        circle.count([self.alpha, self.beta], BOUNDARY, self.beside_rest)
    }

    /// True if the verdict is stable; it costs as much as the verdict.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.verdict().stable
    }

    /// Nothing holds the device at rest: no spring, however weak, so α = γ = 0, and βP(1) = 0 to what the boundary is known. F has a
    /// zero at w = 1 then, the pole of a position that stays where it is left, as behind a tissue that only dissipates.
    #[must_use]
    pub fn drifts(&self) -> bool {
        let scale = self.characteristic.plant.numerator_sum();
        let springs = self.characteristic.node(0.0).value([self.alpha, 0.0]);
        springs.norm() == 0.0 && self.characteristic(0.0).norm() <= BOUNDARY * scale
    }

    /// Excludes the pole at rest from the verdict if the loop [drifts](Self::drifts); the drift is not an instability.
    #[must_use]
    pub fn beside_rest(mut self) -> Self {
        self.beside_rest = self.drifts();
        self
    }

    /// F·D in powers of w, of w⁰ first, where P = N/D is polynomial or rational; its zeros are those of F, since D has none in |w| ≤ 1.
    fn characteristic_polynomial(&self) -> Option<Vec<f64>> {
        let (above, below) = self.characteristic.operator.polynomials()?;
        let plant = &self.characteristic.plant;
        let mut sum = product(plant.denominator(), below);
        let environment = (0..above.len().max(below.len())).map(|j| {
            let at = |polynomial: &[f64]| polynomial.get(j).copied().unwrap_or(0.0);
            self.alpha * at(below) + self.beta * at(above)
        });
        let environment: Vec<f64> = environment.collect();
        let fed_back = product(plant.numerator(), &environment);
        let lag = plant.path().whole_samples() + 1;
        sum.resize(sum.len().max(lag + fed_back.len()), 0.0);
        for (j, term) in fed_back.iter().enumerate() {
            sum[lag + j] += term;
        }
        Some(sum)
    }

    /// The poles in z, for polynomial and rational operators; poles at z = 0 left out.
    #[must_use]
    pub fn poles(&self) -> Option<Vec<Complex<f64>>> {
        poles(self.characteristic_polynomial()?)
    }

    /// The largest |z| of a pole, that of a drift left out; `None` of an operator that is neither polynomial nor rational, and of a
    /// characteristic polynomial of degree above 64. Cost: n³.
    #[must_use]
    pub fn spectral_radius(&self) -> Option<f64> {
        let polynomial = self.characteristic_polynomial()?;
        if polynomial.len() > EIGENVALUE_DEGREE + 1 {
            return None;
        }
        let mut poles = poles(polynomial)?;
        if self.beside_rest {
            poles.sort_by(|a, b| (a - 1.0).norm().total_cmp(&(b - 1.0).norm()));
            poles.drain(..1);
        }
        let sizes = poles.iter().map(|pole| pole.norm());
        Some(sizes.fold(0.0, f64::max))
    }
}

/// Samples of the circle that all counts for one plant, operator and delay share.
/// ```text
/// zeros in |w| < 1 = −(1/π)·Δarg F·D over 0 ≤ θ ≤ π
/// ```
/// Each way between two samples is proved by a bound of the length of F's path, as [`Curve`] says.
///
/// *A loop that drifts* has zeros at w = 1 itself, F ~ c·v^p with c > 0, v = 1 − w. They are left outside by an arc round
/// them, on which F turns by p·π/2 from v = ε to v = jε: F is judged beside them, as it is.
#[derive(Clone, Debug)]
pub(crate) struct Circle<'a> {
    pub(crate) characteristic: Characteristic<'a>,
    nodes: Vec<Node>,
    spans: Vec<Ways<3>>,
}

impl<'a> Characteristic<'a> {
    /// The circle, sampled once for any number of counts.
    pub(crate) fn circle(&self) -> Circle<'a> {
        let nodes: Vec<Node> = Self::first_angles().map(|theta| self.node(theta)).collect();
        let spans = nodes
            .windows(2)
            .map(|pair| self.span(&pair[0], &pair[1]))
            .collect();
        Circle {
            characteristic: *self,
            nodes,
            spans,
        }
    }
}

/// Radii of the arc round w = 1 that are tried: the least on which F is above rounding.
const ARCS: [f64; 5] = [1e-9, 1e-8, 1e-7, 1e-6, 1e-5];
const ABOVE: f64 = 1e3;

impl Circle<'_> {
    /// Zeros of F in |w| < 1 with these α and β. On the circle if some |F| is at most this share of its terms and of n₁ + n₀, or no
    /// more than rounding error. `beside_rest`: those at w = 1 are left out.
    ///
    /// Cost: about 80 evaluations of three multiply-adds, and a full node wherever F is so small that
    /// an interval has to be halved: some ten for each decade.
    pub(crate) fn count(
        &self,
        gains: [f64; 2],
        tolerance: f64,
        beside_rest: bool,
    ) -> StabilityVerdict {
        let mut curve = Weighed {
            circle: self,
            gains,
            tolerance,
            fall: 0.0,
        };
        let arc = beside_rest.then(|| {
            let (end, turned) = curve.round_rest();
            (end, curve.span(&end, &self.nodes[1]), turned)
        });
        let whole = (&self.nodes[0], &self.spans[0], 0.0);
        let (begin, span, turned) = arc
            .as_ref()
            .map_or(whole, |(end, span, turned)| (end, span, *turned));
        let spans = core::iter::once(span).chain(&self.spans[1..]);
        curve.count(begin, turned, spans.zip(&self.nodes[1..]))
    }
}

struct Weighed<'a, 'b> {
    circle: &'a Circle<'b>,
    gains: [f64; 2],
    tolerance: f64,
    fall: f64,
}

impl Weighed<'_, '_> {
    /// The end of the arc round w = 1 and the turn up to there; keeps p.
    fn round_rest(&mut self) -> (Node, f64) {
        let characteristic = self.circle.characteristic;
        let value = |node: &Node| node.value(self.gains);
        let mut arcs = ARCS.iter().map(|radius| characteristic.node(*radius));
        let is_clear = |node: &Node| value(node).norm() > ABOVE * node.noise(self.gains);
        let end = arcs.find(is_clear).unwrap_or(self.circle.nodes[1]);
        let (near, far) = (value(&end), value(&characteristic.node(2.0 * end.theta())));
        self.fall = libm::log2(far.norm() / near.norm()).max(0.0);
        // Of the turns that end at this angle that of v^p.
        let whole = libm::round((0.25 * self.fall) - near.arg() / (2.0 * PI));
        (end, near.arg() + 2.0 * PI * whole)
    }
}

impl Curve for Weighed<'_, '_> {
    type Node = Node;
    type Span = Ways<3>;

    fn node(&self, theta: f64) -> Node {
        self.circle.characteristic.node(theta)
    }

    fn span(&self, a: &Node, b: &Node) -> Ways<3> {
        self.circle.characteristic.span(a, b)
    }

    /// The size is |F|, that of a loop that drifts over |v|^p too.
    fn sample(&self, node: &Node) -> NodeValue {
        let value = node.value(self.gains);
        let [alpha, beta] = self.gains;
        let size = node.terms.size(&[1.0, alpha, beta]);
        let fallen = match self.fall {
            0.0 => 1.0,
            fall => libm::pow(node.place.size_v.min(1.0), fall),
        };
        let scale = self.circle.characteristic.plant.numerator_sum()
            * node.operator.denominator.value.norm();
        NodeValue {
            theta: node.theta(),
            value,
            size: value.norm() / (scale * fallen),
            noise: node.noise(self.gains) + self.tolerance * size.min(scale),
        }
    }

    fn path(&self, a: &Node, b: &Node, span: &Ways<3>) -> f64 {
        let [alpha, beta] = self.gains;
        let width = b.theta() - a.theta();
        span.path([&a.terms, &b.terms], &[1.0, alpha, beta], width)
    }
}

/// The zeros in z = 1/w of Σ `x_j` w^j, those at z = 0 left out; `None` if a coefficient is no number.
pub(crate) fn poles(mut polynomial: Vec<f64>) -> Option<Vec<Complex<f64>>> {
    let used = polynomial.iter().rposition(|&x| x != 0.0)? + 1;
    polynomial.truncate(used);
    polynomial.reverse();
    let poles = fracdiff::roots(&polynomial);
    poles.iter().all(|pole| pole.is_finite()).then_some(poles)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from_poles(poles: &[f64]) -> Vec<f64> {
        // Π (1 − p·w)
        (poles.iter()).fold(vec![1.0], |above, p| product(&above, &[1.0, -p]))
    }

    #[test]
    fn a_multiple_pole_is_counted_as_often_as_it_stands() {
        // A triple pole splits by the rounding of the coefficients.
        for pole in [0.3, 0.9, 0.99, 1.01] {
            let values = poles(from_poles(&[pole; 3])).expect("finite");
            let far = |value: &Complex<f64>| (value - pole).norm() > 1e-4;
            assert!(values.len() == 3 && !values.iter().any(far), "{values:?}");
        }
    }

    #[test]
    fn a_polynomial_gives_back_the_poles_it_was_made_from() {
        let found = poles(from_poles(&[0.9, -0.5, 1.2, 0.0])).expect("finite");
        let mut have: Vec<f64> = found.iter().map(|pole| pole.re).collect();
        have.sort_by(f64::total_cmp);
        for (have, want) in have.iter().zip([-0.5, 0.9, 1.2]) {
            assert!((have - want).abs() < 1e-14, "{have} {want}");
        }
    }
}
