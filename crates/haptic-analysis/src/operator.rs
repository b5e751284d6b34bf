//! The operator P(w) as the analysis sees it.

use crate::functions::{Curve, Polynomial, Power};
use certified_count::{Bounds, Jet, Place};
use fracdiff::{FrequencyResponse, Order};
use num_complex::Complex;

/// An operator D^μ ≈ T^(−μ)·P(w), 0 ≤ μ ≤ 2, with everything a proof about its loop needs.
/// ```text
/// exact                     P = (1 − w)^μ                           irrational
/// grunwald:N, muir:N        P = Σ_{j<N} c_j w^j, A_N(w, μ)          polynomial
/// tustin-muir:N             P = 2^φ(1 − w)^n A_N(w, φ)/A_N(w, −φ)    rational, μ = n + φ
/// full, piecewise-linear    P = (1 − w)^⌈μ⌉ [Σ k_j w^j + Σ_q W_q/(1 − r_q w)]
/// full-bdf2                 that of full, times Σ_{j<28} f_j w^j
/// oustaloup                 P = (1 − w)^n g·Π (v + z_i(2 − v))/(v + p_i(2 − v)),   v = 1 − w
/// ```
/// One's own full memory, of any kernel: [`from_design`](Self::from_design).
///
/// All are analytic in |w| < 1 and bounded on the circle, which the argument principle needs; so
/// integrals (μ < 0, a pole at w = 1) are refused. A controller may have one, whose denominator stands in F
/// instead: [`from_controller`](Self::from_controller).
///
/// - *Coefficients*: the `f64` ones, without T^(−μ): what the running operator holds, before it rounds them to its sample type.
/// - *Derivative*: known for each kind in closed form, with bounds over any interval, so
///   that a curve can be proved to avoid zero between samples ([`variation`](Self::variation)).
/// - *Cost of a response*: one power and two sines for the exact operator, N multiply-adds for a polynomial.
/// ```
/// use fracdiff::{FrequencyResponse, Order, Scheme, Seconds};
/// use haptic_analysis::LoopOperator;
///
/// let order = Order::new(0.5)?;
/// let exact = LoopOperator::new(Scheme::Exact, order, Seconds(1e-3), 1e4)?;
/// let full = LoopOperator::new("full:1e-6".parse()?, order, Seconds(1e-3), 1e5)?;
/// assert!((exact.response(0.1) - full.response(0.1)).norm() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LoopOperator {
    order: Order,
    /// n of the factor (1 − w)^n in front of the numerator.
    pub(crate) differences: Power,
    numerator: Curve,
    denominator: Curve,
    /// Numerator and denominator multiplied out, where there are any.
    pub(crate) polynomials: Option<(Vec<f64>, Vec<f64>)>,
}

/// Numerator and denominator of P at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OperatorNode {
    differences: Jet,
    core: Jet,
    pub(crate) numerator: Jet,
    pub(crate) denominator: Jet,
}

impl OperatorNode {
    /// That of the operator 1.
    pub(crate) const ONE: Self = Self {
        differences: Jet::ONE,
        core: Jet::ONE,
        numerator: Jet::ONE,
        denominator: Jet::ONE,
    };
}

impl LoopOperator {
    pub(crate) fn exact(order: Order) -> Self {
        Self::irrational(order, 0.0, Curve::Power(Power(order.get())))
    }

    pub(crate) fn polynomial(order: Order, coefficients: Vec<f64>) -> Self {
        Self::rational(order, coefficients, vec![1.0])
    }

    pub(crate) fn rational(order: Order, numerator: Vec<f64>, denominator: Vec<f64>) -> Self {
        let (numerator, denominator) = (Polynomial::new(numerator), Polynomial::new(denominator));
        let polynomials = (
            numerator.coefficients.clone(),
            denominator.coefficients.clone(),
        );
        Self {
            order,
            differences: Power(0.0),
            numerator: Curve::Polynomial(numerator),
            denominator: Curve::Polynomial(denominator),
            polynomials: Some(polynomials),
        }
    }

    pub(crate) fn irrational(order: Order, differences: f64, core: Curve) -> Self {
        Self {
            order,
            differences: Power(differences),
            numerator: core,
            denominator: Curve::one(),
            polynomials: None,
        }
    }

    /// Operator of a function over another one.
    pub(crate) fn given(order: Order, above: Curve, below: Curve) -> Self {
        Self {
            denominator: below,
            ..Self::irrational(order, 0.0, above)
        }
    }

    /// The order μ, which sets the unit of the gain B.
    #[must_use]
    pub fn order(&self) -> Order {
        self.order
    }

    /// Numerator and denominator of P in powers of w, from w⁰ on. `None` for an operator without,
    /// or (full memory, Oustaloup) with poles so close that multiplied out they would be lost to
    /// rounding.
    #[must_use]
    pub fn polynomials(&self) -> Option<(&[f64], &[f64])> {
        let (numerator, denominator) = self.polynomials.as_ref()?;
        Some((numerator, denominator))
    }

    /// Length of the memory of polynomials, samples, which limits how fast the response can change with the
    /// angle; 1 without. For [`OnePort::with_memory`](crate::OnePort::with_memory).
    #[must_use]
    pub fn memory(&self) -> usize {
        self.polynomials()
            .map_or(1, |(above, below)| above.len().max(below.len()))
    }

