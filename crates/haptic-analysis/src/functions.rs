//! The functions that operators are made of: powers, polynomials, decaying modes, cascades.

use certified_count::{Arc, Bounds, Enclosing, Jet, Place, product};
use num_complex::Complex;
use std::sync::Arc as Shared;

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Curve {
    Polynomial(Polynomial),
    Power(Power),
    Modes(Modes),
    /// A memory behind a short filter.
    Filtered(Modes, Polynomial),
    Cascade(Cascade),
    Given(Given),
}

impl Curve {
    pub(crate) fn one() -> Self {
        Self::Polynomial(Polynomial::new(vec![1.0]))
    }

    pub(crate) fn is_one(&self) -> bool {
        matches!(self, Self::Polynomial(curve) if curve.coefficients == [1.0])
    }

    /// The value at w = 0.
    pub(crate) fn at_zero(&self) -> f64 {
        match self {
            Self::Polynomial(curve) => curve.coefficients[0],
            Self::Power(_) => 1.0,
            Self::Modes(curve) => curve.at_zero(),
            Self::Filtered(curve, filter) => curve.at_zero() * filter.coefficients[0],
            Self::Cascade(curve) => {
                let sections = curve.corners.iter();
                let gains = sections.map(|(z, p)| (1.0 + z) / (1.0 + p));
                curve.gain * gains.product::<f64>()
            }
            Self::Given(curve) => curve.at_zero,
        }
    }

    /// Number of coefficients less one, as a measure of how fast it can wind.
    pub(crate) fn degree(&self) -> usize {
        let of = |polynomial: &Polynomial| polynomial.coefficients.len() - 1;
        match self {
            Self::Polynomial(curve) => of(curve),
            Self::Modes(curve) => of(&curve.taps),
            Self::Filtered(curve, filter) => of(&curve.taps) + of(filter),
            Self::Power(_) | Self::Cascade(_) => 2,
            Self::Given(_) => GIVEN_DEGREE,
        }
    }

    pub(crate) fn jet(&self, place: &Place) -> Jet {
        match self {
            Self::Polynomial(curve) => curve.jet(place),
            Self::Power(curve) => curve.jet(place),
            Self::Modes(curve) => curve.jet(place),
            Self::Filtered(curve, filter) => curve.jet(place).times(filter.jet(place)),
            Self::Cascade(curve) => curve.jet(place),
            Self::Given(curve) => curve.jet(place),
        }
    }

    pub(crate) fn bounds(&self, a: (&Place, &Jet), b: (&Place, &Jet)) -> Bounds {
        match self {
            Self::Polynomial(curve) => curve.bounds(a.1, b.1, b.0.theta - a.0.theta),
            Self::Power(curve) => curve.bounds(a, b),
            Self::Modes(curve) => curve.bounds(a, b),
            Self::Filtered(curve, filter) => {
                let [near, far] = [a.0, b.0].map(|place| (curve.jet(place), filter.jet(place)));
                let memory = curve.bounds((a.0, &near.0), (b.0, &far.0));
                memory.times(filter.bounds(&near.1, &far.1, b.0.theta - a.0.theta))
            }
            Self::Cascade(curve) => curve.bounds(a, b),
            Self::Given(curve) => curve.bounds(a, b),
        }
    }
}

/// Taps of a memory and of a short filter behind it, of which a controller is made.
const GIVEN_DEGREE: usize = 64;

/// A function of another crate.
#[derive(Clone, Debug)]
pub(crate) struct Given {
    pub(crate) function: Shared<dyn Enclosing>,
    pub(crate) at_zero: f64,
}

impl PartialEq for Given {
    fn eq(&self, other: &Self) -> bool {
        Shared::ptr_eq(&self.function, &other.function)
    }
}

impl Given {
    fn jet(&self, place: &Place) -> Jet {
        self.function.at(&Arc::new(place.theta, place.theta)).middle
    }

    fn bounds(&self, a: (&Place, &Jet), b: (&Place, &Jet)) -> Bounds {
        let arc = Arc::new(a.0.theta, b.0.theta);
        let over = self.function.at(&arc);
        let width = b.0.theta - a.0.theta;
        Bounds::from_ends(a.1, b.1, width, over.rate, over.bend)
    }
}

