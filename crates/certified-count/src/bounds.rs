//! A function of θ with its derivatives: at an angle, and bounded between two.

use num_complex::Complex;

/// A function of θ and its derivative by θ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet {
    /// f.
    pub value: Complex<f64>,
    /// f′.
    pub rate: Complex<f64>,
}

impl Jet {
    /// Jet of a value and its derivative.
    #[must_use]
    pub const fn new(value: Complex<f64>, rate: Complex<f64>) -> Self {
        Self { value, rate }
    }

    /// The constant 1.
    pub const ONE: Self = Self::new(Complex::new(1.0, 0.0), Complex::new(0.0, 0.0));

    /// The product of two functions.
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        Self::new(
            self.value * other.value,
            self.rate * other.value + self.value * other.rate,
        )
    }

    /// The quotient of two functions.
    #[must_use]
    pub fn over(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self {
            value,
            rate: (self.rate - value * other.rate) / other.value,
        }
    }

    /// The sum of two functions.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self::new(self.value + other.value, self.rate + other.rate)
    }

    /// The function that is conjugate at each θ.
    #[must_use]
    pub fn conj(self) -> Self {
        Self::new(self.value.conj(), self.rate.conj())
    }
}

/// Upper bounds over an interval of θ. May be infinite, never NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// sup |f|.
    pub size: f64,
    /// sup |f′|.
    pub rate: f64,
    /// sup |f″|.
    pub bend: f64,
    /// ∫|f′| dθ, the length of the path: finite even where the rate is not.
    pub travel: f64,
}

impl Bounds {
    /// Bounds of the constant 1.
    pub const ONE: Self = Self {
        size: 1.0,
        rate: 0.0,
        bend: 0.0,
        travel: 0.0,
    };

    /// Bounds of the product of two functions.
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        Self {
            size: product(self.size, other.size),
            rate: product(self.rate, other.size) + product(self.size, other.rate),
            bend: product(self.bend, other.size)
                + 2.0 * product(self.rate, other.rate)
                + product(self.size, other.bend),
            travel: product(self.travel, other.size) + product(self.size, other.travel),
        }
    }

    /// Bounds of the sum of two functions.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            size: self.size + other.size,
            rate: self.rate + other.rate,
            bend: self.bend + other.bend,
            travel: self.travel + other.travel,
        }
    }

    /// Bounds of a function with these global bounds of rate and bend, from its jets at both ends.
    #[must_use]
    pub fn from_ends(a: &Jet, b: &Jet, width: f64, rate: f64, bend: f64) -> Self {
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
#[must_use]
pub fn product(x: f64, y: f64) -> f64 {
    if x == 0.0 || y == 0.0 { 0.0 } else { x * y }
}