    /// P at w = 0, the direct gain: above 0 for every kind, except perhaps a controller.
    #[must_use]
    pub fn direct_gain(&self) -> f64 {
        self.numerator.at_zero() / self.denominator.at_zero()
    }

    /// P(e^(−jθ)) and its derivative by θ; the derivative of the exact operator is infinite at θ = 0 for 0 < μ < 1.
    pub(crate) fn response_and_rate(&self, theta: f64) -> (Complex<f64>, Complex<f64>) {
        let node = self.node(&Place::new(theta));
        let jet = if self.denominator.is_one() {
            node.numerator
        } else {
            node.numerator.over(node.denominator)
        };
        (jet.value, jet.rate)
    }

    /// An upper bound of |P(e^(−jθ₁)) − P(e^(−jθ₂))| for any two angles in [low, high], and of the
    /// length ∫|dP/dθ| dθ of the path between them; 0 ≤ low ≤ high ≤ π.
    /// ```text
    /// exact        ∫ μ(2 sin(θ/2))^(μ−1) dθ ≤ (|P(high)| − |P(low)|)/cos(high/2)
    /// polynomial   the least of (high − low)·Σ j|c_j| and what |P′| at the ends and Σ j²|c_j| allow
    /// others       from the rates of their modes and sections
    /// ```
    /// Finite also at θ = 0 for μ < 1, where the exact operator behaves like θ^μ. Tends to the length itself as the interval shrinks.
    #[must_use]
    pub fn variation(&self, low: f64, high: f64) -> f64 {
        let (a, b) = (Place::new(low), Place::new(high));
        let (node_a, node_b) = (self.node(&a), self.node(&b));
        let [above, below] = self.bounds((&a, &node_a), (&b, &node_b));
        let bound = self.quotient_travel(&node_a, &node_b, [above, below], high - low);
        // Bounds over a long interval are crude, or infinite.
        let size =
            |node: &OperatorNode| node.numerator.value.norm() / node.denominator.value.norm();
        if bound <= 4.0 * (size(&node_a) + size(&node_b)) || high - low < 1e-9 {
            return bound;
        }
        let middle = 0.5 * (low + high);
        self.variation(low, middle) + self.variation(middle, high)
    }

    /// The length of the path of N/D, infinite if D is not known to avoid zero.
    /// ```text
    /// |P′| ≤ (n′ + p·d′)/d,   |P″| ≤ (n″ + p·d″ + 2p′d′)/d,   n, n′, n″, d′, d″ bounds, d ≤ |D|, p = n/d
    /// ```
    fn quotient_travel(
        &self,
        a: &OperatorNode,
        b: &OperatorNode,
        [above, below]: [Bounds; 2],
        width: f64,
    ) -> f64 {
        if !self.has_denominator() {
            return above.travel;
        }
        let ends = a.denominator.value.norm() + b.denominator.value.norm();
        let least = 0.5 * (ends - below.travel);
        if least <= 0.0 {
            return f64::INFINITY;
        }
        let size = above.size / least;
        let rate = (above.rate + size * below.rate) / least;
        let bend = (above.bend + size * below.bend + 2.0 * rate * below.rate) / least;
        let quotient = |node: &OperatorNode| node.numerator.over(node.denominator);
        Bounds::from_ends(&quotient(a), &quotient(b), width, rate, bend).travel
    }

    pub(crate) fn has_denominator(&self) -> bool {
        !self.denominator.is_one()
    }

    /// Number of coefficients, as a measure of how fast P can wind.
    pub(crate) fn degree(&self) -> usize {
        self.numerator.degree().max(self.denominator.degree())
    }

    pub(crate) fn node(&self, place: &Place) -> OperatorNode {
        let core = self.numerator.jet(place);
        let (differences, numerator) = if self.differences.0 == 0.0 {
            (Jet::ONE, core)
        } else {
            let differences = self.differences.jet(place);
            (differences, core.times(differences))
        };
        let denominator = if self.denominator.is_one() {
            Jet::ONE
        } else {
            self.denominator.jet(place)
        };
        OperatorNode {
            differences,
            core,
            numerator,
            denominator,
        }
    }

    /// Bounds of numerator and denominator over an interval.
    pub(crate) fn bounds(
        &self,
        a: (&Place, &OperatorNode),
        b: (&Place, &OperatorNode),
    ) -> [Bounds; 2] {
        let mut above = self.numerator.bounds((a.0, &a.1.core), (b.0, &b.1.core));
        if self.differences.0 != 0.0 {
            let factor =
                (self.differences).bounds((a.0, &a.1.differences), (b.0, &b.1.differences));
            let product = above.times(factor);
            // The two factors of an operator on increments grow against each other; the jets of their product know.
            let width = b.0.theta - a.0.theta;
            let (low, high) = (&a.1.numerator, &b.1.numerator);
            let ends = Bounds::from_ends(low, high, width, product.rate, product.bend);
            above = Bounds {
                size: product.size.min(ends.size),
                rate: product.rate.min(ends.rate),
                bend: product.bend,
                travel: product.travel.min(ends.travel),
            };
        }
        let below = if self.denominator.is_one() {
            Bounds::ONE
        } else {
            (self.denominator).bounds((a.0, &a.1.denominator), (b.0, &b.1.denominator))
        };
        [above, below]
    }
}

impl FrequencyResponse for LoopOperator {
    fn response(&self, theta: f64) -> Complex<f64> {
        self.response_and_rate(theta).0
    }
}