/// Terms in powers of v that are exact where degree·|v| ≤ 1/4: 0.25^12/12! is below 1e-15.
const NEAR_REST: usize = 12;

/// Σ `c_j` w^j.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Polynomial {
    pub(crate) coefficients: Vec<f64>,
    /// The first coefficients in powers of v = 1 − w. Near rest a difference operator is all
    /// cancellation in powers of w: the result for (1 − w)² at 1e-6 rad is rounding error.
    near_rest: [f64; NEAR_REST],
    /// `Σ j|c_j|` and `Σ j²|c_j|`.
    rate: f64,
    bend: f64,
}

impl Polynomial {
    pub(crate) fn new(mut coefficients: Vec<f64>) -> Self {
        while coefficients.len() > 1 && coefficients.last() == Some(&0.0) {
            coefficients.pop();
        }
        let moment = |power: i32| {
            let terms = coefficients.iter().enumerate();
            terms
                .map(|(j, c)| libm::pow(j as f64, f64::from(power)) * c.abs())
                .sum()
        };
        let (rate, bend) = (moment(1), moment(2));
        // Σ_j c_j(1 − v)^j = Σ_k (−v)^k Σ_j C(j, k)·c_j
        let mut near_rest = [0.0; NEAR_REST];
        for (j, c) in coefficients.iter().enumerate() {
            let mut signed_binomial = 1.0;
            for (k, term) in near_rest.iter_mut().enumerate().take(j + 1) {
                *term += signed_binomial * c;
                signed_binomial *= -((j - k) as f64) / (k + 1) as f64;
            }
        }
        Self {
            coefficients,
            near_rest,
            rate,
            bend,
        }
    }

    pub(crate) fn jet(&self, place: &Place) -> Jet {
        let degree = self.coefficients.len() as f64;
        // dw/dθ = −jw, dv/dθ = jw
        if degree * place.size_v <= 0.25 {
            let (value, slope) = horner(&self.near_rest, place.v);
            return Jet::new(value, slope * place.w * Complex::new(0.0, 1.0));
        }
        let (value, slope) = horner(&self.coefficients, place.w);
        Jet::new(value, slope * place.w * Complex::new(0.0, -1.0))
    }

    pub(crate) fn bounds(&self, a: &Jet, b: &Jet, width: f64) -> Bounds {
        Bounds::from_ends(a, b, width, self.rate, self.bend)
    }
}

fn horner(coefficients: &[f64], x: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
    let zero = Complex::new(0.0, 0.0);
    let terms = coefficients.iter().rev();
    terms.fold((zero, zero), |(value, slope), c| {
        (value * x + c, slope * x + value)
    })
}

/// v^μ = (1 − w)^μ for 0 ≤ μ ≤ 2, any real μ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Power(pub(crate) f64);

impl Power {
    #[expect(
        clippy::float_cmp,
        reason = "the whole orders are special, not those near them"
    )]
    pub(crate) fn jet(self, place: &Place) -> Jet {
        let order = self.0;
        let value = if order == 0.0 {
            Complex::new(1.0, 0.0)
        } else if order == 1.0 {
            place.v
        } else if order == 2.0 {
            place.v * place.v
        } else {
            // |v|^μ·e^(jμ(π − θ)/2)
            let size = libm::pow(place.size_v, order);
            let (sin, cos) = libm::sincos(0.5 * order * (core::f64::consts::PI - place.theta));
            Complex::new(size * cos, size * sin)
        };
        // dP/dθ = jμw·v^(μ−1)
        let slope = if place.size_v > 0.0 {
            value / place.v
        } else if order == 1.0 {
            Complex::new(1.0, 0.0)
        } else if order > 1.0 || order == 0.0 {
            Complex::new(0.0, 0.0)
        } else {
            Complex::new(f64::INFINITY, 0.0)
        };
        let rate = if slope.re.is_infinite() {
            Complex::new(0.0, f64::INFINITY)
        } else {
            slope * place.w * Complex::new(0.0, order)
        };
        Jet::new(value, rate)
    }

    /// |P′| = μ|v|^(μ−1), |P″| ≤ μ|v|^(μ−1) + μ|μ−1||v|^(μ−2); `∫|P′| ≤ (|v_b|^μ − |v_a|^μ)/cos(b/2)`
    /// since d|v| = cos(θ/2) dθ. |v| grows with θ, so every bound sits at one end.
    pub(crate) fn bounds(self, a: (&Place, &Jet), b: (&Place, &Jet)) -> Bounds {
        let order = self.0;
        let (size_a, size_b) = (a.1.value.norm(), b.1.value.norm());
        let at_least = if order < 1.0 { a } else { b };
        let rate = product(order, power_below(order, 1.0, at_least.0, at_least.1));
        let curved = if order < 2.0 { a } else { b };
        let below = power_below(order, 2.0, curved.0, curved.1);
        let bend = rate + product(order * (order - 1.0).abs(), below);
        let width = b.0.theta - a.0.theta;
        let cos = 0.5 * b.0.size_u;
        let straight = if cos > 0.0 {
            (size_b - size_a).max(0.0) / cos
        } else {
            f64::INFINITY
        };
        Bounds {
            size: size_b,
            rate,
            bend,
            travel: (1.0 + 1e-12) * straight.min(width * rate),
        }
    }
}

