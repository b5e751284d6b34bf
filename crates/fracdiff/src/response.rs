//! Frequency response of the dimensionless operator P.

use crate::Order;
use num_complex::Complex;

/// P(e^(−jθ)) of a discrete operator D^μ ≈ T^(−μ)·P(w), w = z^(−1) the delay of one sample.
///
/// - θ = ωT, digital frequency, rad/sample, 0 ≤ θ ≤ π.
/// - Every operator gives the response of the coefficients it really holds, rounded to its sample
///   type, and without the T^(−μ): what stability and passivity formulas take.
/// - At θ = 0 an operator with a pole there (an integral) returns an infinity or NaN.
pub trait FrequencyResponse {
    /// P(e^(−jθ)) at the angle θ = ωT, rad; without the factor T^(−μ), so it has no unit.
    fn response(&self, theta: f64) -> Complex<f64>;
}

impl<P: FrequencyResponse + ?Sized> FrequencyResponse for &P {
    fn response(&self, theta: f64) -> Complex<f64> {
        (**self).response(theta)
    }
}

#[cfg(feature = "alloc")]
impl<P: FrequencyResponse + ?Sized> FrequencyResponse for alloc::boxed::Box<P> {
    fn response(&self, theta: f64) -> Complex<f64> {
        (**self).response(theta)
    }
}

/// The exact backward-difference operator (1 − w)^μ, for analysis: irrational, so it cannot run as a filter of finite order.
/// ```text
/// P(e^(−jθ)) = (2 sin(θ/2))^μ · e^(jμ(π − θ)/2)
/// ```
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, eqs. 3.5, 3.10.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactDifference(pub Order);

impl FrequencyResponse for ExactDifference {
    fn response(&self, theta: f64) -> Complex<f64> {
        let order = self.0.get();
        let magnitude = libm::pow(2.0 * libm::sin(0.5 * theta), order);
        let angle = 0.5 * order * (core::f64::consts::PI - theta);
        Complex::new(magnitude * libm::cos(angle), magnitude * libm::sin(angle))
    }
}

/// The delay of one sample, w = e^(−jθ).
pub(crate) fn delay(theta: f64) -> Complex<f64> {
    Complex::new(libm::cos(theta), -libm::sin(theta))
}

/// 1 − w without cancellation at low frequency: 2 sin²(θ/2) + j sin θ.
pub(crate) fn difference(theta: f64) -> Complex<f64> {
    let s = libm::sin(0.5 * theta);
    Complex::new(2.0 * s * s, libm::sin(theta))
}

/// (1 − w)^n for −2 ≤ n ≤ 2.
pub(crate) fn integer_difference(theta: f64, n: i32) -> Complex<f64> {
    let d = difference(theta);
    match n {
        0 => Complex::new(1.0, 0.0),
        1 => d,
        2 => d * d,
        -1 => d.inv(),
        _ => (d * d).inv(),
    }
}

/// Σ `c_j` w^j by Horner's rule, from the last coefficient to the first.
pub(crate) fn polynomial(
    coefficients: impl DoubleEndedIterator<Item = f64>,
    theta: f64,
) -> Complex<f64> {
    let w = delay(theta);
    coefficients
        .rev()
        .fold(Complex::new(0.0, 0.0), |sum, c| sum * w + c)
}

/// 1/(1 − (1 − d)·w): the sum v ← v + (x − d·v), read after it takes x in.
pub(crate) fn geometric(theta: f64, decay: f64) -> Complex<f64> {
    (difference(theta) + delay(theta) * decay).inv()
}
