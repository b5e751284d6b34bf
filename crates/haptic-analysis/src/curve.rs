//! Functions on the unit circle with their derivatives, and bounds of both over an interval: what
//! makes it possible to prove that a curve stays away from zero between two samples.

use certified_count::Place;
use num_complex::Complex;

/// w^k: by squaring while that is exact to a few rounding errors, by the angle beyond.
pub(crate) fn w_to(place: &Place, k: usize) -> Complex<f64> {
    if k <= 16 {
        return (0..k).fold(Complex::new(1.0, 0.0), |power, _| power * place.w);
    }
    let (sin, cos) = libm::sincos(k as f64 * place.theta);
    Complex::new(cos, -sin)
}

/// A function of θ and its derivative by θ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jet {
    pub(crate) value: Complex<f64>,
    pub(crate) rate: Complex<f64>,
}

impl Jet {
    pub(crate) const fn new(value: Complex<f64>, rate: Complex<f64>) -> Self {
        Self { value, rate }
    }

    pub(crate) const ONE: Self = Self::new(Complex::new(1.0, 0.0), Complex::new(0.0, 0.0));

    pub(crate) fn times(self, other: Self) -> Self {
        Self::new(
            self.value * other.value,
            self.rate * other.value + self.value * other.rate,
        )
    }

    pub(crate) fn over(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self {
            value,
            rate: (self.rate - value * other.rate) / other.value,
        }
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        Self::new(self.value + other.value, self.rate + other.rate)
    }

    pub(crate) fn conj(self) -> Self {
        Self::new(self.value.conj(), self.rate.conj())
    }
}

/// Upper bounds over an interval of θ. May be infinite, never NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    /// sup |f|.
    pub(crate) size: f64,
    /// sup |f′|.
    pub(crate) rate: f64,
    /// sup |f″|.
    pub(crate) bend: f64,
    /// ∫|f′| dθ, the length of the path: finite even where the rate is not.
    pub(crate) travel: f64,
}

impl Bounds {
    pub(crate) const ONE: Self = Self {
        size: 1.0,
        rate: 0.0,
        bend: 0.0,
        travel: 0.0,
    };

    pub(crate) fn times(self, other: Self) -> Self {
        Self {
            size: product(self.size, other.size),
            rate: product(self.rate, other.size) + product(self.size, other.rate),
            bend: product(self.bend, other.size)
                + 2.0 * product(self.rate, other.rate)
                + product(self.size, other.bend),
            travel: product(self.travel, other.size) + product(self.size, other.travel),
        }
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            size: self.size + other.size,
            rate: self.rate + other.rate,
            bend: self.bend + other.bend,
            travel: self.travel + other.travel,
        }
    }

    /// Of a function with these global bounds of rate and bend, from its jets at both ends.
    pub(crate) fn from_ends(a: &Jet, b: &Jet, width: f64, rate: f64, bend: f64) -> Self {
        let (rate_a, rate_b) = (a.rate.norm(), b.rate.norm());
        let rate_here = (rate_a.max(rate_b) + 0.5 * bend * width).min(rate);
        // ∫ min(|f′(a)| + bend·t, |f′(b)| + bend·(width − t)) dt
        let mean = 0.5 * (rate_a + rate_b) + 0.25 * bend * width;
        let travel = width * mean.min(rate_here);
        Self {
            size: 0.5 * (a.value.norm() + b.value.norm() + travel),
            rate: rate_here,
            bend,
            travel,
        }
    }
}

/// The product of two bounds, where nothing times anything is nothing.
pub(crate) fn product(x: f64, y: f64) -> f64 {
    if x == 0.0 || y == 0.0 { 0.0 } else { x * y }
}

/// A polynomial and its derivative at v, the coefficient of v⁰ first.
pub(crate) fn powers_in_v(coefficients: &[f64], v: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
    let horner = |factor: fn(usize) -> f64, skip: usize| {
        let terms = coefficients.iter().enumerate().skip(skip).rev();
        terms.fold(Complex::new(0.0, 0.0), |sum, (k, c)| {
            sum * v + factor(k) * c
        })
    };
    (horner(|_| 1.0, 0), horner(|k| k as f64, 1))
}

/// A polynomial in v as a function of θ: dv/dθ = jw.
pub(crate) fn jet_in_v(coefficients: &[f64], place: &Place) -> Jet {
    let (value, slope) = powers_in_v(coefficients, place.v);
    Jet::new(value, slope * (place.w * Complex::new(0.0, 1.0)))
}

/// `Σ|c_k||v|^k`.
pub(crate) fn size_in_v(coefficients: &[f64], size_v: f64) -> f64 {
    coefficients.iter().enumerate().fold(0.0, |sum, (k, c)| {
        sum + (0..k).fold(c.abs(), |term, _| term * size_v)
    })
}

/// Bounds of a polynomial in v between two places.
pub(crate) fn bounds_in_v(
    coefficients: &[f64],
    a: &Place,
    b: &Place,
    jet_a: &Jet,
    jet_b: &Jet,
) -> Bounds {
    // |A′| ≤ Σ k|a_k||v|^(k−1), |A″| ≤ that + Σ k(k − 1)|a_k||v|^(k−2), and |v| grows with θ.
    let (mut rate, mut curl) = (0.0, 0.0);
    for (k, c) in coefficients.iter().enumerate().skip(1) {
        let most = |power: usize| (0..power).fold(c.abs(), |term, _| term * b.size_v);
        rate += k as f64 * most(k - 1);
        if k > 1 {
            curl += (k * (k - 1)) as f64 * most(k - 2);
        }
    }
    Bounds::from_ends(jet_a, jet_b, b.theta - a.theta, rate, rate + curl)
}

/// A real function of θ with its derivative.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Real {
    pub(crate) value: f64,
    pub(crate) rate: f64,
}

impl Real {
    pub(crate) fn imaginary_of(jet: Jet) -> Self {
        let (value, rate) = (jet.value.im, jet.rate.im);
        Self { value, rate }
    }

    pub(crate) fn times(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            rate: self.rate * other.value + self.value * other.rate,
        }
    }
}