/// |v|^(μ − k) from |v|^μ.
fn power_below(order: f64, k: f64, place: &Place, jet: &Jet) -> f64 {
    if place.size_v > 0.0 {
        jet.value.norm() / libm::pow(place.size_v, k)
    } else if order < k {
        f64::INFINITY
    } else if order > k {
        0.0
    } else {
        1.0
    }
}

/// `Σ_j k_j w^j + Σ_q W_q/(1 − r_q w)`, a memory of taps and decaying modes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Modes {
    pub(crate) taps: Polynomial,
    /// `W_q` and 1 − `r_q`.
    pub(crate) modes: Vec<(f64, f64)>,
}

impl Modes {
    pub(crate) fn at_zero(&self) -> f64 {
        let weights = self.modes.iter().map(|(weight, _)| weight);
        self.taps.coefficients[0] + weights.sum::<f64>()
    }

    pub(crate) fn jet(&self, place: &Place) -> Jet {
        let mut jet = self.taps.jet(place);
        for &(weight, decay) in &self.modes {
            // 1 − rw = d + rv
            let r = 1.0 - decay;
            let mode = (place.v * r + decay).inv();
            jet.value += mode * weight;
            // d/dθ = −jw·r/(1 − rw)²
            jet.rate += mode * mode * place.w * Complex::new(0.0, -r * weight);
        }
        jet
    }

    pub(crate) fn bounds(&self, a: (&Place, &Jet), b: (&Place, &Jet)) -> Bounds {
        let width = b.0.theta - a.0.theta;
        let mut rate = self.taps.rate;
        let mut bend = self.taps.bend;
        for &(weight, decay) in &self.modes {
            let r = 1.0 - decay;
            // |1 − rw|² = d² + r|v|², least at the low end.
            let square = decay * decay + r * a.0.size_v * a.0.size_v;
            let slope = weight.abs() * r / square;
            rate += slope;
            bend += slope * (1.0 + 2.0 * r / libm::sqrt(square));
        }
        Bounds::from_ends(a.1, b.1, width, rate, bend)
    }
}

/// `g·Π (v + z_i(2 − v))/(v + p_i(2 − v))`, first-order sections under the Tustin rule.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cascade {
    pub(crate) gain: f64,
    /// Half the zero and half the pole, rad/sample.
    pub(crate) corners: Vec<(f64, f64)>,
}

impl Cascade {
    pub(crate) fn jet(&self, place: &Place) -> Jet {
        let mut value = Complex::new(self.gain, 0.0);
        let mut slope = Complex::new(0.0, 0.0);
        for &(zero, pole) in &self.corners {
            let above = place.v * (1.0 - zero) + 2.0 * zero;
            let below = place.v * (1.0 - pole) + 2.0 * pole;
            value *= above / below;
            // d ln/dθ = jw·2(p − z)/(above·below)
            slope += (above * below).inv() * (2.0 * (pole - zero));
        }
        Jet::new(value, value * slope * place.w * Complex::new(0.0, 1.0))
    }

