//! Functions of time from the modulus M(s), by quadrature along a contour.
//! ```text
//! f(t) = (1/2πi) ∫ e^(st) F(s) ds ≈ Re Σ_k cₖ F(zₖ/t)/t        s = z/t on a Talbot contour
//! relaxation modulus  F = M(s)/s      creep compliance  F = 1/(s·M(s))      its integral  F = M(s)/s²
//! ```
//! Each F is analytic off the negative axis, for springs and dashpots as for spring-pots, so one contour serves all models and
//! all times: only zₖ^α changes with the model, only t^(−α) with the time. 28 points, half of them by symmetry, give 1e-12 of
//! F(1/t)/t; of a modulus that has fallen far below |M(1/t)|, as beyond a dashpot, correspondingly less.
//!
//! Source: L. N. Trefethen, J. A. C. Weideman, T. Schmelzer, *Talbot quadratures and rational approximations*, BIT 46, 2006,
//! equation of the modified contour.

use crate::elements::{Elements, Slope};
use crate::joint::{ELEMENTS, Joint, join, variables};
use num_complex::Complex64;

/// Points of the whole contour.
const POINTS: usize = 28;
/// Those above the real axis.
const HALF: usize = POINTS / 2;

/// The function of time that is computed from M(s).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The relaxation modulus, F = M(s)/s.
    Relaxation,
    /// The creep compliance, F = 1/(s·M(s)).
    Creep,
    /// The integral of the relaxation modulus, F = M(s)/s².
    Integral,
}

/// The contour, and a model on it.
#[derive(Clone, Debug)]
pub struct Contour {
    joint: Option<Joint>,
    quantity: Quantity,
    elements: Elements,
    /// ln zₖ as size and angle.
    ln_z: [(f64, f64); HALF],
    /// cₖ/zₖ, or cₖ/zₖ² for the integral.
    weight: [Complex64; HALF],
    power: [[Complex64; HALF]; ELEMENTS],
}

impl Contour {
    /// The contour of a network, for all times.
    #[must_use]
    pub fn new(joint: Option<Joint>, quantity: Quantity, elements: Elements) -> Self {
        // z(θ) = N(0.5017 θ cot 0.6407θ − 0.6122 + 0.2645iθ), θ_k = (2k + 1)π/N.
        const N: f64 = POINTS as f64;
        let mut contour = Self {
            joint,
            quantity,
            elements,
            ln_z: [(0.0, 0.0); HALF],
            weight: [Complex64::new(0.0, 0.0); HALF],
            power: [[Complex64::new(0.0, 0.0); HALF]; ELEMENTS],
        };
        for k in 0..HALF {
            let theta = (2 * k + 1) as f64 * core::f64::consts::PI / N;
            let turn = 0.6407 * theta;
            let cotangent = libm::cos(turn) / libm::sin(turn);
            let slope = 0.5017 * (cotangent - turn * (1.0 + cotangent * cotangent));
            let z = Complex64::new(0.5017 * theta * cotangent - 0.6122, 0.2645 * theta) * N;
            let dz = Complex64::new(slope, 0.2645) * N;
            // f(t) = Re Σ 2e^z z'/(iN) F(z/t)/t over the upper half.
            let growth = libm::exp(z.re);
            let exponential = Complex64::new(growth * libm::cos(z.im), growth * libm::sin(z.im));
            let c = exponential * dz / Complex64::new(0.0, 0.5 * N);
            contour.weight[k] = match quantity {
                Quantity::Relaxation | Quantity::Creep => c / z,
                Quantity::Integral => c / (z * z),
            };
            contour.ln_z[k] = (libm::log(libm::hypot(z.re, z.im)), libm::atan2(z.im, z.re));
        }
        for (i, powers) in contour.power.iter_mut().enumerate() {
            for (power, &(size, angle)) in powers.iter_mut().zip(&contour.ln_z) {
                let (order, grown) = (elements.order[i], libm::exp(elements.order[i] * size));
                *power = Complex64::new(libm::cos(order * angle), libm::sin(order * angle)) * grown;
            }
        }
        contour
    }

    /// The quantity at t = t₀·exp(`ln_time`), and its derivatives by the variables; for the integral in units of t₀.
    #[must_use]
    pub fn at(&self, ln_time: f64) -> Slope {
        let (joint, zero) = (self.joint, Complex64::new(0.0, 0.0));
        let mut size = [0.0; ELEMENTS];
        for (i, size) in size.iter_mut().enumerate() {
            if 2 * i < variables(joint) {
                *size = libm::exp(self.elements.ln_modulus[i] - self.elements.order[i] * ln_time);
            }
        }
        let mut value = 0.0;
        let (mut by_modulus, mut by_order) = ([0.0; ELEMENTS], [0.0; ELEMENTS]);
        for k in 0..HALF {
            let mut e = [zero; ELEMENTS];
            for i in 0..ELEMENTS {
                e[i] = self.power[i][k] * size[i];
            }
            let (modulus, derivatives) = join(joint, e);
            let weight = self.weight[k];
            let outer = match self.quantity {
                Quantity::Creep => {
                    let compliance = modulus.inv();
                    value += (weight * compliance).re;
                    -weight * compliance * compliance
                }
                Quantity::Relaxation | Quantity::Integral => {
                    value += (weight * modulus).re;
                    weight
                }
            };
            let ln_s = Complex64::new(self.ln_z[k].0 - ln_time, self.ln_z[k].1);
            for i in 0..ELEMENTS {
                // ∂M/∂aᵢ = eᵢ·∂M/∂eᵢ,  ∂M/∂αᵢ = eᵢ·ln(s·t₀)·∂M/∂eᵢ.
                let term = outer * derivatives[i] * e[i];
                by_modulus[i] += term.re;
                by_order[i] += (term * ln_s).re;
            }
        }
        let scale = match self.quantity {
            Quantity::Relaxation | Quantity::Creep => 1.0,
            Quantity::Integral => libm::exp(ln_time),
        };
        Slope::of(joint, scale, value, by_modulus, by_order)
    }
}

/// Storage and loss modulus at ω = exp(`ln_omega`)/t₀, with their derivatives by the variables.
#[must_use]
pub fn oscillation(joint: Option<Joint>, elements: &Elements, ln_omega: f64) -> [Slope; 2] {
    use core::f64::consts::FRAC_PI_2;
    let e = elements.at(joint, ln_omega, FRAC_PI_2);
    let (modulus, derivatives) = join(joint, e);
    let ln_s = Complex64::new(ln_omega, FRAC_PI_2);
    let mut by = [[0.0; ELEMENTS]; 4];
    for i in 0..ELEMENTS {
        let term = derivatives[i] * e[i];
        let turned = term * ln_s;
        (by[0][i], by[1][i]) = (term.re, turned.re);
        (by[2][i], by[3][i]) = (term.im, turned.im);
    }
    [
        Slope::of(joint, 1.0, modulus.re, by[0], by[1]),
        Slope::of(joint, 1.0, modulus.im, by[2], by[3]),
    ]
}