    pub(crate) fn bounds(&self, a: (&Place, &Jet), b: (&Place, &Jet)) -> Bounds {
        let width = b.0.theta - a.0.theta;
        // |v + z(1 + w)|² = |v|² + z²|1 + w|² is monotone in θ.
        let least = |corner: f64| {
            let at = |place: &Place| libm::hypot(place.size_v, corner * place.size_u);
            at(a.0).min(at(b.0))
        };
        let (mut slope, mut curl) = (0.0, 0.0);
        for &(zero, pole) in &self.corners {
            let (above, below) = (least(zero), least(pole));
            let rate = 2.0 * (pole - zero).abs() / (above * below);
            slope += rate;
            curl += rate * (1.0 + (1.0 - zero).abs() / above + (1.0 - pole).abs() / below);
        }
        let ends = a.1.value.norm().max(b.1.value.norm());
        let size = ends * libm::exp(0.5 * slope * width);
        Bounds::from_ends(a.1, b.1, width, size * slope, size * (slope * slope + curl))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curves() -> Vec<(&'static str, Curve)> {
        let modes = Modes {
            taps: Polynomial::new(vec![1.0, -0.3, 0.2]),
            modes: vec![(-0.2, 0.5), (-1e-3, 1e-3), (-1e-6, 1e-6)],
        };
        let cascade = Cascade {
            gain: 1.3,
            corners: vec![(1e-4, 3e-4), (1e-2, 0.02), (0.7, 1.4)],
        };
        vec![
            (
                "polynomial",
                Curve::Polynomial(Polynomial::new(vec![1.0, -1.5, 0.4, 0.3])),
            ),
            ("(1 - w)^0.3", Curve::Power(Power(0.3))),
            ("(1 - w)^1.6", Curve::Power(Power(1.6))),
            ("(1 - w)^2", Curve::Power(Power(2.0))),
            (
                "modes behind a filter",
                Curve::Filtered(modes.clone(), Polynomial::new(vec![1.5, -0.4, -0.1])),
            ),
            ("modes", Curve::Modes(modes)),
            ("cascade", Curve::Cascade(cascade)),
        ]
    }

    #[test]
    fn the_rate_is_the_derivative_of_the_value() {
        for (name, curve) in curves() {
            for theta in [1e-3, 0.1, 1.0, 2.0, 3.0] {
                let h = 1e-5 * theta;
                let at = |theta| curve.jet(&Place::new(theta)).value;
                let want = (at(theta + h) - at(theta - h)) / (2.0 * h);
                let have = curve.jet(&Place::new(theta)).rate;
                let error = (have - want).norm() / want.norm();
                assert!(error < 1e-6, "{name}, θ = {theta}: {have} {want} {error:e}");
            }
        }
    }

    #[test]
    fn no_sample_inside_an_interval_exceeds_its_bounds() {
        for (name, curve) in curves() {
            for (a, b) in [
                (0.0, 0.01),
                (1e-3, 2e-3),
                (0.1, 0.5),
                (1.0, 1.2),
                (2.5, core::f64::consts::PI),
            ] {
                let (pa, pb) = (Place::new(a), Place::new(b));
                let (ja, jb) = (curve.jet(&pa), curve.jet(&pb));
                let bounds = curve.bounds((&pa, &ja), (&pb, &jb));
                let (mut travel, mut last) = (0.0, ja.value);
                for i in 1..=200_u32 {
                    let theta = a + (b - a) * f64::from(i) / 200.0;
                    let jet = curve.jet(&Place::new(theta));
                    travel += (jet.value - last).norm();
                    last = jet.value;
                    let slack = 1.0 + 1e-9;
                    assert!(
                        jet.value.norm() <= bounds.size * slack,
                        "{name}, size at {theta}"
                    );
                    assert!(
                        jet.rate.norm() <= bounds.rate * slack,
                        "{name}, rate at {theta}"
                    );
                    let h = 1e-6 * theta;
                    let bend = (curve.jet(&Place::new(theta - h)).rate - jet.rate).norm() / h;
                    let most = bounds.bend * (1.0 + 1e-3) + 1e-3;
                    assert!(bend <= most, "{name}, bend at {theta}");
                }
                let most = bounds.travel * (1.0 + 1e-9);
                assert!(travel <= most, "{name}, [{a}, {b}]: {travel}");
            }
        }
    }
}
